"""What planning gave, and how every seed that was tried ended."""

from __future__ import annotations

from dataclasses import dataclass, field

from kinolab.search.graph import SearchGraph
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate

REFUSED = "verification_failed"  # the status of what the verifier refused
EXIT_CODES = {
    "solved": 0,
    "simulated": 0,
    "not_found": 3,
    "approximate": 4,
    "local_minimum": 4,  # 3 where it is no nearer than the start
    "verification_failed": 7,
    "interrupted": 130,
}


@dataclass(frozen=True)
class Attempt:
    """How the search with one seed ended.

    Attributes:
        seed: Seed of its random numbers.
        status: As of a plan, or ``ended`` where another seed had won or the user interrupted,
            or ``failed`` where its process or thread did not come to an end by itself.
        iterations: Number of extensions it tried.
        cost: Duration of the motion in [s], None where there is none.
        goal_distance: Norm of the goal errors at the end in SI units, None where that is unknown.
        after: Seconds from the beginning of the first search in its process or thread to its end.
        detail: A sentence where there is more to say.
        refused: How many motions it found that the verifier refused.
    """

    seed: int
    status: str
    iterations: int
    cost: float | None = None
    goal_distance: float | None = None
    after: float = 0.0
    detail: str = ""
    refused: int = 0


@dataclass(frozen=True, order=True)
class Improvement:
    """A verified motion on the way to a plan.

    Attributes:
        after: Seconds from the beginning of the first search in its process or thread, without
            what was compiled and loaded.
        duration: Of the motion in [s]; one that ends exactly in the goal's centre may take longer
            than the one that it was made of.
        goal_distance: Norm of the goal errors at the end, in SI units.
        by: What made it: ``search``, ``repair`` or ``shorten``.
        seed: Of the search that it began with.
    """

    after: float
    duration: float
    goal_distance: float
    by: str
    seed: int


@dataclass(frozen=True)
class Plan:
    """What planning gave.

    Attributes:
        status: ``solved`` (found and verified), ``approximate``, ``local_minimum``,
            ``not_found``, ``verification_failed`` or ``interrupted``.
        trajectory: The re-simulated motion, None where nothing was found.
        certificate: The outcome of all checks, None where nothing was found.
        planner: Name of the planner.
        seed: Seed of its random numbers.
        iterations: Number of extensions it tried until its first motion that was not refused.
        goal_distance: Norm of the goal errors at the end, in SI units.
        timings: Seconds per stage.
        statistics: What the planner counted.
        rejections: Fraction of all refused motions, by cause and by who is to blame.
        message: A sentence for the user.
        jobs: Number of searches at once.
        attempts: How every seed ended that was tried, this one's included.
        interrupted: Whether the user ended the search; a plan that was verified before is kept.
        improvements: All motions that were verified, in the order of time.
        graph: What the search explored that the motion began with; None where that is not kept.
        refused: How many motions the search found that the verifier refused, by the checks that
            they did not pass; the search went on.
    """

    status: str
    trajectory: Trajectory | None
    certificate: Certificate | None
    planner: str
    seed: int
    iterations: int
    goal_distance: float
    timings: dict[str, float] = field(default_factory=dict)
    statistics: dict[str, float] = field(default_factory=dict)
    rejections: dict[str, dict[str, float]] = field(default_factory=dict)
    message: str = ""
    jobs: int = 1
    attempts: tuple[Attempt, ...] = ()
    interrupted: bool = False
    improvements: tuple[Improvement, ...] = ()
    graph: SearchGraph | None = None
    refused: dict[str, int] = field(default_factory=dict)

    @property
    def exit_code(self) -> int:
        """What the command line returns."""
        if self.status == "local_minimum" and self.trajectory is None:
            return EXIT_CODES["interrupted" if self.interrupted else "not_found"]
        return EXIT_CODES["interrupted" if self.interrupted else self.status]

    @property
    def cost(self) -> float | None:
        """Duration in [s], None where nothing was found."""
        return None if self.trajectory is None else self.trajectory.duration

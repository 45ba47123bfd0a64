"""The proof that every machine within some bounds carries a plan out, or how far that is proved."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace

import numpy as np

from kinolab.concurrency.stages import doing
from kinolab.dynamics.model.flow_formulas import FlowFormulas
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.unwrapping import unwrapped
from kinolab.simulation.reference import OdeMotion, reference_motion
from kinolab.steering.tracker import LARGE_DEVIATION, Tracker
from kinolab.trajectory import Trajectory
from kinolab.verification.between_samples.dense_motion import DenseMotion
from kinolab.verification.tube.contact_search import ContactSearch
from kinolab.verification.tube.hazards import (
    Hazard,
    goal_excess,
    limit_hazards,
    wrapping_hazards,
)
from kinolab.verification.tube.held_feedback import HeldFeedback
from kinolab.verification.tube.reachability import PARTS, NominalMotion, Reachability, Tube
from kinolab.verification.tube.tube_poses import TubePoses
from kinolab.verification.tube.uncertainty import Uncertainty

# What is proved is at most so often halved, and then told to a sixteenth of itself.
HALVINGS, BISECTIONS = 8, 4


@dataclass(frozen=True, eq=False)
class TubeProof:
    """What is proved of a plan under an uncertainty.

    Attributes:
        uncertainty: What may differ from the plan's assumptions.
        large: As of the ``Tracker`` whose gains act.
        tube: Contains all motions, as far as it is proved.
        hazards: What is not excluded, the earliest first.
        excess: How far the end is from the goal at most, in tolerances; infinite if not known.
        spare: Clearance that is left at least, in [m], as far as nothing is touched.
        enough: Largest ``excess`` that is in the goal.
    """

    uncertainty: Uncertainty
    large: float
    tube: Tube
    hazards: tuple[Hazard, ...]
    excess: float
    spare: float
    enough: float

    @property
    def proved(self) -> bool:
        """Whether every machine within the bounds carries the plan out."""
        return self.tube.complete and not self.hazards and self.excess <= self.enough

    @property
    def proved_until(self) -> float:
        """Until when nothing can go wrong, in [s]."""
        return min([self.tube.proved_until, *(hazard.time for hazard in self.hazards)])

    @property
    def first(self) -> Hazard | None:
        """What is not excluded that could happen first; None if everything is."""
        until = self.tube.proved_until
        if not self.tube.complete:
            what = (
                "beyond this time no bound is found: deviations may grow too fast for the feedback"
            )
            return min((*self.hazards, Hazard(until, what)), key=lambda hazard: hazard.time)
        if self.hazards or self.proved:
            return self.hazards[0] if self.hazards else None
        what = f"the end could be {self.excess:.3g} tolerances from the goal"
        return Hazard(until, what)


class Prover:
    """Proves what a plan's feedback makes of uncertain machines; what is nominal is proved once.

    Args:
        large: As of the ``Tracker``.

    Raises:
        InputError: If the machine is of a kind for which there is no proof.
    """

    def __init__(
        self, problem: PlanningTask, trajectory: Trajectory, *, large: float = LARGE_DEVIATION
    ) -> None:
        require_provable(problem, has_steps=len(trajectory.u) > 0)
        self.problem, self.large = problem, large
        plan, model = unwrapped(problem, trajectory), problem.whole or problem.model
        self.plan, self.tracker = plan, Tracker.along(problem, plan, large=large)
        motion = reference_motion(problem, plan.x[0], plan.t, plan.inputs)
        assert isinstance(motion, OdeMotion)
        x = problem.space.nearest(plan.x, motion.x)
        inner = _inner(problem, motion, plan.t, x)
        nominal = NominalMotion(plan.t, x, np.array(plan.inputs), model.parameter_vector(), inner)
        self.about = Reachability(FlowFormulas.of(model), nominal, problem.scales)
        self.contacts = ContactSearch.of(DenseMotion(problem, plan, motion))

    def retuned(self, large: float) -> Prover:
        """Return a prover of the same plan under other gains."""
        other = copy.copy(self)
        other.large, other.tracker = large, Tracker.along(self.problem, self.plan, large=large)
        return other

    def expected(self, uncertainty: Uncertainty) -> Tube:
        """Return the linear part of a tube whose inputs have no limits; it proves nothing."""
        # times an input's range: limits that feedback without limits does not reach
        radius = 1e6 * np.ptp(self.tracker.limits, axis=1)[:, None] * np.array([-1.0, 1.0])
        free = [replace(one, limits=radius) for one in self._feedback(uncertainty)]
        with np.errstate(all="ignore"):  # of gains that do not keep deviations small
            return self.about.linear_tube(free, uncertainty.radii(self.problem))

    def prove(self, uncertainty: Uncertainty) -> TubeProof:
        """Prove what can be proved under an uncertainty.

        Raises:
            InputError: If it makes no sense for the machine.
        """
        uncertainty.require(self.problem)
        problem, p = self.problem, uncertainty.radii(self.problem)
        tube = self.about.tube(self._feedback(uncertainty), p)
        enough = 1.0 / (1.0 - problem.scenario.goal.reserve)
        if not tube.steps:
            return TubeProof(uncertainty, self.large, tube, (), np.inf, np.inf, enough)
        poses = TubePoses.of(problem, self.about, tube, p)
        contact, spare = self.contacts.first(poses.displacements(problem))
        found = [
            *([contact] if contact else []),
            *limit_hazards(problem, tube, poses),
            *wrapping_hazards(problem, tube, uncertainty.measurement_radii(problem)),
        ]
        hazards = tuple(sorted(found, key=lambda hazard: hazard.time))
        excess = goal_excess(problem, tube, poses) if tube.complete else np.inf
        return TubeProof(uncertainty, self.large, tube, hazards, excess, spare, enough)

    def largest(self, uncertainty: Uncertainty) -> tuple[float, TubeProof | None]:
        """Return a share of an uncertainty that is proved, nearly the largest, and its proof."""
        low, high, best = 0.5, 1.0, None
        for _ in range(HALVINGS):
            best = self._proved(uncertainty.times(low), low)
            if best is not None:
                break
            low, high = 0.5 * low, low
        for _ in range(BISECTIONS if best is not None else 0):
            middle = 0.5 * (low + high)
            found = self._proved(uncertainty.times(middle), middle)
            low, high = (middle, high) if found is not None else (low, middle)
            best = found or best
        return (low if best is not None else 0.0), best

    def _proved(self, uncertainty: Uncertainty, share: float) -> TubeProof | None:
        """Return a proof that holds to the end; None where there is none."""
        doing(f"proving {share:.3g} of what was asked for")
        found = self.prove(uncertainty)
        return found if found.proved else None

    def _feedback(self, uncertainty: Uncertainty) -> list[HeldFeedback]:
        tracker, problem = self.tracker, self.problem
        noise = uncertainty.measurement_radii(problem)
        disturbance = uncertainty.input_radii(problem)
        x = self.about.nominal.x
        return [
            HeldFeedback(
                tracker.gains[k],
                tracker.u[k],
                x[k] - tracker.x[k],
                tracker.limits,
                noise,
                disturbance,
            )
            for k in range(len(self.about.nominal.u))
        ]


def _inner(problem: PlanningTask, motion: OdeMotion, t: Array, x: Array) -> Array:
    """Return the states of a motion where parts of its steps begin, shape (N, PARTS, nx)."""
    share, found = np.arange(1, PARTS) / PARTS, []
    for k, span in enumerate(np.diff(t)):
        within = motion.between(k, t[k] + share * span)
        near = problem.space.nearest(np.tile(x[k], (PARTS - 1, 1)), within)
        found.append(np.vstack([x[k], near]))
    return np.array(found)


def require_provable(problem: PlanningTask, *, has_steps: bool = True) -> None:
    """Refuse what tubes cannot enclose.

    Args:
        problem: The machine, and what it is to do.
        has_steps: Whether its motion has any.

    Raises:
        InputError: With every reason.
    """
    machine, model, name = problem.machine, problem.whole or problem.model, problem.machine.name
    remedy = "plan execute tries it on a hundred machines."
    discrete = problem.scenario.integration.truth == "discrete"
    reasons = {
        f"{name} switches between modes.": bool(machine.modes),
        f"{name} has a feedback law of its own.": model.plant is not model,
        "its scenario takes an integrator's steps for the truth.": discrete,
        f"{name} closes loops, and other parameters would open them.": machine.closes_loops,
        "it has goals on the way.": bool(problem.via),
        "its cost is a state.": problem.cost_entry is not None,
        "it has no steps.": not has_steps,
    }
    mistakes = [
        Mistake("prove", f"no tube is made: {why}", remedy) for why, on in reasons.items() if on
    ]
    if mistakes:
        raise InputError(mistakes)


def prove(
    problem: PlanningTask,
    trajectory: Trajectory,
    uncertainty: Uncertainty,
    *,
    large: float = LARGE_DEVIATION,
) -> TubeProof:
    """Prove what can be proved of a plan under an uncertainty.

    Args:
        uncertainty: What may differ from the plan's assumptions.
        large: Deviation that the gains answer with a quarter of the inputs' range, as a fraction of
            one over each state's weight in the metric.

    Raises:
        InputError: If the machine or the uncertainty is none for which there is a proof.
    """
    return Prover(problem, trajectory, large=large).prove(uncertainty)

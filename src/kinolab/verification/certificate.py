"""Verify plans by a re-simulation that shares nothing with the planners.

DOP853 integrates the motion from the start under the stored inputs; goal, limits and
collisions are checked along it, and each stored knot must follow from the previous one.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from kinolab.arguments import require_fit
from kinolab.errors import KinolabError
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import (
    MAX_ERROR_AMPLIFICATION,
    DivergedError,
    ReferenceMotion,
    price,
)
from kinolab.trajectory import Trajectory
from kinolab.verification.between_samples.clearance_margin import ClearanceMargin, least_clearance
from kinolab.verification.between_samples.clearance_search import Told
from kinolab.verification.between_samples.dense_motion import TooFastError
from kinolab.verification.check_conditions import CheckConditions
from kinolab.verification.checks import (
    CHECKS,
    CONDUCT,
    DYNAMICS,
    PRECONDITIONS,
    CheckFunction,
)
from kinolab.verification.checks.check import Check, CheckContext, require_motion_of
from kinolab.verification.checks.contacts import collision


@dataclass(frozen=True)
class Certificate:
    """Results of all checks of a trajectory.

    Attributes:
        checks: In order.
        margin: Smallest clearance along the motion; None if it collides, cannot be integrated or is
            too fast for it to be found, or if there is nothing to collide with.
        conditions: What the checks depend on.
        cost: What the motion costs by [objective], integrated by the verifier; None without
            one, and of a motion that does not pass.
        reached: When it reaches each of several goals, in [s]; empty where there is one.
    """

    checks: tuple[Check, ...]
    margin: ClearanceMargin | None = None
    conditions: CheckConditions | None = None
    cost: float | None = None
    reached: tuple[float, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks that did not pass."""
        return tuple(check for check in self.checks if not check.passed)

    def __str__(self) -> str:
        """Say how many checks passed, which did not, and how near the motion came to anything."""
        passed = len(self.checks) - len(self.failures)
        lines = [f"{passed} of {len(self.checks)} checks passed", *map(str, self.failures)]
        return "\n  ".join(lines if self.margin is None else [*lines, str(self.margin)])


def verify(
    problem: PlanningTask,
    trajectory: Trajectory,
    told: Told | None = None,
    *,
    thorough: bool = False,
    margin: bool = True,
) -> Certificate:
    """Check that a trajectory solves a problem: dynamics, limits, goal and collisions.

    No motion raises, whatever its numbers are: what cannot be judged is not true.

    Args:
        trajectory: To be checked.
        told: Called now and then with what is being done, in words.
        thorough: Whether the equations of motion, derived a second way, are compared with the
            compiled ones along the whole motion; otherwise they are at a sample of rows.
        margin: Whether to find the smallest clearance, which no check needs.

    Raises:
        InputError: If an argument is something else, or the trajectory of another machine.
    """
    require_fit("verify problem", PlanningTask, problem)
    require_fit("verify trajectory", Trajectory, trajectory)
    require_motion_of(problem.model, trajectory, "verify trajectory")
    context = CheckContext.of(problem, trajectory, told, thorough=thorough)
    checks = tuple(_checked(context, CHECKS))
    free = any(check.name == "collision" and check.passed for check in checks)
    nearest = _margin(context) if margin and free else None
    sound = all(check.passed for check in checks)
    cost = price(problem, trajectory) if sound else None
    reached = context.reached if sound else ()
    return Certificate(checks, nearest, CheckConditions.of(problem), cost, reached)


def dynamics_checks(problem: PlanningTask, trajectory: Trajectory) -> tuple[Check, ...]:
    """Check start, time, defects, constraints, inputs, requirements and error growth."""
    return tuple(_checked(CheckContext.of(problem, trajectory), PRECONDITIONS | DYNAMICS))


def collision_check(problem: PlanningTask, trajectory: Trajectory) -> Check:
    """Check the re-simulated motion for collisions."""
    context = CheckContext(problem, trajectory)
    for check in _checked(context, PRECONDITIONS):
        if not check.passed:
            return check
    try:
        return collision(context)
    except KinolabError as error:
        return Check("collision", math.inf, 0.0, False, str(error))


def conduct_checks(
    problem: PlanningTask, trajectory: Trajectory, motion: ReferenceMotion
) -> tuple[Check, ...]:
    """Check requirements, limits, goal and collisions along a given motion, not its dynamics.

    Args:
        problem: Requirements, limits, goal and obstacles.
        motion: The motion under these inputs.
    """
    return tuple(_checked(CheckContext(problem, trajectory, motion), CONDUCT))


def _checked(context: CheckContext, selected: Collection[CheckFunction]) -> Iterator[Check]:
    """Run the selected checks in order, as far as the trajectory can be integrated."""
    sound = True
    for check in (one for one in CHECKS if one in selected):
        if not (sound or check in PRECONDITIONS):
            return
        try:
            with np.errstate(all="ignore"):  # numbers of a false motion may be of any size
                made = check(context)
        except DivergedError as error:
            limit = MAX_ERROR_AMPLIFICATION
            yield Check("error growth", math.inf, limit, False, str(error))
            yield Check("motion", math.inf, 0.0, False, str(error))
            return
        except (KinolabError, TooFastError) as error:  # no equations, no law, no samples
            name = check.__name__.replace("_", " ")
            made = Check(name, math.inf, 0.0, False, str(error))
        if made is not None:
            sound = sound and (made.passed or check not in PRECONDITIONS)
            yield made


def _margin(context: CheckContext) -> ClearanceMargin | None:
    """Return the smallest clearance; None if the motion is too fast for it to be found."""
    try:
        with np.errstate(all="ignore"):
            return least_clearance(context.clearance_search)
    except TooFastError:
        return None

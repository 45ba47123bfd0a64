"""Sentences about a planner's motion that failed verification."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.model.units import state_units
from kinolab.errors import SingularError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import ReferenceMotion, trajectory_under
from kinolab.simulation.resimulated_goal import BROKEN, MISSED
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory
from kinolab.verification.certificate import conduct_checks
from kinolab.verification.lower_bound import duration_bound


def verification_sentences(problem: PlanningTask, plan: PlanResult) -> Iterator[str]:
    """Say where the planner's steps and the re-simulated motion disagree."""
    if plan.status == "verification_failed":
        yield _refusal(problem, plan)
        yield from _too_long(problem, plan)
    misses = int(plan.statistics.get(MISSED, 0))
    if misses:
        # 4 times the substeps: the error of a method of order 4 is 256 times as small
        finer = 4 * problem.scenario.integration.substeps
        yield (
            f"The planner's steps reached the goal {_times(misses)} where the true motion misses "
            f"it: make them finer, with --set integration.substeps={finer}, or shorten "
            "[integration] step."
        )
    broken = int(plan.statistics.get(BROKEN, 0))
    if broken:
        yield (
            f"The planner reached the goal {_times(broken)} by a motion that in truth touches "
            "something, or makes errors grow so much that it cannot be repeated."
        )


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _refusal(problem: PlanningTask, plan: PlanResult) -> str:
    """Say which checks a motion failed, and whether the planner's own steps pass them."""
    if plan.certificate is None or plan.trajectory is None:
        return f"Verification refused the motion found: {plan.message}"
    failures = plan.certificate.failures
    said = "; ".join(f"{c.name}: {c.detail}" if c.detail else c.name for c in failures)
    refusal = f"Verification refused the motion found ({said})"
    own = own_motion(problem, plan.trajectory)
    if own is None:
        return f"{refusal}."
    passed = {check.name for check in conduct_checks(problem, *own) if check.passed}
    if not all(check.name in passed for check in failures):
        return f"{refusal}."
    return (
        f"{refusal}, which the planner's own steps pass. They lead up to "
        f"{_apart(problem, own[0].x, plan.trajectory.x)} away from the true motion: shorten "
        "[integration] step."
    )


def _too_long(problem: PlanningTask, plan: PlanResult) -> Iterator[str]:
    """Say of a motion that takes longer than max_time whether a shorter one may exist."""
    failures = plan.certificate.failures if plan.certificate else ()
    section = problem.scenario.objective
    if section is None or all(check.name != "duration" for check in failures):
        return
    bound = duration_bound(problem)
    if section.max_time is not None and bound.seconds > section.max_time:
        yield (
            f"No plan takes less than {bound.seconds:.3g} s, which is proved ({bound.reason}): "
            f"raise [objective] max_time, which is {section.max_time:g} s."
        )
    else:
        yield (
            f"A motion that is short enough is not ruled out: no plan takes less than "
            f"{bound.seconds:.3g} s, and no more is proved. More time to shorten this one may help "
            "(--time-limit, --set planner.improve=30)."
        )


def own_motion(
    problem: PlanningTask, trajectory: Trajectory
) -> tuple[Trajectory, ReferenceMotion] | None:
    """Return the motion of a trajectory's inputs under the planner's integrator.

    None if it fails, or if it is itself the reference.
    """
    settings, model = problem.scenario.integration, problem.model
    t, inputs = trajectory.t, trajectory.inputs
    if settings.truth == "discrete":
        return None
    method, substeps = settings.method, settings.substeps
    try:
        x = model.steps(problem.start, inputs, np.diff(t), method=method, substeps=substeps)
    except SingularError:
        return None
    if not np.isfinite(x).all():
        return None
    return trajectory_under(model, t, x, inputs), OwnMotion(t, x, problem, inputs)


@dataclass(frozen=True)
class OwnMotion(ReferenceMotion):
    """The motion of a planner's integrator, of shorter steps between the knots."""

    problem: PlanningTask
    inputs: Array  # shape (N, nu)

    def along(self, intervals: NDArray[np.intp], times: Array) -> Array:
        """Evaluate the motion at times, each in its own interval; shape (times, nx)."""
        settings, model = self.problem.scenario.integration, self.problem.model
        return model.step(
            self.x[intervals], self.inputs[intervals], times - self.t[intervals],
            method=settings.method, substeps=settings.substeps,
        )  # fmt: skip


def _apart(problem: PlanningTask, own: Array, true: Array) -> str:
    """Describe the largest scaled difference between the knots of two motions."""
    errors = np.abs(problem.space.difference(true, own) / problem.scales)
    i = int(np.unravel_index(int(errors.argmax()), errors.shape)[1])
    off, unit = errors[:, i].max() * problem.scales[i], state_units(problem.model)[i]
    return f"{off:.3g} {unit} ({problem.model.state_names[i]})".replace("  ", " ")

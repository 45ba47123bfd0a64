"""Is a plan true? Judged on a re-simulation that shares nothing with the planners.

The motion is integrated by SciPy's DOP853 from the start with the stored inputs; goal, limits and
collisions are judged on that curve, and every stored knot must follow from the one before.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.motion import DivergedError, Motion, follow, interval
from kinolab.problem import Problem
from kinolab.trajectory import Trajectory

Array: TypeAlias = NDArray[np.float64]

DEFECT = 1e-6  # of a state's scale: how far a knot may lie from where the one before leads
CONSTRAINT = 1e-9  # [m/s] or [rad/s]; constraints hold by construction, so only rounding remains
EXCESS = 1e-9  # by how much a limit may be passed, in its own unit: rounding only
SPACING = 0.01  # [m] of motion between two collision checks, at most
GROWTH = 1e6  # a motion that amplifies errors more than this needs a stored feedback law
NUDGE = 1e-6  # of a state's scale: the disturbance whose growth is measured
MOST_SAMPLES = 100_000  # of one interval; a machine faster than that is not checked but failed


@dataclass(frozen=True)
class Check:
    """One thing that was checked.

    Attributes:
        name: What was checked.
        value: The worst that was found.
        limit: The largest value that passes.
        passed: Whether it passed.
        detail: When, where and by how much, in words; empty where there is nothing to say.
    """

    name: str
    value: float
    limit: float
    passed: bool
    detail: str = ""

    def __str__(self) -> str:
        verdict = "passed" if self.passed else "FAILED"
        note = f": {self.detail}" if self.detail else ""
        return f"{verdict} {self.name} ({self.value:.3g}, limit {self.limit:.3g}){note}"


@dataclass(frozen=True)
class Certificate:
    """The outcome of all checks of a trajectory."""

    checks: tuple[Check, ...]

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks that did not pass."""
        return tuple(check for check in self.checks if not check.passed)


def verify(problem: Problem, trajectory: Trajectory) -> Certificate:
    """Check that a trajectory solves a problem: dynamics, limits, goal and collisions."""
    feasible = dynamics_checks(problem, trajectory)
    try:
        motion = _whole(problem, trajectory)
    except DivergedError as error:
        return Certificate((*feasible, Check("motion", math.inf, 0.0, False, str(error))))
    return Certificate(
        (
            *feasible,
            _drift(problem, trajectory, motion, feasible[-1].value),
            *_limits(problem, trajectory, motion),
            _goal(problem, motion),
            _collision(problem, trajectory, motion),
        )
    )


def dynamics_checks(problem: Problem, trajectory: Trajectory) -> tuple[Check, ...]:
    """Check start, time, defects, constraints, inputs and the growth of errors."""
    return (
        _start(problem, trajectory),
        _time(trajectory),
        _defects(problem, trajectory),
        _constraints(problem, trajectory),
        _inputs(problem, trajectory),
        _error_growth(problem, trajectory),
    )


def collision_check(problem: Problem, trajectory: Trajectory) -> Check:
    """Check that the re-simulated motion touches nothing."""
    try:
        motion = _whole(problem, trajectory)
    except DivergedError as error:
        return Check("collision", math.inf, 0.0, False, str(error))
    return _collision(problem, trajectory, motion)


def _whole(problem: Problem, trajectory: Trajectory) -> Motion:
    return follow(problem.model, trajectory.x[0], trajectory.t, trajectory.u, problem.scales)


def _difference(problem: Problem, a: Array, b: Array) -> Array:
    """Return a - b in units of the states' scales, angles on the circle."""
    difference = np.asarray(a - b)
    wrapped = (difference + np.pi) % (2 * np.pi) - np.pi
    result: Array = np.where(problem.circular, wrapped, difference) / problem.scales
    return result


def _start(problem: Problem, trajectory: Trajectory) -> Check:
    errors = np.abs(_difference(problem, trajectory.x[0], problem.start))
    k = int(errors.argmax())
    detail = _named(problem, k, trajectory.x[0, k], problem.start[k]) if errors[k] > EXCESS else ""
    return _check("start", float(errors[k]), EXCESS, detail)


def _named(problem: Problem, k: int, found: float, wanted: float) -> str:
    return f"{problem.model.state_names[k]} is {found:.9g} where {wanted:.9g} is due"


def _time(trajectory: Trajectory) -> Check:
    """Times start at 0 and increase; the value counts the steps that do not."""
    bad = np.flatnonzero(~(np.diff(trajectory.t) > 0))
    late = abs(float(trajectory.t[0])) > 0
    detail = f"row {bad[0] + 1} does not come after the row before" if bad.size else ""
    return _check("time", float(bad.size + late), 0.0, detail or ("t starts late" if late else ""))


def _defects(problem: Problem, trajectory: Trajectory) -> Check:
    """Integrate from every stored knot to the next and compare."""
    worst, detail = 0.0, ""
    for k, held in enumerate(trajectory.u):
        span = (float(trajectory.t[k]), float(trajectory.t[k + 1]))
        try:
            piece = interval(problem.model, trajectory.x[k], span, held, problem.scales)
        except (DivergedError, ValueError) as error:
            return Check("dynamics", math.inf, DEFECT, False, f"at t = {span[0]:.6g} s: {error}")
        errors = np.abs(_difference(problem, trajectory.x[k + 1], piece(span[1])))
        i = int(errors.argmax())
        if not errors[i] <= worst:
            worst = float(errors[i])
            named = _named(problem, i, trajectory.x[k + 1, i], piece(span[1])[i])
            detail = f"at t = {span[1]:.6g} s {named}"
    return _check("dynamics", worst, DEFECT, detail if worst > DEFECT else "")


def _constraints(problem: Problem, trajectory: Trajectory) -> Check:
    held = np.vstack([trajectory.u, trajectory.u[-1:]]) if len(trajectory.u) else trajectory.u
    if not problem.system.constraints or not len(held):
        return _check("constraints", 0.0, CONSTRAINT, "")
    residual = np.abs(problem.model.constraint_residual(trajectory.x, held))
    k, i = np.unravel_index(int(residual.argmax()), residual.shape)
    name = problem.system.constraints[int(i)].name
    worst = float(residual[k, i])
    detail = f"at t = {trajectory.t[k]:.6g} s {name} is broken" if worst > CONSTRAINT else ""
    return _check("constraints", worst, CONSTRAINT, detail)


def _inputs(problem: Problem, trajectory: Trajectory) -> Check:
    lower, upper = problem.model.control_bounds.T
    if not trajectory.u.size:
        return _check("inputs", 0.0, EXCESS, "")
    excess = np.maximum(trajectory.u - upper, lower - trajectory.u)
    excess = np.where(np.isfinite(excess), excess, np.inf)
    k, i = np.unravel_index(int(excess.argmax()), excess.shape)
    worst = max(float(excess[k, i]), 0.0)
    detail = (
        f"at t = {trajectory.t[k]:.6g} s {problem.model.control_names[int(i)]} is "
        f"{trajectory.u[k, i]:.9g}, outside {lower[i]:g} to {upper[i]:g}"
    )
    return _check("inputs", worst, EXCESS, detail if worst > EXCESS else "")


def _error_growth(problem: Problem, trajectory: Trajectory) -> Check:
    """Nudge the start and see how much farther apart the two motions end."""
    nudge = np.random.default_rng(0).normal(size=problem.model.nx)
    nudge *= NUDGE / np.linalg.norm(nudge)
    try:
        near, far = (
            follow(problem.model, start, trajectory.t, trajectory.u, problem.scales)
            for start in (trajectory.x[0], trajectory.x[0] + nudge * problem.scales)
        )
    except DivergedError as error:
        return Check("error growth", math.inf, GROWTH, False, str(error))
    apart = (far.x - near.x) / problem.scales
    growth = float(np.linalg.norm(apart, axis=1).max() / NUDGE)
    detail = "too sensitive to be replayed without feedback" if growth > GROWTH else ""
    return _check("error growth", growth, GROWTH, detail)


def _drift(problem: Problem, trajectory: Trajectory, motion: Motion, growth: float) -> Check:
    """Compare the stored knots with the motion from the start.

    Every knot may add a defect, and every defect grows as the motion makes errors grow.
    """
    errors = np.abs(_difference(problem, trajectory.x, motion.x))
    worst = float(errors.max())
    k = int(errors.max(axis=1).argmax())
    limit = DEFECT * len(trajectory.t) * max(growth, 1.0)
    detail = f"largest at t = {trajectory.t[k]:.6g} s" if worst > limit else ""
    return _check("drift", worst, limit, detail)


def _limits(problem: Problem, trajectory: Trajectory, motion: Motion) -> Iterator[Check]:
    """Check the limits of states, rates and workspace on the re-simulated curve."""
    worst, detail = 0.0, ""
    for time, x, _ in _samples(problem, trajectory, motion):
        for name, value, lower, upper in problem.limit_violations(x):
            excess = max(value - upper, lower - value)
            if excess > worst:
                worst = excess
                detail = f"at t = {time:.6g} s {name} is {value:.9g}, "
                detail += f"outside {lower:g} to {upper:g}"
    yield _check("limits", worst, EXCESS, detail)


def _goal(problem: Problem, motion: Motion) -> Check:
    final = motion.x[-1]
    excess = problem.goal_excess(final)
    deviations = problem.goal.deviations(final)
    parts = [
        f"{problem.model.state_names[i]} is off by {abs(deviation):.4g}"
        for i, deviation, tolerance in zip(
            problem.goal.indices, deviations, problem.goal.tolerances, strict=True
        )
        if not abs(deviation) <= tolerance
    ]
    detail = "; ".join(parts) or "a point or an axis misses its target"
    return _check("goal", excess, 1.0, detail if not excess <= 1.0 else "")


def _collision(problem: Problem, trajectory: Trajectory, motion: Motion) -> Check:
    """Ask FCL along the curve, at no more than SPACING of motion of any point in between."""
    checker = problem.checker()
    hits, detail = 0, ""
    for time, x, _ in _samples(problem, trajectory, motion):
        poses = problem.frames(x)
        if checker.collides(poses):
            hits += 1
            if not detail:
                contact = checker.contacts(poses)[0]
                detail = f"at t = {time:.6g} s {contact.body} {contact.kind} {contact.obstacle}"
    return _check("collision", float(hits), 0.0, detail)


def _samples(
    problem: Problem, trajectory: Trajectory, motion: Motion
) -> Iterator[tuple[float, Array, Array]]:
    """Yield (time, state, inputs) so densely that no point moves more than SPACING in between."""
    for k, held in enumerate(trajectory.u):
        span = float(motion.t[k + 1] - motion.t[k])
        probes = motion.between(k, np.linspace(motion.t[k], motion.t[k + 1], 5))
        fastest = _fastest(problem, probes, held)
        count = min(math.ceil(1.2 * fastest * span / SPACING) + 1, MOST_SAMPLES)
        times = np.linspace(motion.t[k], motion.t[k + 1], count, endpoint=False)
        for time, x in zip(times, motion.between(k, times), strict=True):
            yield float(time), x, held
    last = trajectory.u[-1] if len(trajectory.u) else np.zeros(problem.model.nu)
    yield float(motion.t[-1]), motion.x[-1], last


def _fastest(problem: Problem, states: Array, held: Array) -> float:
    speeds: Any = problem.model.point_speed(states, held)
    return float(np.max(speeds, initial=0.0))


def _check(name: str, value: float, limit: float, detail: str) -> Check:
    return Check(name, value, limit, bool(value <= limit), detail)

"""The true motion: SciPy's DOP853 with the inputs held, independent of any planner's integrator.

Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.5.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from kinolab.dynamics import Model
from kinolab.dynamics.codegen.state_space import StateSpace
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.errors import KinolabError, SingularError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory

RTOL = 1e-9
ATOL = 1e-11  # per unit of a coordinate's scale; three orders below what the check accepts

# a motion that amplifies errors more than this needs a stored feedback law
MAX_ERROR_AMPLIFICATION = 1e6
PERTURBATION = 1e-6  # of a state's scale: the disturbance whose growth is measured


class DivergedError(KinolabError):
    """A motion could not be followed to its end; ``.time`` says how far it went, in [s]."""

    exit_code = 7

    def __init__(self, time: float, reason: str) -> None:
        self.time = time
        super().__init__(f"the motion cannot be followed beyond t = {time:.6g} s: {reason}")


@dataclass(frozen=True)
class ReferenceMotion:
    """A continuous motion, one interpolant per knot interval."""

    t: Array
    x: Array  # states at the knots, shape (N+1, nx)
    pieces: Sequence[Any]

    def between(self, k: int, times: Array) -> Array:
        """Return the states at times within interval k, shape (times, nx)."""
        states: Array = self.pieces[k](times).T
        return states

    def along(self, intervals: NDArray[np.intp], times: Array) -> Array:
        """Return the states at times, each within an interval of its own, shape (times, nx).

        Args:
            intervals: In order, shape (times,).
            times: In [s], shape (times,).
        """
        if not len(times):
            return np.empty((0, self.x.shape[1]))
        cuts = np.flatnonzero(np.diff(intervals)) + 1
        firsts = intervals[np.concatenate([[0], cuts])].tolist()
        parts = zip(firsts, np.split(times, cuts), strict=True)
        return np.concatenate([self.between(k, part) for k, part in parts])


@dataclass(frozen=True)
class MapMotion(ReferenceMotion):
    """A motion whose states are joined by straight ways: chords."""

    space: StateSpace

    def along(self, intervals: NDArray[np.intp], times: Array) -> Array:
        """Return the states at times, each within an interval of its own, shape (times, nx)."""
        begin, end = self.t[intervals], self.t[intervals + 1]
        fraction = ((times - begin) / (end - begin))[:, None]
        path = self.x[intervals + 1] - self.x[intervals]
        return self.space.retract(self.x[intervals], fraction * path)


def follow(
    model: Model, start: Array, t: Array, u: Array, scales: Array, *, between: bool = True
) -> ReferenceMotion:
    """Integrate from a start with the inputs held between the times t.

    Where the machine has feedback, it is asked at every knot what its inputs are. Constraints of
    position are differentiated away in the equations of motion: what an interval has drifted off
    them is taken back at its end, before the next one begins.

    Args:
        model: The compiled machine.
        start: State at t[0], shape (nx,).
        t: Times of the knots in [s], shape (N+1,).
        u: Inputs per interval, or references, shape (N, nu).
        scales: What counts as large, per entry of the state, shape (nx,).
        between: Whether anybody will ask for states between the knots.

    Raises:
        DivergedError: If the integrator stops before the end.

    Source: Hairer, Wanner, Solving ODEs II, 2nd ed., section VII.2 (index reduction, projection).
    """
    states, pieces = [np.asarray(start, dtype=float)], []
    loops = any(isinstance(c, PositionConstraint) for c in model.system.constraints)
    for k, held in enumerate(u):
        try:
            acting = model.plant_inputs(states[-1], held)
        except KinolabError as error:
            raise DivergedError(float(t[k]), str(error)) from error
        span = (float(t[k]), float(t[k + 1]))
        end, piece = interval(model.plant, states[-1], span, acting, scales, between=between)
        states.append(model.plant.project(end) if loops else end)
        pieces.append(piece)
    return ReferenceMotion(np.asarray(t, dtype=float), np.array(states), pieces)


def interval(
    model: Model,
    start: Array,
    span: tuple[float, float],
    held: Array,
    scales: Array,
    *,
    between: bool,
    **parameters: float,
) -> tuple[Array, Any]:
    """Integrate a machine without feedback; return the last state, and SciPy's dense output.

    ``start``, ``scales`` and the last state have shape (nx,), the inputs ``held`` (nu,).

    Parameters by keyword override the machine's own.

    Raises:
        DivergedError: If the integrator stops before the end.
    """
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # what diverges is reported below
            result = solve_ivp(
                model.rate_under(held, **parameters),
                span,
                start,
                method="DOP853",
                rtol=RTOL,
                atol=ATOL * scales,
                dense_output=between,
            )
    except KinolabError as error:
        raise DivergedError(span[0], str(error)) from error
    if not result.success or not np.isfinite(result.y[:, -1]).all():
        raise DivergedError(float(result.t[-1]), str(result.message))
    return result.y[:, -1], result.sol


def follow_map(
    model: Model, start: Array, t: Array, u: Array, method: str, substeps: int = 1
) -> ReferenceMotion:
    """Apply the integrator's own step as the truth; between knots the state is interpolated.

    ``start`` has shape (nx,), the times ``t`` in [s] (N+1,), the inputs ``u`` (N, nu).

    Raises:
        DivergedError: If a step fails.
    """
    times = np.asarray(t, dtype=float)
    try:
        x = model.steps(start, u, np.diff(times), method=method, substeps=substeps)
    except SingularError as error:
        raise DivergedError(float(times[error.row]), str(error)) from error
    ends = zip(pairwise(times.tolist()), x[:-1], x[1:], strict=True)
    pieces = [Chord(span, begin, end, model.space) for span, begin, end in ends]
    return MapMotion(times, x, pieces, model.space)


@dataclass(frozen=True, eq=False)
class Chord:
    """A straight way between two states, with the interface of SciPy's dense output.

    Attributes:
        span: Times of its ends, in [s].
        begin: State at its beginning, shape (nx,).
        end: State at its end, shape (nx,).
        space: Of the states; quaternions stay of unit length.
    """

    span: tuple[float, float]
    begin: Array
    end: Array
    space: StateSpace

    @property
    def ts(self) -> Array:
        """Times at which it begins and ends."""
        return np.array(self.span)

    def __call__(self, times: float | Array) -> Array:
        """Return the state at a time, shape (nx,), or the states at times, shape (nx, times)."""
        fraction = (np.asarray(times) - self.span[0]) / (self.span[1] - self.span[0])
        return self.space.retract(self.begin, fraction[..., None] * (self.end - self.begin)).T


def reference_motion(
    problem: PlanningTask, start: Array, t: Array, u: Array, *, between: bool = True
) -> ReferenceMotion:
    """Return the motion that counts: the differential equation's, or the integrator's own map.

    Args:
        problem: Says which, below [integration].
        start: State at t[0], shape (nx,).
        t: Times of the knots in [s], shape (N+1,).
        u: Inputs per interval, shape (N, nu).
        between: Whether anybody will ask for states between the knots, which takes longer.

    Raises:
        DivergedError: If the motion cannot be followed to its end.
    """
    settings = problem.scenario.integration
    if settings.truth == "discrete":
        return follow_map(problem.model, start, t, u, settings.method, settings.substeps)
    return follow(problem.model, start, t, u, problem.scales, between=between)


def resimulate(problem: PlanningTask, t: Array, u: Array) -> Trajectory:
    """Return the true motion from the problem's start under inputs (N, nu) at times (N+1,)."""
    motion = reference_motion(problem, problem.start, t, u, between=False)
    return trajectory_under(problem.model, motion.t, motion.x, np.asarray(u))


def trajectory_under(model: Model, t: Array, x: Array, u: Array) -> Trajectory:
    """Return a motion as a trajectory, with what the feedback gave where there is one.

    Args:
        model: The machine.
        t: Times of the knots in [s], shape (N+1,).
        x: States at the knots, shape (N+1, nx).
        u: Inputs of the model per interval, shape (N, nu): references where it has feedback.
    """
    if model.plant is model:
        return Trajectory(t, x, u, model.state_names, model.control_names)
    acting, names = model.plant_inputs(x[: len(u)], u), model.plant.control_names
    return Trajectory(t, x, acting, model.state_names, names, u, model.control_names)


def perturbed_start(problem: PlanningTask, start: Array) -> Array:
    """Return a start (nx,) beside another one, to see how errors grow; always the same one."""
    nudge = np.random.default_rng(0).normal(size=problem.model.nx)
    nudge *= PERTURBATION / np.linalg.norm(nudge)
    beside: Array = start + nudge * problem.scales
    return beside


def error_amplification(problem: PlanningTask, states: Array, beside: Array) -> float:
    """Return by how much a motion makes errors grow: the most that another one goes away from it.

    Args:
        problem: Whose states.
        states: Of the motion, shape (N+1, nx).
        beside: Of the motion from a start that was ``perturbed_start``.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # of a motion that diverges it is infinite
        apart = np.linalg.norm((beside - states) / problem.scales, axis=1).max() / PERTURBATION
    return float(apart) if np.isfinite(apart) else np.inf

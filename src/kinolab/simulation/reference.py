"""Reference integration: SciPy's DOP853 under zero-order hold, independent of the planners.

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
ATOL = 1e-11  # relative to a coordinate's scale; a thousandth of the check's tolerance

# a motion that amplifies errors more than this needs a stored feedback law
MAX_ERROR_AMPLIFICATION = 1e6
PERTURBATION = 1e-6  # of a state's scale, of the start; its amplification is measured


class DivergedError(KinolabError):
    """The integration stopped before the final time; ``.time`` is where, in [s]."""

    exit_code = 7

    def __init__(self, time: float, reason: str) -> None:
        self.time = time
        super().__init__(f"the motion cannot be followed beyond t = {time:.6g} s: {reason}")


@dataclass(frozen=True)
class ReferenceMotion:
    """A continuous-time motion: one interpolant per knot interval."""

    t: Array
    x: Array  # states at the knots, shape (N+1, nx)
    pieces: Sequence[Any]

    def between(self, k: int, times: Array) -> Array:
        """Evaluate the motion at times within interval k; shape (times, nx)."""
        states: Array = self.pieces[k](times).T
        return states

    def along(self, intervals: NDArray[np.intp], times: Array) -> Array:
        """Evaluate the motion at times, each in its own interval; shape (times, nx).

        Args:
            intervals: Index of each time's interval, ascending, shape (times,).
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
    """A discrete-time motion, interpolated along chords between its states."""

    space: StateSpace

    def along(self, intervals: NDArray[np.intp], times: Array) -> Array:
        """Evaluate the motion at times, each in its own interval; shape (times, nx)."""
        begin, end = self.t[intervals], self.t[intervals + 1]
        fraction = ((times - begin) / (end - begin))[:, None]
        path = self.x[intervals + 1] - self.x[intervals]
        return self.space.retract(self.x[intervals], fraction * path)


def follow(
    model: Model, start: Array, t: Array, u: Array, scales: Array, *, between: bool = True
) -> ReferenceMotion:
    """Integrate from a start under zero-order hold of the inputs between the times t.

    A machine's feedback law is evaluated at every knot. The equations of motion contain position
    constraints in differentiated form only, so the drift off them is projected out at the end of
    each interval.

    Args:
        model: The compiled machine.
        start: State at t[0], shape (nx,).
        t: Times of the knots in [s], shape (N+1,).
        u: Inputs per interval, or references, shape (N, nu).
        scales: Characteristic magnitude of each state entry, shape (nx,).
        between: Whether to keep dense output between the knots.

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
    """Integrate a machine without feedback; return the final state and SciPy's dense output.

    ``start``, ``scales`` and the final state have shape (nx,), the constant inputs ``held`` (nu,).

    Parameters by keyword override the machine's own.

    Raises:
        DivergedError: If the integrator stops before the end.
    """
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # divergence is reported below
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
    """Iterate the integrator's own step map as the reference; interpolate between knots.

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
    """The geodesic between two states, with the interface of SciPy's dense output.

    Attributes:
        span: Start and end time, in [s].
        begin: First state, shape (nx,).
        end: Last state, shape (nx,).
        space: The state space; quaternions stay normalized.
    """

    span: tuple[float, float]
    begin: Array
    end: Array
    space: StateSpace

    @property
    def ts(self) -> Array:
        """Start and end time, in [s]."""
        return np.array(self.span)

    def __call__(self, times: float | Array) -> Array:
        """Evaluate at a time, shape (nx,), or at times, shape (nx, times)."""
        fraction = (np.asarray(times) - self.span[0]) / (self.span[1] - self.span[0])
        return self.space.retract(self.begin, fraction[..., None] * (self.end - self.begin)).T


def reference_motion(
    problem: PlanningTask, start: Array, t: Array, u: Array, *, between: bool = True
) -> ReferenceMotion:
    """Return the reference motion: the ODE's solution, or the integrator's own step map.

    Args:
        problem: Its [integration] section selects which.
        start: State at t[0], shape (nx,).
        t: Times of the knots in [s], shape (N+1,).
        u: Inputs per interval, shape (N, nu).
        between: Whether to keep dense output between the knots, which takes longer.

    Raises:
        DivergedError: If the integration stops before the end.
    """
    settings = problem.scenario.integration
    if settings.truth == "discrete":
        return follow_map(problem.model, start, t, u, settings.method, settings.substeps)
    return follow(problem.model, start, t, u, problem.scales, between=between)


def resimulate(problem: PlanningTask, t: Array, u: Array) -> Trajectory:
    """Re-simulate inputs (N, nu) at times (N+1,) from the problem's start."""
    motion = reference_motion(problem, problem.start, t, u, between=False)
    return trajectory_under(problem.model, motion.t, motion.x, np.asarray(u))


def trajectory_under(model: Model, t: Array, x: Array, u: Array) -> Trajectory:
    """Return a motion as a trajectory, with the plant inputs where the machine has feedback.

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
    """Return a perturbed start, shape (nx,), to measure error amplification; deterministic."""
    nudge = np.random.default_rng(0).normal(size=problem.model.nx)
    nudge *= PERTURBATION / np.linalg.norm(nudge)
    beside: Array = start + nudge * problem.scales
    return beside


def error_amplification(problem: PlanningTask, states: Array, beside: Array) -> float:
    """Return the error amplification: the largest growth of a perturbation at the start.

    Args:
        problem: Provides the state scales.
        states: Nominal motion, shape (N+1, nx).
        beside: Motion from ``perturbed_start``, shape (N+1, nx).
    """
    with np.errstate(over="ignore", invalid="ignore"):  # infinite where the motion diverges
        apart = np.linalg.norm((beside - states) / problem.scales, axis=1).max() / PERTURBATION
    return float(apart) if np.isfinite(apart) else np.inf

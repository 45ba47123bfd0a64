"""Reference integration: DOP853 under zero-order hold, independent of the planners.

Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.5.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics import Model
from kinolab.dynamics.codegen.state_space import StateSpace
from kinolab.errors import KinolabError, SingularError
from kinolab.numerics.arrays import Array, allocate
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.problem.objective.costed import costed
from kinolab.simulation import dop853
from kinolab.simulation.dop853 import StepTable, make_ode
from kinolab.simulation.motion_pieces import MotionPieces
from kinolab.trajectory import Trajectory

RTOL = 1e-9
ATOL = 1e-11  # relative to a coordinate's scale; a thousandth of the check's tolerance
INTERVALS_PER_CALL = 100  # after which Ctrl-C is heard
NO_PARAMETERS: Mapping[str, float] = MappingProxyType({})  # others than the machine's own

# a motion that amplifies errors more than this needs a stored feedback law
MAX_ERROR_AMPLIFICATION = 1e6
PERTURBATION = 1e-6  # of a state's scale, of the start; its amplification is measured


class DivergedError(KinolabError):
    """The integration stopped before the end: ``.time`` is where, in [s], and ``.reason`` why."""

    exit_code = 7

    def __init__(self, time: float, reason: str) -> None:
        self.time, self.reason = time, reason
        super().__init__(f"the motion cannot be followed beyond t = {time:.6g} s: {reason}")


@dataclass(frozen=True)
class ReferenceMotion(ABC):
    """A motion that is known at all times.

    Attributes:
        t: Times of the knots in [s], shape (N+1,).
        x: States at the knots, shape (N+1, nx).
    """

    t: Array
    x: Array

    @property
    def steps(self) -> tuple[NDArray[np.int64], Array, Array]:
        """Interval, begin and end in [s] of every step within which it is smooth, each (m,)."""
        return np.arange(len(self.t) - 1), self.t[:-1], self.t[1:]

    @property
    def landings(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Times in [s] at which modes begin after the start, states there, and their intervals."""
        return self.t[:0], self.x[:0], np.zeros(0, np.int64)

    def between(self, k: int, times: Array) -> Array:
        """Evaluate the motion at times within interval k; shape (times, nx)."""
        return self.along(np.full(len(times), k), times)

    @abstractmethod
    def along(self, intervals: NDArray[np.intp], times: Array) -> Array:
        """Evaluate the motion at times, each in its own interval; shape (times, nx).

        Args:
            intervals: Index of each time's interval, shape (times,).
            times: In [s], shape (times,).
        """


@dataclass(frozen=True)
class OdeMotion(ReferenceMotion):
    """The solution of the equations of motion, by the dense output of DOP853's steps."""

    table: StepTable

    @property
    def steps(self) -> tuple[NDArray[np.int64], Array, Array]:
        """Interval, begin and end in [s] of every integrator step, each of shape (m,)."""
        return self.table.knot, self.table.begin, self.table.end

    @property
    def landings(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Times in [s] at which modes begin after the start, states there, and their intervals."""
        table = self.table
        rows = np.flatnonzero(np.diff(table.x[:, -1])) + 1
        return table.begin[rows], table.x[rows], table.knot[rows]

    @cached_property
    def pieces(self) -> MotionPieces:
        """The integrator's steps as polynomials."""
        return MotionPieces.of(self.table)

    def along(self, intervals: NDArray[np.intp], times: Array) -> Array:
        """Evaluate the motion at times, each in its own interval; shape (times, nx)."""
        knots, begin, end = self.steps
        first, last = (np.searchsorted(knots, intervals, side) for side in ("left", "right"))
        row = np.clip(np.searchsorted(begin, times, "left") - 1, first, last - 1)
        part = ((times - begin[row]) / (end - begin)[row])[:, None]
        states = np.zeros((len(times), self.x.shape[1]))
        for i in range(dop853.POWER - 1, -1, -1):
            states += self.table.coefficients[row, i]
            states *= part if i % 2 == 0 else 1.0 - part
        return states + self.table.x[row]


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
        start: State at t[0], shape (nx,).
        t: Times of the knots in [s], shape (N+1,).
        u: Inputs per interval, or references, shape (N, nu).
        scales: Characteristic magnitude of each state entry, shape (nx,).
        between: Whether to keep dense output between the knots.

    Raises:
        DivergedError: If the integrator stops before the end.

    Source: Hairer, Wanner, Solving ODEs II, 2nd ed., section VII.2 (index reduction, projection).
    """
    table, ends = _integrated(model, start, t, u, scales, between=between)
    return OdeMotion(np.asarray(t, dtype=float), np.vstack([start, ends]), table)


def follow_each(
    model: Model, starts: Array, t: Array, u: Array, scales: Array, longest: Array | None = None,
    parameters: Mapping[str, float] = NO_PARAMETERS,
) -> Array:  # fmt: skip
    """Integrate each interval from a state of its own; return the states reached, (N, nx).

    Args:
        starts: States at the beginnings of the intervals, shape (N, nx).
        t: Times of the knots in [s], shape (N+1,).
        u: Inputs per interval, or references, shape (N, nu).
        scales: Characteristic magnitude of each state entry, shape (nx,).
        longest: Step that the integrator may make in each interval, in [s], shape (N,); otherwise
            its error control alone decides.
        parameters: Override those of a machine without feedback.

    Raises:
        DivergedError: If the integrator stops before the end of an interval.
    """
    return _integrated(
        model, starts, t, u, scales, between=False, longest=longest, parameters=parameters
    )[1]


def _integrated(
    model: Model,
    starts: Array,
    t: Array,
    u: Array,
    scales: Array,
    *,
    between: bool,
    longest: Array | None = None,
    parameters: Mapping[str, float] = NO_PARAMETERS,
) -> tuple[StepTable, Array]:
    """Return the steps and the ends of all intervals, (N, nx); a single start begins a chain."""
    # Copies: for arrays that are read-only everything would be compiled once more.
    times, held = np.array(t, dtype=float), np.array(u, dtype=float)
    begins = np.atleast_2d(np.array(starts, dtype=float))
    chained = np.ndim(starts) == 1
    ode, ends = _ode(model, scales, parameters), np.empty((len(held), model.nx))
    sizes = {"capacity": 4 * len(held) + 64 if between else 0, "nx": model.nx}
    table, row = allocate(StepTable, sizes), np.zeros(1, np.int64)
    most = np.full(len(held), np.inf) if longest is None else np.array(longest, dtype=float)
    k = 0
    while k < len(held):
        last = min(k + INTERVALS_PER_CALL, len(held))
        how, k = dop853.follow(
            ode, times, held, begins, most, chained, k, last, between, Record(table), row, ends
        )
        if how == dop853.FULL:
            sizes["capacity"] *= 2
            table, full = allocate(StepTable, sizes), table
            for column, wider in zip(full, table, strict=True):
                wider[: len(column)] = column
        elif how != dop853.WORKED:
            raise _diverged(model, ode.held, how, float(times[k]), held[k], parameters)
    return StepTable._make(column[: row[0]] for column in table), ends


def _ode(model: Model, scales: Array, parameters: Mapping[str, float]) -> Record:
    plant = model.plant
    loops = model.machine.closes_loops
    addresses = {
        "f": plant.address("f"),
        "law": 0 if plant is model else model.address("law"),
        "project": plant.address("project") if loops and plant.projects else 0,
        "guards": model.address("guards") if model.machine.modes else 0,
        "reset": model.address("reset") if model.machine.modes else 0,
    }
    p = plant.parameter_vector(**parameters)
    sources = [transition.source for transition in model.machine.transitions]
    guards = max(map(sources.count, sources), default=0)
    return make_ode(addresses, p, plant.nu, ATOL * scales, RTOL, guards)


def _diverged(
    model: Model,
    ode: dop853.Ode,
    how: int,
    begin: float,
    held: Array,
    parameters: Mapping[str, float],
) -> DivergedError:
    """Return the error of an integration that ended early, told by the function that failed."""
    try:
        if how == dop853.LAW_FAILED:
            model.plant_inputs(ode.y, held)
        elif how == dop853.SINGULAR:
            model.plant.f(ode.at, ode.u[: ode.inputs], **parameters)
            model.plant.f(ode.y, ode.u[: ode.inputs], **parameters)
    except KinolabError as error:
        return DivergedError(begin, str(error))
    reason = REASONS[how]
    if how == dop853.CHATTERS:
        mode = int(ode.y[-1])
        names = (t.name for t in model.machine.transitions if mode in (t.source, t.target))
        reason = f"{reason.rstrip('.')}: {', '.join(names)}."
    return DivergedError(float(ode.progress[0]), reason)


REASONS = {
    dop853.TOO_SMALL: "Required step size is less than spacing between numbers.",
    dop853.NOT_FINITE: "The state is not finite.",
    dop853.SINGULAR: "The equations of motion have no solution.",
    dop853.LAW_FAILED: "The feedback has no value.",
    dop853.TOO_MANY: f"It needs more than {dop853.MAX_STEPS} steps for one interval, or more than "
    f"{dop853.MAX_TOTAL} in all.",
    dop853.CHATTERS: "Transitions between modes follow one another without end.",
}


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
    return MapMotion(times, x, model.space)


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


def price(problem: PlanningTask, trajectory: Trajectory) -> float | None:
    """Return what a motion costs by a problem's [objective], integrated anew; None without one.

    Infinite where it cannot be integrated.
    """
    return cost_of_inputs(problem, trajectory.inputs, trajectory.t) if costed(problem) else None


def cost_of_inputs(problem: PlanningTask, u: Array, t: Array | None = None) -> float:
    """Return what the motion under inputs (N, nu) at times (N+1,) in [s], or steps, costs.

    By the problem's [objective]; infinite where it cannot be integrated.
    """
    times = problem.step * np.arange(len(u) + 1.0) if t is None else t
    try:
        return float(costs_along(problem, times, u)[-1])
    except DivergedError:
        return math.inf


def costs_along(problem: PlanningTask, t: Array, u: Array) -> Array:
    """Return what a motion has cost at each of its times (N+1,) in [s], under inputs (N, nu).

    Raises:
        DivergedError: If it cannot be integrated to its end.
    """
    priced = costed(problem)
    assert priced is not None
    return resimulate(priced, t, u).x[:, priced.cost_entry or 0]


def trajectory_under(model: Model, t: Array, x: Array, u: Array) -> Trajectory:
    """Return a motion as a trajectory, with the plant inputs where the machine has feedback.

    Args:
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
    nudge[_mode_of(problem)] = 0.0  # a machine is in a mode, and not near one
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
        gap = (beside - states) / problem.scales
        gap[:, _mode_of(problem)] = 0.0
        apart = np.linalg.norm(gap, axis=1).max() / PERTURBATION
    return float(apart) if np.isfinite(apart) else np.inf


def _mode_of(problem: PlanningTask) -> slice:
    """Return the entry of the state that says in which mode a machine is: none, or the last."""
    nx = problem.model.nx
    return slice(nx - 1, nx) if problem.machine.modes else slice(nx, nx)

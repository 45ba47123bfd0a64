"""Can the inputs hold the machine at rest? Equilibria f(x, u) = 0 within their limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinolab.dynamics.analysis.equilibrium import equilibrium
from kinolab.errors import KinolabError, NoDynamicsError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal_states import goal_states

EQUILIBRIUM_TOLERANCE = 1e-6  # of a state's scale per second: slower counts as held
GOAL_SAMPLES = 40  # of the goal, from which the nearest equilibrium is sought; few are needed


@dataclass(frozen=True)
class StaticHolding:
    """How the inputs hold the machine at a configuration, all velocities being zero.

    Attributes:
        holds: Whether this is an equilibrium.
        share: The largest fraction of an input limit that is used, 0 to 1.
        inputs: The inputs of least drift within their limits, by name.
        drifts: Remaining rates of change, in SI units, by the state's name; the worst first.
        needed: Inputs beyond their limits that would hold it, by name; empty if no inputs would.
    """

    holds: bool
    share: float
    inputs: dict[str, float]
    drifts: dict[str, float]
    needed: dict[str, float]


def static_holding(problem: PlanningTask, x: Array) -> StaticHolding | None:
    """Find inputs that hold the machine; None if its equations cannot be evaluated there.

    Further states, such as currents, are solved for with the inputs.

    Args:
        problem: The machine and the limits.
        x: State whose configuration is to be held, shape (nx,).
    """
    try:
        balance = _Balance(problem, x)
        within = balance.solved(limited=True)
        drift = balance.drift(within)
        held = bool(np.abs(drift).max(initial=0.0) <= EQUILIBRIUM_TOLERANCE)
        beyond = within if held else balance.solved(limited=False)
        freed = held or bool(
            np.abs(balance.drift(beyond)).max(initial=0.0) <= EQUILIBRIUM_TOLERANCE
        )
    except KinolabError:
        return None
    names, nu = problem.model.control_names, problem.model.nu
    needed = {}
    if freed and not held:
        lower, upper = problem.model.control_bounds.T
        slack = EQUILIBRIUM_TOLERANCE * (upper - lower)
        outside = (beyond[:nu] < lower - slack) | (beyond[:nu] > upper + slack)
        needed = {names[i]: float(beyond[i]) for i in np.flatnonzero(outside)}
    return StaticHolding(
        holds=held,
        share=_share(problem, within[:nu]),
        inputs=dict(zip(names, map(float, within[:nu]), strict=True)),
        drifts=_worst_first(problem, drift),
        needed=needed,
    )


def start_holding(problem: PlanningTask) -> StaticHolding | None:
    """Return how the start is held, or an equilibrium that differs in its last digits only."""
    held = static_holding(problem, problem.start)
    if held is not None and held.holds:
        return held
    for x, _ in _equilibria(problem, [problem.start], problem.scales):
        moved = np.abs(problem.space.difference(problem.start, x)) / problem.scales
        # of a state's scale: a start is written with a few digits
        if moved[: problem.model.nq].max(initial=0.0) <= 1e-4:
            return static_holding(problem, x)
    return held


def best_static_holding(problem: PlanningTask, states: Sequence[Array]) -> StaticHolding | None:
    """Return the holding with the least effort in the goal; equilibria come first.

    Where none of the given states is one, the goal's equilibria near them are looked at: a pendulum
    stands at pi, which a goal of 3.14159 holds within its tolerance.

    Args:
        problem: The machine, its limits and its goal.
        states: States in the goal region, each of shape (nx,).
    """
    found = _held(problem, states)
    if not any(held.holds for held in found):
        found_near = _equilibria(problem, states, _in_tolerances(problem))
        near = (x for x, _ in found_near if problem.goal_excess(x) <= 1.0)
        found += [held for held in _held(problem, near) if held.holds]
    return min(found, key=_effort, default=None)


def _held(problem: PlanningTask, states: Iterable[Array]) -> list[StaticHolding]:
    return [held for x in states if (held := static_holding(problem, x)) is not None]


def _equilibria(
    problem: PlanningTask, states: Iterable[Array], scales: Array
) -> Iterator[tuple[Array, Array]]:
    """Yield equilibria near states (nx,), within all limits but those of the inputs (nu,)."""
    for near in states:
        # steps of Newton's method towards the equilibrium that is nearest
        found = equilibrium(problem.model, near, scales=scales, drawn_back=5)
        if found is not None and not any(problem.limit_violations(found[0])):
            yield found


def _in_tolerances(problem: PlanningTask) -> Array:
    """Return what counts as a large difference in the goal, shape (nx,): a tolerance at most.

    So what the goal leaves free moves first towards an equilibrium, as ropes do of which it says
    nothing.
    """
    scales = problem.scales.copy()
    wanted = list(problem.goal.indices)
    scales[wanted] = np.minimum(scales[wanted], problem.goal.tolerances)
    return scales


def _effort(held: StaticHolding) -> tuple[bool, float]:
    return not held.holds, held.share if held.holds else max(map(abs, held.drifts.values()))


@lru_cache(maxsize=1)  # every report of one problem has them
def rest_warnings(problem: PlanningTask) -> tuple[str, ...]:
    """Say before a search where gravity or springs move a machine on from a goal at rest.

    An equilibrium is mostly found from the first sample of the goal, within milliseconds.
    """
    if not _wants_rest(problem) or not _has_potential(problem) or _is_held_nearby(problem):
        return ()
    # if there is none, the one of these that is held best says what is missing
    goal = best_static_holding(problem, goal_states(problem).inside[:5])
    return tuple(holding_sentences(problem, None, goal))


def _has_potential(problem: PlanningTask) -> bool:
    """Whether the potential energy differs between configurations."""
    generator = np.random.default_rng(0)
    states = problem.model.project([problem.sample(generator) for _ in range(GOAL_SAMPLES)])
    try:
        _, energies = problem.model.energy(states)
    except NoDynamicsError:
        return False
    # relative change of the potential energy that is rounding
    return bool(np.ptp(energies) > 1e-9 * max(1.0, np.abs(energies).max()))


def _is_held_nearby(problem: PlanningTask) -> bool:
    """Whether an equilibrium in the goal is near one of its samples, found by Newton's method."""
    generator = np.random.default_rng(0)
    samples = (problem.sample_goal(generator) for _ in range(GOAL_SAMPLES))
    lower, upper = problem.model.control_bounds.T
    return any(
        bool(((lower <= u) & (u <= upper)).all()) and problem.goal_excess(x) <= 1.0
        for x, u in _equilibria(problem, samples, _in_tolerances(problem))
    )


def holding_sentences(
    problem: PlanningTask, start: StaticHolding | None, goal: StaticHolding | None
) -> Iterator[str]:
    """Say where the machine cannot rest, and which inputs it would take."""
    if goal is not None and not goal.holds and _wants_rest(problem):
        yield (
            "The machine cannot stay at rest in the goal, only come to rest there for an instant: "
            f"{_why(problem, goal)}."
        )
    if start is not None and not start.holds:
        yield f"The machine cannot rest at the start: {_why(problem, start)}."


def _why(problem: PlanningTask, held: StaticHolding) -> str:
    name, drift = next(iter(held.drifts.items()))
    if not held.needed:
        return f"no inputs keep {name} from changing"
    limits = dict(zip(problem.model.control_names, problem.model.control_bounds, strict=True))
    units = {entry.name: entry.unit for entry in problem.machine.chosen}
    wanted = [
        f"{which} = {value:.4g} {units[which]}".rstrip()
        + f" (its limit is {limits[which][0 if value < limits[which][0] else 1]:g})"
        for which, value in held.needed.items()
    ]
    return f"{name} changes by {abs(drift):.3g} per second; to hold it takes {', '.join(wanted)}"


def _wants_rest(problem: PlanningTask) -> bool:
    """Whether the goal requires all velocity states to be zero."""
    model = problem.model
    wanted = dict(zip(problem.goal.indices, problem.goal.targets, strict=True))
    rates = list(range(model.nq, model.nq + model.nv))
    return bool(rates) and all(wanted.get(i, math.inf) == 0.0 for i in rates)


def _share(problem: PlanningTask, u: Array) -> float:
    """Return the largest fraction of an input's limit, on the side where it is used."""
    limits = np.where(u < 0, *problem.model.control_bounds.T)
    used = np.abs(u) > 1e-12  # zero inputs use no limit
    return float(np.max(np.abs(u[used] / limits[used]), initial=0.0))


def _worst_first(problem: PlanningTask, drift: Array) -> dict[str, float]:
    """Return rates of change that are not small when scaled, in SI units, by name."""
    order = np.argsort(-np.abs(drift))
    names, scales = problem.model.state_names, problem.scales
    return {
        names[i]: float(drift[i] * scales[i])
        for i in order
        if abs(drift[i]) > EQUILIBRIUM_TOLERANCE
    }


class _Balance:
    """The rates of change as a function of inputs and auxiliary states, at one configuration."""

    def __init__(self, problem: PlanningTask, x: Array) -> None:
        model = problem.model
        self._model, self._scales = model, problem.scales
        rates = list(range(model.nq, model.nq + model.nv))
        self._still = x.copy()
        self._still[rates] = 0.0
        self._further = np.array(
            [i for i in range(model.nq, model.nx) if i not in rates], dtype=np.int64
        )
        self._limits = np.concatenate([model.control_bounds, problem.bounds[self._further]])

    def solved(self, *, limited: bool) -> Array:
        """Return inputs and auxiliary states with the least drift, with or without limits."""
        lower, upper = self._limits.T
        none = np.clip(np.zeros(len(lower)), lower, upper)
        if not len(none) or not self.drift(none).any():
            return none
        from scipy.optimize import least_squares

        unit = np.maximum(np.abs(self._limits).max(axis=1), 1e-12)  # scales the unknowns
        found = least_squares(
            lambda z: self.drift(z * unit),
            none / unit,
            jac=lambda z: self._slope(z * unit) * unit,
            bounds=(lower / unit, upper / unit) if limited else (-np.inf, np.inf),
            max_nfev=100,
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
        )
        return np.asarray(found.x * unit)

    def drift(self, z: Array) -> Array:
        """Return the rates of change over the states' scales, shape (nx,)."""
        x, u = self._split(z)
        change: Array = self._model.f(x, u) / self._scales
        change[self._model.clocks] = 0.0
        return change

    def _slope(self, z: Array) -> Array:
        in_x, in_u = self._model.jacobian(*self._split(z))
        both: Array = np.concatenate([in_u, in_x[:, self._further]], axis=1)
        return both / self._scales[:, None]

    def _split(self, z: Array) -> tuple[Array, Array]:
        nu, x = self._model.nu, self._still.copy()
        x[self._further] = z[nu:]
        return x, z[:nu]

"""The judge: is a plan true? By equations written by hand and SciPy's integrator alone.

What is taken from kinolab are the words of a problem: names, scales, limits, targets, tolerances.
What the verifier calculates is calculated here by other means.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import sympy
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from kinolab.dynamics import Feedback, force_of
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory

from . import by_hand, by_lagrange

Array: TypeAlias = NDArray[np.float64]
Slope: TypeAlias = Callable[[Array, Array], Array]

# What docs/files.md and the heads of the checks promise, as the judge's own figures.
DEFECT = 1e-6  # of a state's scale, from one row to the next
START = 1e-9  # of a state's scale
LIMIT = 1e-9  # of inputs and limits, in their own units
LAW = 1e-9  # of an input's range
CLOSE = 2.0  # nearer to a tolerance than by this factor, nothing is said

RTOL, ATOL = 1e-11, 1e-13  # a thousandth of the tolerance and less; ATOL in scales
ROUGH = {"five_bar": (1e-8, 1e-9)}  # whose oracle takes derivatives by differences
WHOLE = 100.0  # times as coarse are whole plans judged: 1e-9 from row to row
BY_LAGRANGE = ("unicycle",)
WALKS = ("biped",)


@dataclass(frozen=True)
class Verdict:
    """What the judge says of a plan.

    Attributes:
        truth: ``false``, ``true``, ``borderline``, or ``unknown`` where there is no oracle.
        why: By what, and by how many tolerances.
    """

    truth: str
    why: str


def graded(excess: float, what: str) -> Verdict:
    """Return the verdict on an error in tolerances."""
    truth = "false" if not excess < CLOSE else "true" if excess <= 1 / CLOSE else "borderline"
    return Verdict(truth, f"{what}: {excess:.3g} tolerances")


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the verdict that decides: one falsehood is enough, and truth needs all."""
    order = ("false", "borderline", "unknown", "true")
    return min(verdicts, key=lambda one: order.index(one.truth))


class Judge:
    """Judges motions of one problem's machine.

    Args:
        problem: Names, scales and limits.
        changes: Of parameters, which the judge's machine has and the problem's does not.
    """

    def __init__(self, problem: PlanningTask, **changes: float) -> None:
        self.problem = problem
        plant = problem.model.plant
        self.states, self.scales = plant.state_names, np.asarray(problem.scales)
        self.limits = np.asarray(plant.control_bounds)
        self.circular = np.asarray(problem.circular)
        self.attitudes = [slice(at, at + 4) for at in problem.model.attitudes.values()]
        self.system = problem.system.with_feedback(None)
        self.values = {**self.system.parameter_values, **changes}

    @cached_property
    def slope(self) -> Slope | None:
        """Equations of motion; None where there are none."""
        name = self.problem.machine.name
        if name in BY_LAGRANGE:
            return by_lagrange.slope_of(self.system, self.values, self.states)
        return by_hand.slope_of(name, self.values)

    @property
    def knows(self) -> bool:
        """Whether there is an oracle of this machine."""
        return self.problem.machine.name in WALKS or self.slope is not None

    def after(self, x: Array, u: Array, duration: float, coarser: float = 1.0) -> Array:
        """Return the state after a while under held inputs.

        Args:
            x: State, shape (nx,).
            u: Inputs, shape (nu,).
            duration: In [s].
            coarser: Factor on the integrator's tolerances.
        """
        if self.problem.machine.name in WALKS:
            return by_hand.walked(x, u, duration)
        run = self._integrated(x, u, duration, coarser=coarser)
        if not run.success:
            return np.full(len(x), np.nan)
        return by_hand.closed(self.problem.machine.name, self.values, run.y[:, -1])

    def between(self, x: Array, u: Array, duration: float, count: int) -> Array:
        """Return the states at even times of an interval with both ends, (count + 1, nx)."""
        times = np.linspace(0.0, duration, count + 1)
        return np.asarray(self._integrated(x, u, duration, times=times).y.T)

    def _integrated(
        self,
        x: Array,
        u: Array,
        duration: float,
        *,
        times: Array | None = None,
        coarser: float = 1.0,
    ) -> Any:
        """Return SciPy's solution under held inputs, at its own times unless some are given."""
        slope = self.slope
        assert slope is not None
        rtol, atol = ROUGH.get(self.problem.machine.name, (RTOL, ATOL))
        return solve_ivp(
            lambda _, at: slope(at, u),
            (0.0, duration),
            x,
            "DOP853",
            t_eval=times,
            rtol=coarser * rtol,
            atol=coarser * atol * self.scales,
        )

    def apart(self, a: Array, b: Array) -> Array:
        """Return the differences of two states in scales: on circles, and whatever the sign."""
        gap = np.asarray(b, dtype=float) - a
        turns = gap[self.circular]
        gap[self.circular] = turns - 2 * np.pi * np.round(turns / (2 * np.pi))
        for own in self.attitudes:
            near, far = b[own] - a[own], -b[own] - a[own]
            gap[own] = near if near @ near <= far @ far else far
        return np.abs(gap) / self.scales

    def defect(self, motion: Trajectory, k: int, coarser: float = 1.0) -> float:
        """Return by how many tolerances row k + 1 differs from what follows from row k."""
        span = float(motion.t[k + 1] - motion.t[k])
        reached = self.after(motion.x[k], motion.u[k], span, coarser)
        return float(np.nan_to_num(self.apart(reached, motion.x[k + 1]), nan=np.inf).max()) / DEFECT

    def rows(self, motion: Trajectory, intervals: Iterable[int], coarser: float = 1.0) -> Verdict:
        """Judge some intervals: whether each row follows from the one before."""
        if not self.knows:
            return Verdict("unknown", "no oracle")
        found = [self.defect(motion, k, coarser) for k in intervals if 0 <= k < len(motion.u)]
        return graded(max(found, default=0.0), "a row does not follow from the one before")

    def starts(self, motion: Trajectory) -> Verdict:
        """Judge whether the first row is the start."""
        off = float(self.apart(np.asarray(self.problem.start), motion.x[0]).max())
        return graded(off / START, "it does not begin at the start")

    def inputs(self, motion: Trajectory, rows: Iterable[int]) -> Verdict:
        """Judge whether inputs, and references, are within their limits in some intervals."""
        held, limits = motion.u, self.limits
        if motion.reference_names:
            held = np.hstack([held, motion.references])
            limits = np.vstack([limits, self.problem.model.control_bounds])
        some = held[[k for k in rows if 0 <= k < len(held)]]
        beyond = np.maximum(some - limits[:, 1], limits[:, 0] - some).max(initial=0.0)
        return graded(float(beyond) / LIMIT, "an input is beyond its limit")

    @cached_property
    def law(self) -> Callable[[Array, Array], Array] | None:
        """The machine's feedback law by SymPy: u of (x, references), held within the limits."""
        return law_of(self.problem, None)

    @cached_property
    def margins(self) -> Callable[[Array, Array], Array] | None:
        """What the machine requires to be nonnegative, of (x, u), by SymPy; None if unknown."""
        return _margins(self)

    def feedback(self, motion: Trajectory, rows: Iterable[int]) -> Verdict:
        """Judge whether inputs are those of the law in some intervals."""
        if self.law is None:
            return Verdict("true", "no feedback")
        span = np.ptp(self.limits, axis=1)
        worst_miss = 0.0
        for k in rows:
            if 0 <= k < len(motion.u):
                given = self.law(motion.x[k], motion.references[k])
                worst_miss = max(worst_miss, float(np.max(np.abs(motion.u[k] - given) / span)))
        return graded(worst_miss / LAW, "an input is not the law's")

    def whole(self, motion: Trajectory) -> Verdict:
        """Judge all rows, the start, the inputs, the law and the goal; not collisions."""
        every = range(len(motion.u))
        return worst(
            [
                self.starts(motion),
                self.inputs(motion, every),
                self.feedback(motion, every),
                self.rows(motion, every, WHOLE),
                self.ends(motion.x[-1]),
            ]
        )

    def ends(self, x: Array) -> Verdict:
        """Judge whether a state is in the goal: exactly, as 1 tolerance is what is asked for."""
        excess = self.missed(x)
        if abs(excess - 1.0) < 1e-3:
            return Verdict("borderline", f"{excess:.6g} tolerances from the goal")
        return Verdict("false" if excess > 1 else "true", f"{excess:.4g} tolerances from the goal")

    def missed(self, x: Array) -> float:
        """Return how far a state is from the goal, in tolerances, targets of bodies left out."""
        goal = self.problem.goal
        off = np.asarray(x)[list(goal.indices)] - goal.targets
        turns = np.asarray(goal.circular)
        off[turns] -= 2 * np.pi * np.round(off[turns] / (2 * np.pi))
        shares = [*(np.abs(off) / goal.tolerances)]
        for target in goal.parts:
            turn = Rotation.from_quat(target.target).inv() * Rotation.from_quat(x[target.part.own])
            shares.append(float(turn.magnitude()) / target.tolerance)
        if goal.norm == "sum":
            return float(sum(shares))
        return math.hypot(*shares) if goal.norm == "euclidean" else float(max(shares, default=0.0))


def _margins(judge: Judge) -> Callable[[Array, Array], Array] | None:
    system, values = judge.system, judge.values
    forces = by_hand.forces_of(judge.problem.machine.name, values)
    count = len(system.constraints) if forces is not None else 0
    names = [*judge.states, *judge.problem.model.plant.control_names]
    names += [f"force {i}" for i in range(count)]
    plain = [sympy.Symbol(f"s{i}") for i in range(len(names))]
    swap: dict[Any, Any] = {p: sympy.Float(values[p.name], 17) for p in system.parameters}
    swap |= {
        force_of(c): plain[len(names) - count + i]
        for i, c in enumerate(system.constraints)
        if count
    }
    margins = [requirement.margin.xreplace(swap) for requirement in system.requirements]
    left = set().union(*(margin.free_symbols for margin in margins)) - set(plain)
    if any(symbol.name not in names for symbol in left):
        return None
    named = {symbol: plain[names.index(symbol.name)] for symbol in left}
    compute = sympy.lambdify([plain], [margin.xreplace(named) for margin in margins], cse=True)

    def at(x: Array, u: Array) -> Array:
        pushed = forces(x, u) if forces is not None else ()
        return np.array(compute([*x, *u, *pushed]), dtype=float)

    return at


def law_of(
    problem: PlanningTask, change: Callable[[Any], Any] | None
) -> Callable[[Array, Array], Array] | None:
    """Return a machine's feedback as a function of (x, references); None without one.

    Args:
        problem: Whose machine it is.
        change: Applied to the list of the inputs' expressions.
    """
    feedback = problem.system.feedback
    if not isinstance(feedback, Feedback):  # a regulator is designed before it is one
        return None
    plant = problem.model.plant
    named = dict(feedback.law)
    law = [named.get(name, sympy.Integer(0)) for name in plant.control_names]
    law = law if change is None else change(law)
    values = {p: problem.system.parameter_values[p.name] for p in problem.system.parameters}
    references = [reference.symbol for reference in feedback.references]
    free = sorted(set().union(*(e.free_symbols for e in law)) - set(values), key=str)
    places: list[tuple[str, int]] = []
    plain: list[sympy.Symbol] = []
    for symbol in free:
        if symbol in references:
            places.append(("r", references.index(symbol)))
        else:
            places.append(("x", plant.state_names.index(symbol.name)))
        plain.append(sympy.Symbol(f"s{len(plain)}"))
    swap = dict(zip(free, plain, strict=True)) | {p: sympy.Float(v, 17) for p, v in values.items()}
    compute = sympy.lambdify(plain, [e.xreplace(swap) for e in law], cse=True)
    lower, upper = np.asarray(plant.control_bounds).T

    def law_at(x: Array, r: Array) -> Array:
        arguments = [x[i] if kind == "x" else r[i] for kind, i in places]
        return np.asarray(np.clip(np.array(compute(*arguments), dtype=float), lower, upper))

    return law_at

"""LQR design of a ``Regulator``: equilibria, gains, and gain scheduling by polynomials."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import sympy
from numpy.polynomial import chebyshev

from kinolab.dynamics.analysis.trim import StateFunctions, Trim, trim
from kinolab.dynamics.codegen.cache import COMPILED, Compiled, key_of
from kinolab.dynamics.language.feedback import Feedback, Reference, Regulator
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.dynamics.language.json.machine_file import (
    feedback_from_tree,
    feedback_to_tree,
    machine_to_json,
)
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.model.model import Model
from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.numerics.riccati import lqr

AnySystem = TypeVar("AnySystem", bound=Mechanism)


def lqr_design(model: Model, regulator: Regulator) -> Feedback:
    """Design the feedback law of a regulator.

    Args:
        model: The machine, without feedback.
        regulator: Tracked expressions and weights.

    Raises:
        InputError: If there is no equilibrium or no gain, or the tracked expressions do not
            determine their own rates of change.
    """
    return _Design(model, regulator).feedback()


def with_law(system: AnySystem) -> AnySystem:
    """Return a machine whose regulator, if any, is replaced by its designed law.

    The design is cached on disk, as compiled machines are.

    Raises:
        InputError: As ``lqr_design``.
    """
    regulator = system.feedback
    if not isinstance(regulator, Regulator):
        return system

    def design() -> Compiled:
        law = lqr_design(Model(system.with_feedback(None)), regulator)
        return {"feedback": feedback_to_tree(law)}, b""

    facts, _ = COMPILED.get([key_of(machine_to_json(system))], design)
    return system.with_feedback(feedback_from_tree(system, facts["feedback"]))


def linearised(model: Model, watched: StateFunctions, at: Trim) -> tuple[Array, Array, float]:
    """Linearise expressions z of the state about an equilibrium: z_dot = A z + B u.

    Args:
        model: The machine, without feedback.
        watched: The expressions z, n of them.
        at: The equilibrium or steady motion.

    Returns:
        A of shape (n, n), B of shape (n, nu), and the fraction of the rates that z does not
        determine: zero where z is closed.
    """
    C = watched.derivative(at.x)
    tangents = _tangents(model, at.x)
    slopes = _slopes(model, watched, at) @ tangents
    back = np.linalg.pinv(C @ tangents)
    hidden = slopes - slopes @ back @ (C @ tangents)
    scale = np.abs(slopes).max(initial=0.0)
    fraction = float(np.abs(hidden).max(initial=0.0) / scale) if scale else 0.0
    return slopes @ back, C @ model.jacobian(at.x, at.u)[1], fraction


def _slopes(model: Model, watched: StateFunctions, at: Trim) -> Array:
    """Return the derivative with respect to the state of z_dot = C(x) f(x, u), shape (n, nx)."""
    rate = model.f(at.x, at.u)
    slopes = watched.derivative(at.x) @ model.jacobian(at.x, at.u)[0]
    for i, scale in enumerate(model.state_scales):
        h = np.zeros(model.nx)
        h[i] = 1e-6 * scale  # of a state's scale, for finite differences of Jacobians
        change = watched.derivative(at.x + h) - watched.derivative(at.x - h)
        slopes[:, i] += change @ rate / (2 * h[i])
    return slopes


def _tangents(model: Model, x: Array) -> Array:
    """Return a basis of the state's tangent space, as columns; unit vectors keep their length."""
    identity, space = np.eye(model.nx), model.space
    columns = [identity[i] for i in range(model.nx) if not (space.turns & ~space.circular)[i]]
    for part in space.spheres:
        for column in part.tangents(x[part.own]).T:
            columns.append(np.zeros(model.nx))
            columns[-1][part.own] = column
    return np.stack(columns, axis=1)


@dataclass(frozen=True)
class _Axis:
    """The grid of one reference's values at which equilibria are computed.

    Attributes:
        symbol: The reference normalized to [-1, 1].
        values: Chebyshev points, shape (degree + 1,).
    """

    symbol: sympy.Expr
    values: Array

    @classmethod
    def of(cls, reference: Reference, degree: int) -> _Axis:
        """Place Chebyshev points between a reference's limits."""
        lower, upper = bounds_of(reference, "reference")
        middle, half = (lower + upper) / 2, (upper - lower) / 2
        points = chebyshev.chebpts1(degree + 1)
        return cls((reference.symbol - middle) / half, middle + half * points)


class _Design:
    """One design: an equilibrium and a gain at every grid point of the references."""

    def __init__(self, model: Model, regulator: Regulator) -> None:
        self._model, self._regulator = model, regulator
        self._where = f"system {model.system.name!r} feedback"
        degrees = dict(regulator.schedule)
        self._axes = [_Axis.of(r, degrees.get(r.name, 0)) for r in regulator.references]
        self._watched = StateFunctions(model, [z for z, _ in regulator.tracked])
        values = model.system.substitutions
        self._about = {z: wanted.subs(values) for z, wanted in regulator.about}

    def feedback(self) -> Feedback:
        """Return the law u = u0 + K (z0 - z), everything but z a polynomial in the references."""
        model, tracked = self._model, [z for z, _ in self._regulator.tracked]
        inputs, targets, gains = (self._fitted(table) for table in self._equilibria())
        wanted = [self._about.get(z, targets(j)) for j, z in enumerate(tracked)]
        law = {
            name: inputs(i) + sum(gains(i, j) * (wanted[j] - z) for j, z in enumerate(tracked))
            for i, name in enumerate(model.control_names)
        }
        return Feedback(self._regulator.references, law)

    def _equilibria(self) -> tuple[Array, Array, Array]:
        """Return inputs, tracked values and gains at every grid point."""
        shape = tuple(len(axis.values) for axis in self._axes)
        found = {place: self._at(place, trim) for place, trim in self._trims(shape)}
        tables = [np.array([found[place][k] for place in np.ndindex(*shape)]) for k in range(3)]
        inputs, targets, gains = (table.reshape(*shape, *table.shape[1:]) for table in tables)
        return inputs, targets, gains

    def _trims(self, shape: tuple[int, ...]) -> Iterator[tuple[tuple[int, ...], Trim]]:
        """Yield the equilibrium at every grid point, each warm-started from the previous one."""
        near: Trim | None = None
        for place in np.ndindex(*shape):
            numbers = self._numbers(place)
            fixed = [(z, float(wanted.subs(numbers))) for z, wanted in self._about.items()]
            try:
                near = trim(self._model, self._watched, fixed, start=near)
            except KinolabError as error:
                raise InputError([Mistake(self._where, f"{error} ({_said(numbers)}).")]) from error
            yield place, near

    def _numbers(self, place: tuple[int, ...]) -> dict[sympy.Symbol, float]:
        """Return the references at a grid point."""
        values = [axis.values[i] for axis, i in zip(self._axes, place, strict=True)]
        symbols = [entry.symbol for entry in self._regulator.references]
        return dict(zip(symbols, values, strict=True))

    def _at(self, place: tuple[int, ...], at: Trim) -> tuple[Array, Array, Array]:
        """Return inputs, tracked values and gain at one equilibrium."""
        A, B, hidden = linearised(self._model, self._watched, at)
        # The error of finite differences is all that may depend on untracked states.
        if hidden > 1e-6:
            what = f"a share of {hidden:.2g} of the tracked rates rests on what is not tracked."
            raise InputError([Mistake(self._where, what, "Track what decides them, too.")])
        try:
            gain = lqr(A, B, *self._weights())
        except KinolabError as error:
            what = f"{error} ({_said(self._numbers(place))})."
            remedy = "Track less, or choose other limits of the references."
            if self._model.system.gravity is None:
                remedy += " There is no gravity: was gravity= left out?"
            raise InputError([Mistake(self._where, what, remedy)]) from error
        return at.u, self._watched.values(at.x), gain

    def _weights(self) -> tuple[Array, Array]:
        """Return Q and R by Bryson's rule: one over the square of large deviations."""
        large = np.array([size for _, size in self._regulator.tracked])
        given = dict(self._regulator.efforts)
        limits = dict(zip(self._model.control_names, self._model.control_bounds, strict=True))
        efforts = [given.get(name, np.abs(limit).max()) for name, limit in limits.items()]
        return np.diag(large**-2.0), np.diag(np.array(efforts) ** -2.0)

    def _fitted(self, table: Array) -> Callable[..., sympy.Expr]:
        """Interpolate a table of shape (*grid, ...); return polynomials by its last indices."""
        coefficients = table
        for k, axis in enumerate(self._axes):
            coefficients = np.moveaxis(coefficients, k, 0)
            coefficients = _power_series(coefficients.reshape(len(axis.values), -1)).reshape(
                coefficients.shape
            )
            coefficients = np.moveaxis(coefficients, 0, k)
        symbols = [axis.symbol for axis in self._axes]
        return lambda *entry: _horner(coefficients[(..., *entry)], symbols)


def _power_series(table: Array) -> Array:
    """Convert values at Chebyshev points to monomial coefficients of the interpolants.

    Args:
        table: Values, one row per point, shape (n, columns).
    """
    points = chebyshev.chebpts1(len(table))
    series = np.linalg.solve(np.vander(points, increasing=True), table).astype(np.float64)
    # 1e-12 relative to a polynomial's values; smaller coefficients are dropped
    series[np.abs(series) < 1e-12 * np.abs(table).max(axis=0)] = 0.0
    return series


def _horner(coefficients: Array, symbols: list[sympy.Expr]) -> sympy.Expr:
    """Return a polynomial in several symbols, nested so that it takes few operations."""
    if not symbols:
        return sympy.Float(float(coefficients))
    total: sympy.Expr = sympy.Integer(0)
    for row in coefficients[::-1]:
        total = _horner(row, symbols[1:]) + symbols[0] * total
    return total


def _said(numbers: dict[sympy.Symbol, float]) -> str:
    return ", ".join(f"{symbol} = {value:.4g}" for symbol, value in numbers.items())

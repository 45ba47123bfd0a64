"""Trim: equilibria and steady motions, states and inputs that keep given expressions constant.

In a steady turn the machine moves over the plane, but its speed, lean and rates are constant. So
expressions of the state say what is constant, and the rest is free to change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.language.mechanism_parts import quasi_velocities, state_symbols
from kinolab.dynamics.model.model import Model
from kinolab.dynamics.symbols.expressions import exact
from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.numerics.arrays import Array


class NoTrimError(KinolabError):
    """No trim was found for the given conditions."""

    exit_code = 2


@checked
@dataclass(frozen=True)
class Trim:
    """An equilibrium, or a steady motion.

    Attributes:
        x: State, shape (nx,).
        u: Inputs that hold it, shape (nu,).
    """

    x: Array
    u: Array


@checked
class StateFunctions:
    """Numeric functions of a machine's state from expressions, with their derivatives.

    Args:
        expressions: In coordinates, independent rates, auxiliary states and parameters.

    Raises:
        InputError: If one contains any other symbol.
    """

    def __init__(self, model: Model, expressions: Sequence[Number]) -> None:
        system = model.system
        self._symbols = symbols_of_state(model)
        values = system.substitutions
        self._expressions = [exact(entry).subs(values) for entry in expressions]
        known = set(self._symbols)
        mistakes = [
            Mistake(
                f"system {system.name!r}",
                f"{symbol} in {expression} is no state of the machine.",
                f"Use {', '.join(model.state_names)}.",
            )
            for expression in self._expressions
            for symbol in sorted(expression.free_symbols - known, key=str)
        ]
        if mistakes:
            raise InputError(mistakes)

    def values(self, x: Array) -> Array:
        """Return the expressions' values at a state, shape (n,)."""
        return np.array(self._functions[0](*x), dtype=float)

    def derivative(self, x: Array) -> Array:
        """Return their derivatives with respect to the state, shape (n, nx)."""
        return np.array(self._functions[1](*x), dtype=float).reshape(len(self._expressions), -1)

    @cached_property
    def _functions(self) -> tuple[Any, Any]:
        slopes = [[e.diff(symbol) for symbol in self._symbols] for e in self._expressions]
        return (
            sympy.lambdify(self._symbols, self._expressions, "numpy"),
            sympy.lambdify(self._symbols, slopes, "numpy"),
        )


def symbols_of_state(model: Model) -> list[sympy.Symbol]:
    """Return the symbols of a model's state, the author's own."""
    system = model.system
    chosen = {v.name: v.symbol for v in quasi_velocities(system)}
    quasi = [chosen.get(v.name, sympy.Symbol(v.name)) for v in model.quasi_velocities]
    return list(state_symbols(system, quasi, model.independent))


@checked
def trim(
    model: Model,
    steady: Sequence[Number] | StateFunctions,
    fixed: Sequence[tuple[Number, float]] = (),
    *,
    start: Trim | None = None,
) -> Trim:
    """Return an equilibrium or steady motion near an initial guess.

    Args:
        model: The machine, without feedback.
        steady: Expressions whose rates of change vanish.
        fixed: Expressions and their prescribed values.
        start: Initial guess; at rest with inputs mid-range when left out.

    Returns:
        State and inputs; undetermined entries keep their initial guess.

    Raises:
        NoTrimError: If the least-squares solve does not converge to one.
    """
    watched = steady if isinstance(steady, StateFunctions) else StateFunctions(model, steady)
    values = np.array([value for _, value in fixed], dtype=float)
    held = StateFunctions(model, [expression for expression, _ in fixed])
    guess = start or Trim(model.rest(), model.control_bounds.mean(axis=1))
    return _TrimSolver(model, watched, held, values).from_guess(guess)


class _TrimSolver:
    """Least squares over states and inputs, polished by Newton steps."""

    def __init__(
        self, model: Model, steady: StateFunctions, held: StateFunctions, values: Array
    ) -> None:
        self._model, self._steady, self._held, self._values = model, steady, held, values
        span = np.ptp(model.control_bounds, axis=1)
        self._scales = np.concatenate([model.state_scales, span / 2])

    def from_guess(self, guess: Trim) -> Trim:
        """Solve until the residual is zero up to rounding."""
        z = self._near(np.concatenate([guess.x, guess.u]))
        for _ in range(3):  # after the least-squares solve
            slopes = self._derivative(z) * self._scales
            step = np.linalg.lstsq(slopes, -self._residual(z), rcond=1e-10)[0]
            z = self._landed(z + self._scales * step)
        left = np.abs(self._residual(z)).max(initial=0.0)
        if not left < 1e-8:  # of the residual: steady expressions may change this much per second
            where = f"system {self._model.system.name!r}"
            raise NoTrimError(f"{where}: no equilibrium was found; {left:.3g} is left")
        return Trim(z[: self._model.nx], z[self._model.nx :])

    def _near(self, z: Array) -> Array:
        """Minimise the residual to a few digits."""
        try:
            found = scipy.optimize.least_squares(
                self._residual, z, self._derivative, x_scale=self._scales
            )
        except (ValueError, KinolabError):  # an iterate is not finite or singular
            return z
        return self._landed(np.asarray(found.x))

    def _residual(self, z: Array) -> Array:
        x, u = z[: self._model.nx], z[self._model.nx :]
        rates = self._steady.derivative(x) @ self._model.f(x, u)
        return np.concatenate([rates, self._held.values(x) - self._values])

    def _landed(self, z: Array) -> Array:
        nx = self._model.nx
        return np.concatenate([self._model.project(z[:nx]), z[nx:]])

    def _derivative(self, z: Array) -> Array:
        columns = []
        for k, scale in enumerate(self._scales):
            h = np.zeros(len(z))
            h[k] = 1e-6 * scale  # of a state's scale, for finite differences of the residual
            columns.append((self._residual(z + h) - self._residual(z - h)) / (2 * h[k]))
        return np.stack(columns, axis=1)

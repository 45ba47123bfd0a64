"""Equations of motion by SymPy's own Lagrange derivation, for a machine that is not known by hand.

Energies and loads come from the machine's description; what is integrated is solved for by NumPy in
the full coordinates with multipliers, as on paper. Nothing that kinolab compiles is called.

Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, chapter 6.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from typing import Any, TypeAlias

import numpy as np
import sympy
from numpy.typing import NDArray

from kinolab.dynamics.lagrange.energies import kinetic_energy, weight_energy
from kinolab.dynamics.lagrange.equations import acceleration_of
from kinolab.dynamics.language.constraints import VelocityConstraint
from kinolab.dynamics.language.frames import time_derivative
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import loads, potentials, tangent_symbols
from kinolab.dynamics.language.quantities import written

Array: TypeAlias = NDArray[np.float64]
Slope: TypeAlias = Callable[[Array, Array], Array]


def slope_of(system: Mechanism, values: Mapping[str, float], states: Sequence[str]) -> Slope:
    """Return x_dot of a machine whose states are its coordinates and some of their rates.

    Args:
        system: Without attitudes, modes and auxiliary states; its feedback does not matter.
        values: Of its parameters.
        states: Names of its states.
    """
    named = {p: values[p.name] for p in system.parameters}
    v = tangent_symbols(system)
    a = [acceleration_of(rate) for rate in v]
    held = [c.velocity for c in system.constraints if isinstance(c, VelocityConstraint)]
    multipliers = sympy.symbols(f"multiplier_:{len(held)}", real=True)
    q, u = list(system.coordinates), [entry.symbol for entry in system.inputs]
    motion = _balance(system, v, a, held, multipliers)
    kept = [_along(c, v, a) for c in held]
    unknown = [*a, *multipliers]
    matrix, rest = sympy.linear_eq_to_matrix([*motion, *kept], unknown)
    rows, _ = sympy.linear_eq_to_matrix(held, v) if held else (sympy.zeros(0, len(v)), None)
    solve = _numbers([q, v, u], [matrix, rest], named)
    constraints = _numbers([q], rows, named)
    rates = [f"{coordinate.name}_dot" for coordinate in system.coordinates]
    free = [rates.index(name) for name in states[len(q) :]]
    return _slope(solve, constraints, free, len(v))


def _balance(
    system: Mechanism, v: Any, a: list[Any], held: list[Any], multipliers: tuple[Any, ...]
) -> list[Any]:
    """Return d/dt(dL/dv) - dL/dq - F - w^T lambda, one for each coordinate."""
    V = sum(map(written, potentials(system)), weight_energy(system))
    L = kinetic_energy(system) - V
    forces = [(written(load.magnitude), written(load.velocity)) for _, load in loads(system)]
    left = []
    for k, rate in enumerate(v):
        force = sum(strength * sympy.diff(speed, rate) for strength, speed in forces)
        pull = sum(m * sympy.diff(c, rate) for m, c in zip(multipliers, held, strict=True))
        change = _along(sympy.diff(L, rate), v, a)
        left.append(change - sympy.diff(L, system.coordinates[k]) - force - pull)
    return left


def _along(expression: Any, v: Any, a: list[Any]) -> Any:
    """Return the derivative in time of an expression in coordinates and rates."""
    turned = sum(sympy.diff(expression, rate) * by for rate, by in zip(v, a, strict=True))
    return time_derivative(expression) + turned


def _numbers(symbols: list[Any], expression: Any, named: dict[Any, float]) -> Callable[..., Any]:
    plain = [[sympy.Symbol(f"s{i}_{j}") for j in range(len(row))] for i, row in enumerate(symbols)]
    pairs = zip(chain(*symbols), chain(*plain), strict=True)
    swap = dict(pairs) | {p: sympy.Float(value, 17) for p, value in named.items()}
    many = expression if isinstance(expression, list) else [expression]
    made = [sympy.Matrix(one).xreplace(swap) for one in many]
    return sympy.lambdify(plain, made if isinstance(expression, list) else made[0], cse=True)


def _slope(
    solve: Callable[..., Any], constraints: Callable[..., Any], free: list[int], nq: int
) -> Slope:
    bound = [i for i in range(nq) if i not in free]

    def slope(x: Array, u: Array) -> Array:
        q, rates = x[:nq], np.zeros(nq)
        rates[free] = x[nq:]
        if bound:
            w = np.asarray(constraints(q), dtype=float)
            rates[bound] = np.linalg.lstsq(w[:, bound], -w @ rates, rcond=None)[0]
        matrix, rest = solve(q, rates, u)
        found = np.linalg.solve(np.asarray(matrix, float), np.asarray(rest, float).ravel())
        return np.concatenate([rates, found[:nq][free]])

    return slope

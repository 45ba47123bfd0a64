"""Where a function of time has no finite value or rate: poles, ends of its domain, jumps.

A formula is finite where its divisors and the arguments of its logarithms are not 0. Their zeros
are found between samples by bisection where they change sign, and by a search for their least size
where they only touch 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import sympy
from scipy.optimize import brentq, minimize_scalar

from kinolab.dynamics.movers import SAMPLES, t
from kinolab.numerics.arrays import Array

ROUNDING = 1e-12  # of the sizes of a sum's terms, which is nothing
NO_NUMBERS = (sympy.zoo, sympy.oo, -sympy.oo, sympy.nan, sympy.I)


def first_pole(formula: sympy.Expr, until: float) -> float | None:
    """Return the first time in [s] at which a formula or its rate is not finite; None without one.

    Args:
        formula: In ``t``.
        until: The last time that is looked at, in [s].
    """
    times = np.linspace(0.0, until, SAMPLES)
    found = [at for part in (formula, formula.diff(t)) for at in _poles(part, times)]
    return min(found, default=None)


def _poles(part: sympy.Expr, times: Array) -> Iterator[float]:
    yield from times[~np.isfinite(_values(part, times))][:1].tolist()
    for divisor in _divisors(part):
        yield from _first_zero(divisor, times)


def _divisors(part: sympy.Expr) -> Iterator[sympy.Expr]:
    """Yield what must not be 0; a rate has Dirac's delta where the formula jumps."""
    for inner in sympy.preorder_traversal(part):
        if inner.is_Pow and inner.exp.could_extract_minus_sign():
            yield inner.base
        elif isinstance(inner, sympy.log | sympy.DiracDelta):
            yield inner.args[0]
        elif isinstance(inner, sympy.tan):
            yield sympy.cos(inner.args[0])


def _values(part: sympy.Expr, times: Array) -> Array:
    """Return values (n,), which are not a number where they are none, or complex."""
    if part.has(*NO_NUMBERS):
        return np.full(times.shape, math.nan)
    smooth = part.replace(sympy.DiracDelta, lambda *_: sympy.Integer(0))
    with np.errstate(all="ignore"):
        found = np.broadcast_to(sympy.lambdify(t, smooth, "numpy")(times), times.shape)
    return np.asarray(np.where(np.imag(found) == 0.0, np.real(found), math.nan), dtype=float)


def _first_zero(divisor: sympy.Expr, times: Array) -> Iterator[float]:
    """Yield the first time at which a divisor is 0, if there is one."""
    values = _values(divisor, times)
    terms = sympy.Add(*map(sympy.Abs, divisor.args)) if divisor.is_Add else sympy.Integer(1)
    least = ROUNDING * _values(terms, times)

    def at(time: float) -> float:
        return float(_values(divisor, np.array([time]))[0])

    for k in np.flatnonzero(_near_zero(values)).tolist():
        a, b = times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)]
        if abs(values[k]) <= least[k]:
            yield float(times[k])
            return
        if values[k] * at(b) < 0.0:
            yield float(brentq(at, times[k], b))
            return
        low = minimize_scalar(lambda x: abs(at(x)), bounds=(a, b), options={"xatol": ROUNDING})
        if low.fun <= least[k]:
            yield float(low.x)
            return


def _near_zero(values: Array) -> Array:
    """Say which samples (n,) are 0, lie before a change of sign or are smaller than both beside."""
    sizes = np.pad(np.abs(values), 1, constant_values=math.inf)
    small = (sizes[1:-1] <= sizes[:-2]) & (sizes[1:-1] <= sizes[2:])
    changes = np.append(values[:-1] * values[1:] < 0.0, False)
    return np.asarray(small | changes)

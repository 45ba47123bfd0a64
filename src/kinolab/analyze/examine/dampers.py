"""Dampers beside springs: whether both see the same change of length."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import sympy

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.frames import distance, time_derivative
from kinolab.dynamics.language.mechanism_parts import (
    configuration_symbols,
    loads_in,
    tangent_symbols,
)
from kinolab.dynamics.language.quantities import written
from kinolab.numerics.arrays import Array


def dampers(subject: Subject) -> Iterator[Remark]:
    """Yield the dampers whose velocity is a spring's change of length but for signs of its terms.

    A spring and a damper that join two bodies are stretched alike, however these move.
    """
    system = subject.system
    springs = [e for e in system.efforts if hasattr(e, "stiffness") and not e.size]
    frictions = [e for e in system.efforts if e.size and not e.dry and not hasattr(e, "between")]
    if not springs or not frictions:
        return
    x = subject.moved(dict.fromkeys(subject.plain, 0.1))
    stretches = [_slopes(subject, time_derivative(distance(*e.between)), x) for e in springs]  # type: ignore[attr-defined]
    for effort in frictions:
        own = _slopes(subject, written(next(iter(loads_in(effort))).velocity), x)
        if (own != 0).sum() < 2 or any(_alike(own, s) or _alike(own, -s) for s in stretches):
            continue
        if any(_alike(np.abs(own), np.abs(stretch)) for stretch in stretches):
            yield _crossed(subject, effort, own, stretches)


def _crossed(subject: Subject, effort: Effort, own: Array, stretches: list[Array]) -> Remark:
    stretch = next(s for s in stretches if _alike(np.abs(own), np.abs(s)))
    stretch = stretch * np.sign(own @ stretch or 1.0)
    names = [str(s) for s in tangent_symbols(subject.system)]
    wrong = [n for n, a, b in zip(names, own, stretch, strict=True) if a * b < 0]
    what = "Its terms are those of the change of a spring's length, but for the sign of "
    what += f"{' and '.join(wrong)}: what joins the same two bodies is stretched alike."
    return Remark("damper unlike its spring", str(effort), what, (type(effort).__name__, ""))


def _slopes(subject: Subject, velocity: sympy.Expr, x: Array) -> Array:
    """Return the factors of all rates in a velocity at a state, shape (nt,)."""
    system, rates = subject.system, tangent_symbols(subject.system)
    symbols = [*configuration_symbols(system), *system.parameters]
    row = sympy.lambdify(symbols, [velocity.diff(rate) for rate in rates], "numpy")
    values = [system.parameter_values[p.name] for p in system.parameters]
    return np.array(row(*x[: subject.model.nq], *values), dtype=float)


def _alike(one: Array, other: Array) -> bool:
    # 0.05, relative: velocities of dampers are often written for small angles
    return bool(np.abs(one - other).max() <= 0.05 * np.abs(other).max())

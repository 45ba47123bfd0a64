"""Dampers beside springs: whether both see the same change of length; drag that should turn."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import sympy

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics import Body, Coordinate
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.frames import distance, time_derivative
from kinolab.dynamics.language.mechanism_parts import (
    configuration_symbols,
    loads_in,
    tangent_symbols,
)
from kinolab.dynamics.language.quantities import written
from kinolab.dynamics.symbols.expressions import is_zero
from kinolab.dynamics.symbols.symbols import RateSymbol
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
    ends = [e.between for e in springs]  # type: ignore[attr-defined]
    lengths = [time_derivative(distance(*between)) for between in ends]
    stretches = [slopes_by_rates(subject, one, x) for one in lengths]
    for effort in frictions:
        own = slopes_by_rates(subject, written(next(iter(loads_in(effort))).velocity), x)
        if (own != 0).sum() < 2 or any(_alike(own, s) or _alike(own, -s) for s in stretches):
            continue
        if any(_alike(np.abs(own), np.abs(stretch)) for stretch in stretches):
            yield _crossed(subject, effort, own, stretches)


def fixed_drags(subject: Subject) -> Iterator[Remark]:
    """Yield the drags of different size along fixed directions of what turns between them."""
    system, drags = subject.system, dict[Coordinate, Effort]()
    for effort in (e for e in system.efforts if e.size and not hasattr(e, "between")):
        rate = written(next(iter(loads_in(effort))).velocity)
        if isinstance(rate, RateSymbol) and rate.coordinate in subject.plain:
            drags |= {rate.coordinate: effort} if rate.coordinate.unit == "m" else {}
    for one, other in combinations(drags, 2):
        first, second = (getattr(drags[c], drags[c].size) for c in (one, other))
        bodies = [b for b in system.bodies if {one.name, other.name} & subject.moving(b.frame)]
        turning = [_turns_between(subject, body, one, other) for body in bodies]
        if turning and all(turning) and not is_zero(first - second):
            what = f"What {one} and {other} move turns, and these drags stay along the world's "
            what += "axes: it has another drag ahead when it heads another way. Those of a body "
            what += "go with it: V = velocity(frame), Viscous(V.x, …), Viscous(V.y, …)."
            part = (type(drags[other]).__name__, "")
            yield Remark("drag that does not turn", f"{one} and {other}", what, part)


def _turns_between(subject: Subject, body: Body, one: Coordinate, other: Coordinate) -> bool:
    """Whether a body turns, by an angle without limits, in the plane of two directions."""
    slopes, plain = subject.poses_by(subject.rest)[subject.place_of(body), :, 3], subject.plain
    across = np.cross(slopes[:, plain[one]], slopes[:, plain[other]])
    spins = subject.spin(body, subject.rest)
    free = [k for c, k in plain.items() if c.topology == "circle"]
    turns = np.abs(across @ spins[:, free]).max(initial=0.0)
    return bool(turns > 0.9 * np.linalg.norm(across) > 0)  # about the normal of that plane, nearly


def _crossed(subject: Subject, effort: Effort, own: Array, stretches: list[Array]) -> Remark:
    stretch = next(s for s in stretches if _alike(np.abs(own), np.abs(s)))
    stretch = stretch * np.sign(own @ stretch or 1.0)
    names = [str(s) for s in tangent_symbols(subject.system)]
    wrong = [n for n, a, b in zip(names, own, stretch, strict=True) if a * b < 0]
    what = "Its terms are those of the change of a spring's length, but for the sign of "
    what += f"{' and '.join(wrong)}: what joins the same two bodies is stretched alike."
    return Remark("damper unlike its spring", str(effort), what, (type(effort).__name__, ""))


def slopes_by_rates(subject: Subject, velocity: sympy.Expr, x: Array) -> Array:
    """Return the factors of all rates in a velocity at a state, shape (nt,)."""
    system, rates = subject.system, tangent_symbols(subject.system)
    symbols = [*configuration_symbols(system), *system.parameters]
    row = sympy.lambdify(symbols, [velocity.diff(rate) for rate in rates], "numpy")
    values = [system.parameter_values[p.name] for p in system.parameters]
    return np.array(row(*x[: subject.model.nq], *values), dtype=float)


def _alike(one: Array, other: Array) -> bool:
    # 0.05, relative: velocities of dampers are often written for small angles
    return bool(np.abs(one - other).max() <= 0.05 * np.abs(other).max())

"""Transitions of machines with modes: where one mode ends, and what the next one holds there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import sympy

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.dynamics import Coordinate, System
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.frames import pose
from kinolab.dynamics.language.modes import Transition
from kinolab.dynamics.symbols.expressions import exact
from kinolab.numerics.arrays import Array

SAMPLES = 8  # configurations at which a transition takes place
NEWTON = 20  # steps onto those
ROUNDING = 1e-9  # of a coordinate's scale


def landings(system: System) -> Iterator[Remark]:
    """Yield transitions after which a constraint does not hold, and those of bodies underground.

    Only such are judged as coordinates alone decide.
    """
    if not all(isinstance(c, Coordinate) for c in system.coordinates):
        return
    for transition in system.transitions:
        until = exact(transition.until).subs(system.substitutions)
        if until.free_symbols and until.free_symbols <= {*system.coordinates}:
            yield from _underground(system, transition, until)
            if transition.provided is None:
                yield from _missed(system, transition, until)


def _underground(system: System, transition: Transition, until: sympy.Expr) -> Iterator[Remark]:
    """Yield a mode that lasts until minus the height of a body falls to zero: while it is below."""
    down = (0.0, 0.0, 0.0) if system.gravity is None else system.gravity.down
    for body in system.bodies:
        place = pose(body.frame)[1].subs(system.substitutions)
        height = -sum(exact(d) * p for d, p in zip(down, place, strict=True))
        if height and sympy.expand(until + height) == 0:
            what = f"{transition.source!r} lasts until this falls to zero, and it is minus the "
            what += f"height of {body.name}: that mode ends at once wherever {body.name} is above "
            what += f"the ground. Is its sign wrong, until={-exact(transition.until)}?"
            yield Remark("lasts below the ground", transition.name, what, _part(transition))
            return


def _missed(system: System, transition: Transition, until: sympy.Expr) -> Iterator[Remark]:
    """Yield a constraint of position of the next mode that does not hold where it begins.

    Source: Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 4.4 (to the nearest
    configuration at which a transition takes place).
    """
    before, after = ([c for mode in system.modes if mode.name == name for c in mode.constraints]
                     for name in (transition.source, transition.target))  # fmt: skip
    always = [c for c in system.constraints if isinstance(c, PositionConstraint)]
    own = [*always, *(c for c in before if isinstance(c, PositionConstraint))]
    due = [c for c in after if isinstance(c, PositionConstraint) and c not in own]
    q, reset = list(system.coordinates), dict(transition.reset)
    values = system.substitutions
    there = [exact(reset.get(c, c)).subs(values) for c in q]
    if not due or not all(place.free_symbols <= {*q} for place in there):
        return
    moved = dict(zip(q, there, strict=True))
    held = sympy.Matrix([until, *(exact(c.position).subs(values) for c in own)])
    wanted = sympy.Matrix([exact(c.position).subs(values) for c in due]).subs(
        moved, simultaneous=True
    )
    at = sympy.lambdify([q], [held, held.jacobian(q), wanted], "numpy")
    off = np.zeros(len(due))
    for start in _places(system):
        where = _brought(at, start)
        if where is not None:
            off = np.maximum(off, np.abs(np.array(at(where)[2], dtype=float).ravel()))
    k = int(np.argmax(off))
    if off[k] > ROUNDING:
        what = f"Where it takes place, {due[k].name!r} of {transition.target!r} is off by up to "
        what += f"{off[k]:.2g}: nothing moves at that instant, so that it must have come there by "
        what += "until= or by reset=. Do a sign or a length differ between the two?"
        yield Remark("lands elsewhere", transition.name, what, _part(transition))


def _part(transition: Transition) -> tuple[str, str]:
    return "Transition", transition.name


def _places(system: System) -> Array:
    """Return random configurations about rest, shape (SAMPLES, nq)."""
    scales = np.array([c.scale for c in system.coordinates if isinstance(c, Coordinate)])
    low, high = (np.array([getattr(c, end) for c in system.coordinates])
                 for end in ("lower", "upper"))  # fmt: skip
    shares = np.random.default_rng(0).uniform(-1, 1, (SAMPLES, len(scales)))
    return np.asarray(np.clip(np.clip(0.0, low, high) + shares * scales, low, high))


def _brought(at: sympy.Function, q: Array) -> Array | None:
    """Return the configuration near another one at which a transition takes place, or None."""
    for _ in range(NEWTON):
        left, slopes, _ = (np.array(part, dtype=float) for part in at(q))
        if np.abs(left).max() <= ROUNDING / 10:
            return q
        q = q - np.linalg.lstsq(slopes, left.ravel(), rcond=ROUNDING)[0]
    return None

"""Plane curves of machines whose flat outputs are a point that rolls: heading and steering.

Source: Rouchon, Fliess, Levine, Martin, Flatness, motion planning and trailer systems, CDC 1993.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import sympy

from kinolab.dynamics.analysis.fields.system_fields import allowed_motions
from kinolab.dynamics.analysis.flat.control_system import ControlSystem
from kinolab.dynamics.analysis.flat.given_map import wrong_map
from kinolab.dynamics.language.flatness import CURVATURE, PlaneCurves
from kinolab.dynamics.symbols.symbols import Coordinate
from kinolab.errors import InputError


def plane_curves(
    control: ControlSystem, outputs: Sequence[sympy.Expr | None], left_over: Sequence[str]
) -> PlaneCurves | None:
    """Return how headings and steering angles follow from a plane curve; None if they do not.

    Args:
        left_over: Names of coordinates that they leave free.
    """
    system = control.system
    places = [one for one in outputs if isinstance(one, Coordinate) and one.unit == "m"]
    coordinates = [c for c in system.coordinates if isinstance(c, Coordinate)]
    if not len(places) == len(outputs) == 2 or len(coordinates) < len(system.coordinates):
        return None
    x, y = places
    rest = [c for c in coordinates if c not in places and c.name not in left_over]
    for heading in rest:
        others = [c for c in rest if c is not heading]
        for steered in _steering(control, x, y, heading, others):
            made = PlaneCurves(x, y, heading, steered)
            own = replace(control, system=system.changed(flat=made))
            if wrong_map(own) is None:
                return made
    return None


def _steering(
    control: ControlSystem,
    x: Coordinate,
    y: Coordinate,
    heading: Coordinate,
    others: Sequence[Coordinate],
) -> Iterator[tuple[tuple[Coordinate, sympy.Expr], ...]]:
    """Yield what a steered coordinate may be as a function of the curvature; nothing for none."""
    if not others:
        yield ()
    if len(others) != 1:
        return
    try:
        motions = allowed_motions(control.system)
    except InputError:  # its constraints depend on inputs
        return
    for field in motions:
        along = dict(zip(field.variables, field.components, strict=True))
        speed = along[x] * sympy.cos(heading) + along[y] * sympy.sin(heading)
        if (speed := sympy.trigsimp(speed)) == 0:
            continue
        bend = sympy.trigsimp(along[heading] / speed)
        if bend.free_symbols & set(control.system.coordinates) != set(others):
            continue
        for angle in sympy.solve(sympy.Eq(bend, CURVATURE), others[0]):
            yield ((others[0], sympy.simplify(angle)),)

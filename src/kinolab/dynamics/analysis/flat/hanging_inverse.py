"""Flat maps of machines in a vertical plane whose outputs accelerate along what hangs or lifts.

The only force on such a point besides weight is along an axis of the machine, so that the
acceleration less that of gravity has the axis' direction: of a rope, or of an aircraft's thrust.

Sources: Fliess, Levine, Martin, Rouchon, Int. J. Control 61(6), 1995, section 4.1; Martin, Devasia,
Paden, A different look at output tracking: control of a VTOL aircraft, Automatica 32(1), 1996.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import sympy

from kinolab.dynamics.analysis.flat.control_system import ControlSystem
from kinolab.dynamics.analysis.flat.given_map import wrong_map
from kinolab.dynamics.analysis.flat.output_candidates import Candidate, Candidates
from kinolab.dynamics.language.flatness import FlatOutputs, output
from kinolab.dynamics.symbols.symbols import Coordinate


def hanging_map(control: ControlSystem, outputs: Sequence[Candidate]) -> FlatOutputs | None:
    """Return how three coordinates follow from the place of a point; None if they do not."""
    system = control.system
    coordinates = [c for c in system.coordinates if isinstance(c, Coordinate)]
    if len(outputs) != 2 or not len(coordinates) == len(system.coordinates) == 3:
        return None
    for made in _maps(control, _placed(control, outputs), coordinates):
        if wrong_map(replace(control, system=system.changed(flat=made))) is None:
            return made
    return None


def _placed(control: ControlSystem, outputs: Sequence[Candidate]) -> dict[str, Candidate]:
    """Return outputs by the names of the world's axes along which they are; else nothing."""
    nodes = {one.node for one in outputs}
    points = [outputs, *(point.entries for point in Candidates(control).points)]
    for point in points:
        if {one.node for one in point} == nodes and all(one.frame is not None for one in point):
            return {"XYZ"[one.entry]: one for one in point}
    return {}


def _maps(
    control: ControlSystem, outputs: dict[str, Candidate], coordinates: Sequence[Coordinate]
) -> Iterator[FlatOutputs]:
    """Yield maps of which one may hold: the lean either way, and what then gives the place."""
    gravity, down = (
        control.system.gravity,
        dict(zip("XYZ", control.system.down or (), strict=False)),
    )
    upright = [name for name in outputs if abs(down.get(name, 0.0)) == 1.0]
    if gravity is None or len(upright) != 1:
        return
    (up,), (level,) = upright, [name for name in outputs if name not in upright]
    weight = gravity.strength * int(down[up])
    defined = tuple((name, one.expression) for name, one in outputs.items())
    lean = sympy.atan(output(level, 2) / (output(up, 2) - weight))
    for angle in coordinates:
        others = [c for c in coordinates if c is not angle]
        equations = [formula - output(name) for name, formula in defined]
        for solved in sympy.solve(equations, others, dict=True):
            rest = tuple((c, solved[c]) for c in others if c in solved)
            for turned in (lean, -lean):
                if len(rest) == len(others):
                    yield FlatOutputs(defined, ((angle, turned), *rest))

"""Whether a flat map that a machine says it has holds along the machine's own motions.

Coordinates that the map determines from a motion's outputs and their derivatives must be those of
the motion.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from kinolab.dynamics.analysis.flat.control_system import ControlSystem, MotionSeries
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.language.flatness import CURVATURE, FlatOutputs, PlaneCurves, output_symbols
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.model.model import Model
from kinolab.errors import InputError, Mistake
from kinolab.store import pickled

CHECKED = pickled("flat map", bool)


@dataclass(frozen=True)
class WrongMap:
    """A coordinate that a flat map gets wrong.

    Attributes:
        coordinate: Its name.
        true: Its value in [m] or [rad] in a motion.
        mapped: What the map makes of the outputs of that motion.
        outputs: These and their derivatives, by name.
    """

    coordinate: str
    true: float
    mapped: float
    outputs: dict[str, float]

    @property
    def sentence(self) -> str:
        """What is wrong, where, and by how much."""
        along = ", ".join(f"{name} = {value:.4g}" for name, value in self.outputs.items())
        return (
            f"in a motion of the machine with {along}, {self.coordinate} is {self.true:.6g}, and "
            f"the flat map makes it {self.mapped:.6g}."
        )


def check_flat_map(model: Model) -> None:
    """Raise if a machine's flat map is not the inverse of its outputs along its motions.

    Friction may be neglected by a map. A machine is checked once, which is remembered on disk.

    Raises:
        InputError: With the coordinate that is wrong, and by how much.
    """

    def checked() -> bool:
        system, plant = model.system, model.plant
        wrong = wrong_map(ControlSystem.of(plant.system, plant))
        if wrong is None:
            return True
        field = "steered" if isinstance(system.flat, PlaneCurves) else "determined"
        where = f"system {system.name!r} flat {field} {wrong.coordinate}"
        remedy = (
            "Correct its expression, which must hold along every motion without friction, or leave "
            "out flat=: plan describe tells which outputs are flat."
        )
        raise InputError([Mistake(where, wrong.sentence, remedy)])

    if model.machine.flat is not None and not model.machine.modes:
        CHECKED.get([model.key], checked)


def wrong_map(control: ControlSystem) -> WrongMap | None:
    """Return the first coordinate that the machine's flat map gets wrong; None if none is.

    Args:
        control: The machine; where its map does not hold, it is asked without its friction.
    """
    found = next(_wrong(control), None)
    system = control.system
    kept = without_friction(system)
    if found is None or len(kept) == len(system.efforts):
        return found
    return next(_wrong(ControlSystem.of(system.changed(efforts=kept), control.model)), None)


def without_friction(system: Mechanism) -> tuple[Effort, ...]:
    """Return the forces besides those that only take energy out; a rope pulls, too."""
    efforts = system.efforts
    return tuple(one for one in efforts if not one.size or hasattr(one, "stiffness"))


def _wrong(control: ControlSystem) -> Iterator[WrongMap]:
    """Yield what is wrong at a few states near rest."""
    scales = control.model.state_scales
    for motion in control.motions_near_rest():
        try:
            outputs, mapped = _mapped(control, motion)
        except ArithmeticError:
            continue  # a state at which something is singular
        for name, value in mapped.items():
            k = control.names.index(name)
            true = float(motion.start[0][k])
            other = motion.start[0].copy()
            other[k] = value
            off = control.model.space.difference(motion.start[0], other)[k]
            # of a coordinate, or of its scale if that is larger; formulas are exact
            if not abs(off) <= 1e-9 * max(abs(true), scales[k]):
                yield WrongMap(name, true, value, outputs)


def _mapped(
    control: ControlSystem, motion: MotionSeries
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the outputs of a motion, and what its machine's flat map makes of them."""
    flat = control.system.flat
    for _ in range(2):  # derivatives that a flat map may ask for
        motion.extend()
    if isinstance(flat, PlaneCurves):
        return _along_curve(control, flat, motion)
    assert isinstance(flat, FlatOutputs)
    return _by_outputs(control, flat, motion)


def _by_outputs(
    control: ControlSystem, flat: FlatOutputs, motion: MotionSeries
) -> tuple[dict[str, float], dict[str, float]]:
    """Return outputs with their derivatives, and the coordinates that follow from them."""
    lower = _lowering(control)
    values = motion.values([lower(formula) for _, formula in flat.outputs])
    symbols = [s for s in output_symbols(name for name, _ in flat.outputs) if s != CURVATURE]
    derivatives = (values * [1.0, 1.0, 2.0]).ravel()  # of Taylor coefficients
    outputs = dict(zip((s.name for s in symbols), map(float, derivatives), strict=True))
    return outputs, _evaluated(
        control, dict(zip(symbols, derivatives, strict=True)), flat.determined
    )


def _along_curve(
    control: ControlSystem, flat: PlaneCurves, motion: MotionSeries
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the curve with its derivatives, and heading and steered coordinates along it."""
    lower = _lowering(control)
    (x, x1, x2), (y, y1, y2) = motion.values([lower(flat.x), lower(flat.y)]) * [1.0, 1.0, 2.0]
    heading = float(motion.start[0][control.names.index(flat.heading.name)])
    ahead = math.copysign(1.0, x1 * math.cos(heading) + y1 * math.sin(heading))
    speed = ahead * math.hypot(x1, y1)
    curvature = (x1 * y2 - y1 * x2) / speed**3
    outputs = {"x": x, "x'": x1, "x''": x2, "y": y, "y'": y1, "y''": y2}
    mapped = {flat.heading.name: math.atan2(ahead * y1, ahead * x1)}
    mapped |= _evaluated(control, {CURVATURE: curvature}, flat.steered)
    return {name: float(value) for name, value in outputs.items()}, mapped


def _evaluated(
    control: ControlSystem, given: Mapping[Any, float], pairs: Sequence[tuple[Any, Any]]
) -> dict[str, float]:
    """Return coordinates by name from expressions of outputs and of coordinates before them."""
    found, known = {}, {**given, **control.system.substitutions}
    for coordinate, formula in pairs:
        with np.errstate(all="ignore"):
            value = complex(sympy.sympify(formula.xreplace(known)).evalf())
        found[coordinate.name] = value.real if value.imag == 0.0 else math.nan
        known[coordinate] = found[coordinate.name]
    return found


def _lowering(control: ControlSystem) -> Lowering:
    fields = control.fields
    named = {s.name: s for s in (*fields.symbols, *fields.constants)}
    return Lowering(control.tape, {s: control.tape.variable(name) for name, s in named.items()})

"""Validation of a machine description before derivation."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import is_dataclass
from numbers import Real
from typing import Any

import numpy as np
import sympy

from kinolab.dynamics.language.bodies import Body, Cable
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.feedback import Feedback, Regulator
from kinolab.dynamics.language.flatness import CURVATURE, FlatOutputs, output_symbols
from kinolab.dynamics.language.forces import Effort, Friction, Load, Potential, Rope
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.dynamics.language.mechanism_parts import (
    AnyCoordinate,
    MechanismParts,
    atoms_of,
    configuration_symbols,
    quasi_velocities,
    tangent_symbols,
)
from kinolab.dynamics.language.modes import MODE
from kinolab.dynamics.language.quantities import Change, FrameSpeed, written
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity, QuasiVelocitySymbol
from kinolab.dynamics.language.shapes import MAX_COORDINATE, Shape
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import (
    Attitude,
    Coordinate,
    ForceSymbol,
    InputSymbol,
    Parameter,
    QuaternionEntry,
    ReferenceSymbol,
    StateSymbol,
)
from kinolab.dynamics.symbols.words import primitives_of, require_hashable
from kinolab.errors import InputError, Mistake, flaw_of, is_broken, printable, unknown_name

TRIANGLE_TOLERANCE = 1e-9  # relative rounding allowed in eigenvalues of inertias


def mistakes_of(
    system: MechanismParts, atoms: set[sympy.Symbol | Attitude], used: set[AnyCoordinate]
) -> Iterator[Mistake]:
    """Yield every mistake in a description.

    Args:
        system: The machine.
        atoms: Every symbol and attitude in it.
        used: Every coordinate in it.
    """
    if not system.bodies:
        yield Mistake(_where(system), "it has no bodies.")
    yield from _naming(system)
    yield from _values(system)
    yield from _offers(system)
    if not all(_is_number(value) for _, value in system.values):
        return  # nothing that depends on parameters can be validated
    yield from _symbols(system, atoms)
    yield from _modes(system)
    yield from _coordinates(system, used)
    yield from _references(system)
    yield from _places(system)
    yield from _flatness(system)
    yield from _feedback(system)
    for body in system.bodies:
        yield from _body(system, body)
        for shape in body.shapes:
            yield from _shape(system, body, shape)
    for cable in system.cables:
        yield from _cable(system, cable)
    yield from _forces(system)
    for entry in system.inputs:
        try:
            bounds_of(entry)
        except InputError as error:
            yield from error.mistakes


def _forces(system: MechanismParts) -> Iterator[Mistake]:
    """Check forces, those of modes included, and what position constraints depend on."""
    moving = {*tangent_symbols(system), *(v.symbol for v in quasi_velocities(system))}
    efforts = (*system.efforts, *(e for mode in system.modes for e in mode.efforts))
    for effort in efforts:
        if isinstance(effort, Rope):
            yield from _rope(system, effort)
        elif effort.size:
            yield from _size(system, effort)
    for word in (*system.inputs, *efforts):
        parts = primitives_of(word)
        for part in parts:
            if isinstance(part, Potential):
                remedy = "Give a function of coordinates; a Wrench takes the rest."
                yield from _velocities(part.energy, moving, "potential", "its energy", remedy)
        if _acts_on_nothing([part for part in parts if isinstance(part, Load)], moving):
            remedy = "Write rate(x) for the velocity of a coordinate x, or a velocity such as V.x."
            yield Mistake(str(word), "no rate occurs in it.", remedy)
    remedy = "closed() takes a function of coordinates, zero() a velocity."
    for c in system.all_constraints:
        if isinstance(c, PositionConstraint):
            yield from _velocities(c.position, moving, f"constraint {c.name!r}", "it", remedy)


def _modes(system: MechanismParts) -> Iterator[Mistake]:
    """Report transitions between modes that do not exist, and resets of what is no state."""
    names = [mode.name for mode in system.modes]
    if system.transitions and not names:
        remedy = "List them: modes=[Mode(…)]."
        yield Mistake(_where(system), "it has transitions but no modes.", remedy)
        return
    symbols = {
        *configuration_symbols(system),
        *tangent_symbols(system),
        *(entry.symbol for entry in system.states if entry.name != MODE),
    }
    for transition in system.transitions:
        where = f"transition {transition.name!r}"
        for key in ("source", "target"):
            if (given := getattr(transition, key)) not in names:
                yield unknown_name("mode", given, known=names, where=f"{where} {key}")
        for symbol, _ in transition.reset:
            if symbol not in symbols:
                what = f"it resets {symbol}, which is no coordinate, rate or state of the machine."
                yield Mistake(where, what, "Take a coordinate, rate(coordinate) or state(name).")
        bounce = None if transition.restitution is None else exact(transition.restitution)
        if bounce is not None and not bounce.free_symbols - set(system.parameters):
            value = system.number(bounce)
            if not 0.0 <= value <= 1.0:
                what = f"its restitution is {value:g}."
                yield Mistake(where, what, "Give a number between 0 and 1.")
    if MODE in _names(system.inputs) | _names(system.parameters) and names:
        what = f"a machine with modes has a state {MODE!r} already."
        yield Mistake(_where(system), what, "Give the input or parameter another name.")


def _where(system: MechanismParts) -> str:
    return f"system {system.name!r}"


def _naming(system: MechanismParts) -> Iterator[Mistake]:
    references = () if system.feedback is None else system.feedback.references
    own: list[Sequence[Any]] = [system.inputs, system.states, references, quasi_velocities(system)]
    named = [entry for entries in own for entry in entries]
    bearers: dict[tuple[str, str], Sequence[Any]] = {
        ("a coordinate", "coordinates"): configuration_symbols(system),
        ("a rate", "rates"): tangent_symbols(system),
        ("a parameter", "parameters"): system.parameters,
        ("an input", "inputs"): system.inputs,
        ("a state", "states"): system.states,
        ("a reference", "references"): references,
        ("a quasi-velocity", "quasi-velocities"): quasi_velocities(system),
    }
    groups = {
        "name": [entry.name for entries in bearers.values() for entry in entries],
        "body": [body.name for body in system.bodies],
        "cable": [*(cable.name for cable in system.cables), *{body.name for body in system.bodies}],
        "constraint": [constraint.name for constraint in system.all_constraints],
        "mode": [mode.name for mode in system.modes],
        "transition": [transition.name for transition in system.transitions],
    }
    for kind, names in groups.items():
        for name, count in Counter(names).items():
            if count > 1:
                what = f"{_bearers(name, bearers) if kind == 'name' else count} have this name."
                yield Mistake(f"{kind} {name!r}", what, "Give each a name of its own.")
    texts = [system.name, *(parameter.unit for parameter in system.parameters)]
    texts += [requirement.name for requirement in system.all_requirements]
    for text in dict.fromkeys([*texts, *(name for names in groups.values() for name in names)]):
        if isinstance(text, str) and is_broken(text):
            yield Mistake(f"{printable(text)!r}", "this is no Unicode text.", "Write it in UTF-8.")
        elif isinstance(text, str) and (flaw := flaw_of(text)):
            where = f"{printable(text[:60])!r}"  # characters of a name that is refused
            yield Mistake(where, f"this name {flaw}.", "Give a shorter or plainer one.")
    for entry in named:
        if not entry.name.isidentifier():
            remedy = "Use letters, digits and underscores, beginning with a letter."
            yield Mistake(f"{entry.name!r}", "this is not a usable name.", remedy)


def _bearers(name: str, bearers: dict[tuple[str, str], Sequence[Any]]) -> str:
    """Return what has a name, such as ``2 coordinates`` or ``a coordinate and an input``."""
    counts = {kind: sum(e.name == name for e in entries) for kind, entries in bearers.items()}
    return " and ".join(
        one if count == 1 else f"{count} {many}" for (one, many), count in counts.items() if count
    )


def _values(system: MechanismParts) -> Iterator[Mistake]:
    known = [parameter.name for parameter in system.parameters]
    for name, value in system.values:
        if name not in known:
            listed = sorted({*known, *system.offered})
            yield unknown_name("parameter", name, known=listed, where=_where(system))
        elif not _is_number(value):
            yield Mistake(f"parameter {name!r}", f"its value is {value!r}.", "Give a number.")
    for name in system.keep:
        if name not in known:
            yield unknown_name("parameter", name, known=known, where=f"{_where(system)} keep")


def _offers(system: MechanismParts) -> Iterator[Mistake]:
    """Report numbers that are offered of what the machine does not have."""
    names = [p.name for offer in system.offers for p, _ in offer.parameters()]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield Mistake(f"parameter {name!r}", "it is offered twice.", "Give each its own name.")
    own = [p.name for p in system.parameters]
    for offer in system.offers:
        if not offer.fits(system.bodies, system.efforts, own):
            what = f"it offers {offer.parameters()[0][0]} of what it does not have."
            yield Mistake(_where(system), what, "Leave the offer out, or the forces as they were.")


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)


def _symbols(system: MechanismParts, atoms: set[sympy.Symbol | Attitude]) -> Iterator[Mistake]:
    """Report symbols that are no machine symbols, or not of this machine."""
    known: dict[type, set[str]] = {
        InputSymbol: {entry.name for entry in system.inputs},
        StateSymbol: {entry.name for entry in system.states},
        ForceSymbol: {constraint.name for constraint in system.all_constraints},
        QuasiVelocitySymbol: _names(quasi_velocities(system)),
        ReferenceSymbol: set() if system.feedback is None else _names(system.feedback.references),
    }
    declared = {*configuration_symbols(system), *tangent_symbols(system)}
    for atom in sorted(atoms, key=str):
        kind = type(atom)
        if kind in known and atom.name not in known[kind]:
            what = f"the symbol {atom} belongs to an input, state, velocity, reference or "
            what += "constraint it does not list."
            yield Mistake(_where(system), what, "List it, or take the symbol out.")
        elif not isinstance(atom, (Attitude, Coordinate, Parameter, *known)) and not any(
            type(symbol) is kind for symbol in declared
        ):
            remedy = "Make it with length, angle, rotation, parameter, rate or state."
            yield Mistake(_where(system), f"the symbol {atom} is not declared.", remedy)


def _names(entries: Sequence[Any]) -> set[str]:
    return {entry.name for entry in entries}


def _coordinates(system: MechanismParts, used: set[AnyCoordinate]) -> Iterator[Mistake]:
    listed = set(system.coordinates)
    for coordinate in sorted(used - listed, key=lambda c: c.serial):
        what = f"the coordinate {coordinate.name} is used but not listed in coordinates."
        yield Mistake(_where(system), what)
    for coordinate in system.coordinates:
        if coordinate not in used:
            what = f"the coordinate {coordinate.name} moves nothing."
            yield Mistake(_where(system), what, "Use it in a frame, or leave it out.")
    if isinstance(system.velocities, str):
        if system.velocities != "all":
            what = f"velocities is {system.velocities!r}."
            yield Mistake(_where(system), what, 'Give a list of coordinates, or "all".')
        return
    for chosen, count in Counter(system.velocities or ()).items():
        if count > 1:
            yield Mistake(_where(system), f"{chosen.name} is named twice in velocities.")
        if isinstance(chosen, QuasiVelocity):
            yield from _quasi_velocity(system, chosen)
        elif chosen not in listed:
            what = f"{chosen.name} is named in velocities but is no coordinate of the machine."
            yield Mistake(_where(system), what)


def _quasi_velocity(system: MechanismParts, chosen: QuasiVelocity) -> Iterator[Mistake]:
    """Check that a quasi-velocity is one of this machine's coordinates, rates and parameters."""
    known = {*configuration_symbols(system), *tangent_symbols(system), *system.parameters}
    for symbol in sorted(exact(chosen.velocity).free_symbols - known, key=str):
        what = f"{symbol} is no coordinate, rate or parameter of the machine."
        yield Mistake(f"velocity {chosen.name!r}", what, "State a velocity, such as V.x.")


def _references(system: MechanismParts) -> Iterator[Mistake]:
    """Report bodies that are acted on but are not part of the machine."""
    names = [body.name for body in system.bodies]
    for part in (*system.inputs, *system.efforts):
        for role in ("on", "reacts_on"):
            body = getattr(part, role, None)
            if isinstance(body, Body) and body not in system.bodies:
                label = getattr(part, "name", type(part).__name__)
                what = f"it acts on the body {body.name!r}, which the system does not list."
                remedy = "Add it to bodies, or take the force out."
                yield Mistake(f"{type(part).__name__.lower()} {label!r}", what, remedy)
    names += [cable.name for cable in system.cables if cable.collides]
    kind = "body or cable that collides" if system.cables else "body"
    for word in ("collisions", "unwatched"):
        for name in (name for pair in getattr(system, word) for name in pair):
            if name not in names:
                yield unknown_name(kind, name, known=names, where=f"{_where(system)} {word}")


def _places(system: MechanismParts) -> Iterator[Mistake]:
    """Check that frames depend on coordinates and parameters, gravity on parameters only."""
    for body in system.bodies:
        for symbol in sorted(set(atoms_of(body.frame)), key=str):
            if not isinstance(symbol, Attitude | Coordinate | QuaternionEntry | Parameter):
                what = f"its frame depends on {symbol}; a frame is a function of coordinates alone."
                yield Mistake(f"body {body.name!r}", what)
    if system.gravity is None:
        return
    parts = {"strength": (exact(system.gravity.strength),)}
    parts["direction"] = tuple(map(exact, system.gravity.down))
    for name, stated in parts.items():
        if not all(isinstance(s, Parameter) for part in stated for s in part.free_symbols):
            what = f"its {name} is {', '.join(map(str, stated))}."
            remedy = "Give numbers or parameters; Potential takes the rest."
            yield Mistake("gravity", what, remedy)
            return
    strength = system.number(system.gravity.strength)
    if not 0 <= strength < math.inf:
        remedy = "Give 0 or more; its direction says which way it pulls: toward('-z', 9.81)."
        yield Mistake("gravity", f"its strength is {strength:g} m/s^2.", remedy)
    length = math.hypot(*map(system.number, system.gravity.down))
    if not math.isclose(length, 1.0, rel_tol=1e-9):
        what = f"({', '.join(map(str, system.gravity.down))}) is not a unit vector."
        yield Mistake("gravity", what, f"Its length is {length:.9g}; divide by that.")


def _flatness(system: MechanismParts) -> Iterator[Mistake]:
    """Check that a flat map uses the machine's coordinates and parameters."""
    if system.flat is None:
        return
    where, flat = f"{_where(system)} flat", system.flat
    for coordinate in flat.coordinates:
        if coordinate not in system.coordinates:
            yield Mistake(where, f"{coordinate} is no coordinate of the machine.")
    if isinstance(flat, FlatOutputs):
        yield from _flat_outputs(system, flat, where)
        return
    own = {*flat.coordinates, CURVATURE, *system.parameters}
    for coordinate, expression in flat.steered:
        for symbol in sorted(exact(expression).free_symbols - own, key=str):
            what = f"the symbol {symbol} means nothing here."
            yield Mistake(f"{where} steered {coordinate}", what, "Use CURVATURE and parameters.")


def _flat_outputs(system: MechanismParts, flat: FlatOutputs, where: str) -> Iterator[Mistake]:
    """Check that outputs are functions of coordinates, and coordinates of outputs, in order."""
    for name, count in Counter(name for name, _ in flat.outputs).items():
        if count > 1:
            what = f"{count} outputs have this name."
            yield Mistake(f"{where} outputs {name!r}", what, "Give each a name of its own.")
    for name, expression in flat.outputs:
        own = {*system.coordinates, *system.parameters}
        for symbol in sorted(exact(expression).free_symbols - own, key=str):
            what = f"the symbol {symbol} means nothing here."
            remedy = "Define an output by coordinates and parameters."
            yield Mistake(f"{where} outputs {name!r}", what, remedy)
        for symbol in system.coordinates:
            if symbol in exact(expression).free_symbols and symbol not in flat.coordinates:
                what = f"it is defined by {symbol}, which the outputs do not determine."
                remedy = f"Add ({symbol}, …) to determined."
                yield Mistake(f"{where} outputs {name!r}", what, remedy)
    known = {*system.parameters, *output_symbols(name for name, _ in flat.outputs)} - {CURVATURE}
    for coordinate, expression in flat.determined:
        for symbol in sorted(exact(expression).free_symbols - known, key=str):
            if symbol in system.coordinates:
                what = f"it is a function of {symbol}, which is not determined before it."
                remedy = f"Put ({symbol}, …) before it, or use outputs instead."
            else:
                what = f"the symbol {symbol} means nothing here."
                remedy = "Use output(name, order) up to order 2 of the outputs "
                remedy += f"{', '.join(name for name, _ in flat.outputs)}, coordinates listed "
                remedy += "before, and parameters."
            yield Mistake(f"{where} determined {coordinate}", what, remedy)
        known.add(coordinate)


def _feedback(system: MechanismParts) -> Iterator[Mistake]:
    """Check that a controller determines every input of the machine, and nothing else."""
    feedback, where = system.feedback, f"{_where(system)} feedback"
    if feedback is None:
        return
    if not feedback.references:
        yield Mistake(where, "it has no references.", "Give one at least; planners choose them.")
    for entry in feedback.references:
        try:
            bounds_of(entry, "reference")
        except InputError as error:
            yield from error.mistakes
    inputs = [entry.name for entry in system.inputs]
    if isinstance(feedback, Feedback):
        given = Counter(name for name, _ in feedback.law)
        for name in given:
            if name not in inputs:
                yield unknown_name("input", name, known=inputs, where=where)
        for name in inputs:
            if given[name] != 1:
                yield Mistake(where, f"its law gives {name} {given[name]} times.", "Give it once.")
    else:
        yield from _regulator(system, feedback, where)


def _regulator(system: MechanismParts, regulator: Regulator, where: str) -> Iterator[Mistake]:
    """Check that a regulator's design problem is well posed."""
    inputs, tracked = [entry.name for entry in system.inputs], [z for z, _ in regulator.tracked]
    units = {entry.symbol: entry.unit for entry in regulator.references}
    for z, wanted in regulator.about:
        if isinstance(z, Coordinate) and units.get(wanted) == f"{z.unit}/s":
            what = f"{wanted} is in {units[wanted]}, and about= gives it to {z}, in {z.unit}."
            yield Mistake(where, what, f"Write rate({z}) there.")
        elif z not in tracked:
            yield Mistake(where, f"{z} has a value in equilibrium but is not tracked.", "Track it.")
    for kind, known, pairs in (
        ("input", inputs, regulator.efforts),
        ("reference", [entry.name for entry in regulator.references], regulator.schedule),
    ):
        for name, _ in pairs:
            if name not in known:
                yield unknown_name(kind, name, known=known, where=where)
    large = [(str(z), size) for z, size in regulator.tracked] + list(regulator.efforts)
    for what, size in large:
        if not (size > 0 and math.isfinite(size)):
            remedy = "It must be positive."
            yield Mistake(where, f"what counts as large for {what} is {size:g}.", remedy)
    for name, degree in regulator.schedule:
        if not 0 <= degree <= 8:
            yield Mistake(where, f"the degree in {name} is {degree}.", "Take 0 to 8.")


def _shape(system: MechanismParts, body: Body, shape: Shape) -> Iterator[Mistake]:
    """Check that a shape is a solid, and that its dimensions are positive numbers."""
    where = f"body {body.name!r} {shape.called.lower()}"
    if not (is_dataclass(type(shape)) and hasattr(shape, "at")):
        remedy = (
            "Write @dataclass(frozen=True) above it, and at: Point = ORIGIN below its dimensions."
        )
        yield Mistake(f"class {shape.called}", "it is not a dataclass with a field at.", remedy)
        return
    found = [*_place(shape, where), *_dimensions(system, shape, where)]
    if not found:
        try:
            require_hashable(shape)
            system.resolved_shape(shape)
        except InputError as error:
            found = list(error.mistakes)
    for symbol, value in getattr(shape, "made_for", ()):
        if (now := system.number(symbol)) != value:
            what = f"it was made for {symbol} = {value:g}, and {symbol} is {now:g}."
            found.append(Mistake(where, what, "Take the value, or make the machine's file anew."))
    yield from found


def _place(shape: Shape, where: str) -> Iterator[Mistake]:
    """Check where a shape is."""
    if shape.axis not in ("x", "y", "z"):
        yield unknown_name("axis", str(shape.axis), known=("x", "y", "z"), where=where)
    if not isinstance(shape.at, tuple) or len(shape.at) != 3:
        yield Mistake(where, f"at is {shape.at!r}.", "Give three numbers (x, y, z) in [m].")


def _dimensions(system: MechanismParts, shape: Shape, where: str) -> Iterator[Mistake]:
    """Check that a shape's dimensions are positive numbers, and where it is numbers."""
    for name in (*shape.lengths(), "at"):
        value = getattr(shape, name)
        try:
            entries = value if isinstance(value, tuple) and value else (value,)
            numbers = [system.number(exact(entry)) for entry in entries]
        except (InputError, TypeError):
            what = f"{name} is {value!r}."
            yield Mistake(where, what, "Give numbers, or expressions of parameters.")
            continue
        farthest = max(numbers, key=abs)
        if abs(farthest) > MAX_COORDINATE:
            what = f"{name} is {farthest:g} m."
            yield Mistake(where, what, f"Stay within {MAX_COORDINATE:g} m.")
        elif name != "at" and not numbers[0] > 0:
            stated = "" if isinstance(value, float | int) else f"{value} = "
            yield Mistake(where, f"{name} is {stated}{numbers[0]:g} m.", "It must be positive.")


def _cable(system: MechanismParts, cable: Cable) -> Iterator[Mistake]:
    """Check that a cable's radius is a positive number."""
    where = f"cable {cable.name!r}"
    try:
        radius = system.number(exact(cable.radius))
    except (InputError, TypeError):
        what = f"its radius is {cable.radius!r}."
        yield Mistake(where, what, "Give a number, or an expression of parameters.")
        return
    if not radius > 0:
        remedy = "It must be positive; collides=False is for cables that are only drawn."
        yield Mistake(where, f"its radius is {radius:g} m.", remedy)


def _rope(system: MechanismParts, rope: Rope) -> Iterator[Mistake]:
    """Check that a rope's length depends on coordinates alone, and that it is no motor."""
    length = exact(rope.length)
    for symbol in sorted(length.free_symbols, key=str):
        if not isinstance(symbol, Coordinate | Parameter):
            what = f"its length depends on {symbol}."
            yield Mistake("rope", what, "Take a coordinate, and a Drive on it for a winch.")
    for name in ("stiffness", "damping"):
        value = _number_in(system, getattr(rope, name))
        if value is None:
            what = f"its {name} is {getattr(rope, name)}."
            yield Mistake("rope", what, "Give a number, or an expression of parameters.")
        elif not 0 <= value < math.inf:
            yield Mistake("rope", f"its {name} is {value:g}.", "Give 0 or more.")
    longest = _number_in(system, length)
    if longest is not None and not longest > 0:
        yield Mistake("rope", f"its length is {longest:g} m.", "It must be positive.")


def _velocities(
    stated: Any, moving: set[sympy.Symbol], where: str, subject: str, remedy: str
) -> Iterator[Mistake]:
    """Report the velocities on which something depends that may not depend on any."""
    found = exact(stated)
    for symbol in sorted(found.free_symbols & moving | found.atoms(Change), key=str):
        yield Mistake(where, f"{subject} depends on the velocity {symbol}.", remedy)


def _acts_on_nothing(loads: Sequence[Load], moving: set[sympy.Symbol]) -> bool:
    """Whether a load is along something that is not a velocity."""
    along = (e.velocity for e in loads if not isinstance(e.velocity, FrameSpeed | Change))
    return not all(velocity.free_symbols & moving for velocity in map(written, along))


def _size(system: MechanismParts, effort: Effort) -> Iterator[Mistake]:
    """Check that a force against velocities takes energy out, as far as numbers tell."""
    names = [name for name in vars(effort) if name != "_"]
    if effort.size not in names:
        what, remedy = (
            f"its size is {effort.size!r}.",
            f"Name one of its fields: {', '.join(names)}.",
        )
        yield Mistake(f"class {type(effort).__name__}", what, remedy)
        return
    value = _number_in(system, getattr(effort, effort.size))
    if value is not None and not 0 <= value < math.inf:
        remedy = "Give 0 or more: friction takes energy out. A Wrench may feed it in."
        yield Mistake(str(effort), f"its {effort.size} is {value:g}.", remedy)
    smoothing = _number_in(system, getattr(effort, "smoothing", 1.0))
    if isinstance(effort, Friction) and smoothing is not None and not 0 < smoothing < math.inf:
        remedy = "It must be positive."
        yield Mistake(str(effort), f"its smoothing is {smoothing:g}.", remedy)


def _number_in(system: MechanismParts, value: Any) -> float | None:
    """Return an expression's value; None if it depends on more than parameters."""
    stated = exact(value)
    known = all(isinstance(symbol, Parameter) for symbol in stated.free_symbols)
    return system.number(stated) if known else None


def _body(system: MechanismParts, body: Body) -> Iterator[Mistake]:
    where = f"body {body.name!r}"
    try:
        mass = system.number(body.mass)
        entries = [system.number(entry) for entry in body.inertia_matrix]
        added = [system.number(entry) for row in body.added_mass for entry in row]
    except TypeError:
        yield Mistake(where, "its mass or inertia depends on more than numbers and parameters.")
        return
    if not np.isfinite([mass, *entries, *added]).all():
        yield Mistake(where, "its mass or inertia is not finite.")
        return
    if mass < 0:
        yield Mistake(where, f"its mass is {mass:g} kg.", "A mass is 0 or positive.")
    a, b, c = np.linalg.eigvalsh(np.reshape(entries, (3, 3)))
    if a < -TRIANGLE_TOLERANCE * max(c, 1e-300) or a + b < c * (1 - TRIANGLE_TOLERANCE):
        what = f"no rigid body has the principal moments {a:g}, {b:g}, {c:g} kg m^2."
        remedy = "Each must be at least 0 and at most the sum of the other two."
        yield Mistake(where, what, remedy)
    if added and np.linalg.eigvalsh(np.reshape(added, (6, 6)))[0] < -TRIANGLE_TOLERANCE * max(
        added
    ):
        yield Mistake(where, "its added mass is not positive semidefinite.")

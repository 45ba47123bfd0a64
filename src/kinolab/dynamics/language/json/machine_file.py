"""Reading and writing a ``Mechanism`` as JSON: plain data, no code is executed."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from itertools import count
from pathlib import Path
from typing import Any

import sympy

from kinolab.dynamics.language.bodies import Body, Cable
from kinolab.dynamics.language.constraints import (
    PositionConstraint,
    Requirement,
    VelocityConstraint,
)
from kinolab.dynamics.language.feedback import Feedback, Reference, Regulator
from kinolab.dynamics.language.flatness import FlatOutputs, PlaneCurves, output_symbols
from kinolab.dynamics.language.forces import FORCES, Gravity
from kinolab.dynamics.language.frames import Axis, Frame, Orientation, Rotation, Translation
from kinolab.dynamics.language.inputs import INPUTS
from kinolab.dynamics.language.joint_friction import JointFriction
from kinolab.dynamics.language.json.expression_tree import (
    expanded_size,
    expression_to_tree,
    tree_to_expression,
)
from kinolab.dynamics.language.json.known_words import in_known_words
from kinolab.dynamics.language.json.machine_folder import FEEDBACK_FILE, MACHINE_FILE
from kinolab.dynamics.language.json.size_limits import size_mistakes, written_out
from kinolab.dynamics.language.lumped_mass import Lump, LumpedMass
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import quasi_velocities
from kinolab.dynamics.language.modes import Mode, Transition
from kinolab.dynamics.language.quantities import FrameSpeed
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity, State
from kinolab.dynamics.language.shapes import SHAPES, DrawnMesh, Hull
from kinolab.dynamics.symbols.expressions import parts_of
from kinolab.dynamics.symbols.symbols import (
    KINDS,
    Attitude,
    Coordinate,
    ForceSymbol,
    InputSymbol,
    MachineSymbol,
    Parameter,
    ReferenceSymbol,
    StateSymbol,
    rotation,
)
from kinolab.errors import InputError, Mistake, UnknownNameError, printable
from kinolab.untrusted import ELEMENTS, json_of, read

FORMAT, VERSION = "kinolab machine", 1
DAMAGED = (
    *(InputError, ArithmeticError, AttributeError, LookupError),
    *(RecursionError, TypeError, ValueError),
)

RECORDS: dict[str, type] = {
    kind.__name__: kind
    for kind in (
        *(Axis, Frame, Orientation, Rotation, Translation),
        *(Gravity, FrameSpeed, *FORCES, *INPUTS),
        *(Cable, PositionConstraint, Requirement, State, VelocityConstraint),
        *(FlatOutputs, PlaneCurves),
        *(Feedback, QuasiVelocity, Reference, Regulator),
        *(Mode, Transition),
        *(JointFriction, Lump, LumpedMass),
        *(DrawnMesh, Hull, *SHAPES),
    )
}
CONTENT = ("constraints", "inputs", "efforts", "gravity", "states", "requirements", "cables")
FURTHER = ("modes", "transitions", "offers")  # of machines that have some
BODY = ("name", "frame", "mass", "inertia", "added_mass", "shapes", "touches_ground", "color")


def machine_to_json(system: Mechanism) -> str:
    """Serialize a system as JSON text.

    A word from outside the package stands there as what it lowers to, so that reading a file runs
    no code of others.
    """
    system = in_known_words(system, RECORDS.values())
    velocities = system.velocities
    document: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "name": system.name,
        "coordinates": [_coordinate(c) for c in system.coordinates],
        "parameters": [
            {"name": p.name, "default": p.default, "unit": p.unit} for p in system.parameters
        ],
        "values": dict(system.values),
        **({"keep": list(system.keep)} if system.keep else {}),
        "velocities": velocities
        if velocities is None or isinstance(velocities, str)
        else [_encode(c) if isinstance(c, QuasiVelocity) else c.name for c in velocities],
        "collisions": [list(pair) for pair in system.collisions],
        **({"unwatched": [list(pair) for pair in system.unwatched]} if system.unwatched else {}),
        **({"notes": [list(pair) for pair in system.notes]} if system.notes else {}),
        **({"expected": list(system.expected)} if system.expected else {}),
        "bodies": [_described(system, body) for body in system.bodies],
        **{name: _encode(getattr(system, name)) for name in CONTENT},
        **{name: _encode(getattr(system, name)) for name in FURTHER if getattr(system, name)},
        **({} if system.flat is None else {"flat": _encode(system.flat)}),
        **({} if system.feedback is None else {"feedback": feedback_to_tree(system.feedback)}),
    }
    return _json(document)


def machine_from_json(text: str, *, where: str = "machine.json") -> Mechanism:
    """Read a system from JSON text.

    Raises:
        InputError: If the text is no valid machine; the mistake says where.
    """
    try:
        data = _plain(text)
        if data.get("format") != FORMAT or data.get("version") != VERSION:
            raise InputError([Mistake("", f"this is not a {FORMAT} of version {VERSION}.")])
        return _MachineReader.of(data).system(data)
    except DAMAGED as error:
        raise InputError(_located(error, where)) from error


def feedback_to_tree(feedback: Feedback | Regulator) -> dict[str, Any]:
    """Return a controller as JSON-compatible data.

    Where a law is long, subexpressions that occur in it more than once are written once, below
    ``shared``.
    """
    if isinstance(feedback, Feedback):
        law = [expression for _, expression in feedback.law]
        if expanded_size(law) > ELEMENTS["terms"]:
            return _with_shared(feedback, law)
    tree: dict[str, Any] = _encode(feedback)
    return tree


def _with_shared(feedback: Feedback, law: Sequence[sympy.Expr]) -> dict[str, Any]:
    parts = parts_of(law)
    taken = {part.name for part in parts if isinstance(part, sympy.Symbol)}
    names = (name for name in (f"shared_{k}" for k in count(1)) if name not in taken)
    named: dict[sympy.Basic, str] = {}
    shared = []
    for part in (part for part, uses in parts.items() if uses > 1 and part.args):
        tree = {"expression": expression_to_tree(part, named)}
        named[part] = next(names)
        shared.append([named[part], tree])
    short = [
        [name, {"expression": expression_to_tree(expression, named)}]
        for name, expression in feedback.law
    ]
    encoded: dict[str, Any] = _encode(Feedback(feedback.references, ()))
    return encoded | {"law": short, "shared": shared}


def _json(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def feedback_from_tree(system: Mechanism, tree: Mapping[str, Any]) -> Feedback | Regulator:
    """Read a controller of a machine from plain data.

    Raises:
        InputError, LookupError, TypeError, ValueError: If it is malformed.
    """
    reader = _MachineReader.beside(system, tree)
    feedback = reader.controller(tree)
    reader.finish()
    if not isinstance(feedback, Feedback | Regulator):
        raise TypeError("it is no controller")
    return feedback


def files_of(system: Mechanism) -> dict[str, str]:
    """Return the texts that ``load_machine`` reads, by the files' names."""
    files = {MACHINE_FILE: machine_to_json(system.with_feedback(None))}
    if system.feedback is not None:
        files[FEEDBACK_FILE] = _json(feedback_to_tree(system.feedback))
    return files


def load_machine(path: Path) -> Mechanism:
    """Read a system from a file, with its controller from ``feedback.json`` in the same folder.

    Raises:
        InputError: If either file is unreadable or invalid.
    """
    system = machine_from_json(_text(path), where=str(path))
    beside = path.with_name(FEEDBACK_FILE)
    if not beside.is_file():
        return system
    try:
        return system.with_feedback(feedback_from_tree(system, _plain(_text(beside))))
    except DAMAGED as error:
        raise InputError(_located(error, beside)) from error


def _text(path: Path) -> str:
    """Read a regular text file within the size limit."""
    try:
        return read(path, "machine").decode("utf-8-sig")
    except UnicodeDecodeError as error:
        what, remedy = "this is not UTF-8 text.", "Save the file as UTF-8."
        raise InputError([Mistake(str(path), what, remedy)]) from error


def _plain(text: str) -> Any:
    """Parse JSON within the size limits."""
    data = json_of(text)
    mistakes = list(size_mistakes(data))
    if mistakes:
        raise InputError(mistakes[:20])
    return data


def _located(error: Exception, *where: object) -> list[Mistake]:
    """Return the mistakes about a value, with its location in the file."""
    place = " ".join(map(str, where))
    if isinstance(error, InputError):
        return [Mistake(f"{place} {m.where}".strip(), m.what, m.remedy) for m in error.mistakes]
    if isinstance(error, KeyError):
        return [Mistake(place, f"the key {error} is missing.")]
    return [Mistake(place, f"it is damaged ({type(error).__name__}: {error}).")]


def _described(system: Mechanism, body: Body) -> dict[str, Any]:
    facts = {name: _encode(getattr(body, name)) for name in BODY if name != "shapes"}
    facts["shapes"] = _encode(system.kept_shapes(body))
    facts |= {"whirl": body.whirl} if body.whirl else {}
    facts |= {} if body.located else {"located": False}
    facts |= {"prescribed": True} if body.prescribed else {}
    return facts | ({} if body.drawn is None else {"drawn": _encode(body.drawn)})


def _coordinate(coordinate: Coordinate | Attitude) -> dict[str, Any]:
    facts: dict[str, Any] = {
        "name": coordinate.name,
        "speed": _encode(coordinate.speed),
        "scale": coordinate.scale,
    }
    if isinstance(coordinate, Attitude):
        return facts | {"kind": "rotation"}
    limits = _encode((coordinate.lower, coordinate.upper))
    return facts | {"kind": KINDS[coordinate.unit].__name__, "limits": limits}


def _encode(value: Any) -> Any:
    """Encode a value as plain data: records by fields, expressions as trees."""
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, float | int):
        return value if math.isfinite(value) else None
    if isinstance(value, tuple):
        return [_encode(entry) for entry in value]
    if isinstance(value, Body):
        return {"body": value.name}
    if isinstance(value, Attitude):
        return {"attitude": value.name}
    if isinstance(value, sympy.Basic):
        return {"expression": expression_to_tree(value)}
    entries = {f.name: _encode(getattr(value, f.name)) for f in fields(value) if f.name != "_"}
    return {"is": type(value).__name__, **entries}


@dataclass
class _MachineReader:
    """The names of one machine file, and the mistakes found in it."""

    coordinates: dict[str, Coordinate | Attitude]
    symbols: dict[str, sympy.Symbol]
    bodies: dict[str, Body] = field(default_factory=dict)
    mistakes: list[Mistake] = field(default_factory=list)

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> _MachineReader:
        """Declare the symbols of a machine."""
        coordinates = {entry["name"]: _read_coordinate(entry) for entry in data["coordinates"]}
        if len(coordinates) < len(data["coordinates"]):
            raise ValueError("two coordinates have the same name")
        symbols: list[MachineSymbol] = [
            Parameter(p["name"], p["default"], p["unit"]) for p in data["parameters"]
        ]
        symbols += _symbols_of(coordinates.values())
        symbols += [InputSymbol(entry["name"]) for entry in data["inputs"]]
        symbols += [StateSymbol(entry["name"]) for entry in data["states"]]
        feedback = data.get("feedback") or {"references": ()}
        symbols += [ReferenceSymbol(entry["name"]) for entry in feedback["references"]]
        named = {symbol.name: symbol for symbol in symbols}
        modes = (mode["constraints"] for mode in data.get("modes", ()))
        constraints = (c for some in (data["constraints"], *modes) for c in some)
        forces = {c["name"]: ForceSymbol(c["name"]) for c in constraints}
        return cls(coordinates, forces | named)

    @classmethod
    def beside(cls, system: Mechanism, feedback: Mapping[str, Any]) -> _MachineReader:
        """Use an existing machine's symbols, to read a controller for it."""
        coordinates = {entry.name: entry for entry in system.coordinates}
        symbols: list[MachineSymbol] = [
            *system.parameters,
            *_symbols_of(coordinates.values()),
            *(entry.symbol for entry in system.inputs),
            *(entry.symbol for entry in system.states),
            *(entry.symbol for entry in quasi_velocities(system)),
            *(ReferenceSymbol(entry["name"]) for entry in feedback["references"]),
        ]
        return cls(coordinates, {symbol.name: symbol for symbol in symbols})

    def system(self, data: Mapping[str, Any]) -> Mechanism:
        """Return the machine."""
        bodies = [self._body(entry, k) for k, entry in enumerate(data["bodies"], start=1)]
        self.finish()  # no follow-up mistakes about what acts on an invalid body
        self.bodies.update({body.name: body for body in bodies})
        chosen = data["velocities"]
        velocities: Any = chosen
        if isinstance(chosen, list):  # early files have only names of coordinates
            velocities = [
                self.coordinates[entry]
                if isinstance(entry, str)
                else self.decode(entry, "velocities")
                for entry in chosen
            ]
        chosen_symbols = (v.symbol for v in velocities or () if isinstance(v, QuasiVelocity))
        self.symbols.update({symbol.name: symbol for symbol in chosen_symbols})
        content = {name: self.decode(data[name], name) for name in CONTENT}
        content |= {name: self.decode(data.get(name, []), name) for name in FURTHER}
        flat, feedback = self._flat(data.get("flat")), self.controller(data.get("feedback"))
        self.finish()
        return Mechanism(
            data["name"],
            bodies=bodies,
            collisions=[(a, b) for a, b in data["collisions"]],
            unwatched=[(a, b) for a, b in data.get("unwatched", [])],
            notes=[(printable(a), printable(b)) for a, b in data.get("notes", [])],
            expected=[printable(entry) for entry in data.get("expected", [])],
            velocities=velocities,
            coordinates=list(self.coordinates.values()),
            values=data["values"],
            keep=data.get("keep", []),
            flat=flat,
            feedback=feedback,
            **content,
        )

    def controller(self, tree: Mapping[str, Any] | None) -> Any:
        """Return a controller, or None; what it shares is read first."""
        if not tree or "shared" not in tree:
            return self.decode(tree, "feedback")
        sizes: dict[str, int] = {}
        for name, entry in tree["shared"]:
            if name in self.symbols:
                raise ValueError(f"{name!r} is shared, and the name of something else, too")
            sizes[name] = written_out(entry["expression"], sizes)
            if sizes[name] > ELEMENTS["terms written out"]:
                raise ValueError(f"{name!r} has too many terms where all is written out")
            self.symbols = {**self.symbols, name: self.decode(entry)}
        whole = sum(written_out(e["expression"], sizes) for _, e in tree["law"])
        if whole > ELEMENTS["terms written out"]:
            raise ValueError("the law has too many terms where all is written out")
        return self.decode({key: tree[key] for key in tree if key != "shared"}, "feedback")

    def _flat(self, data: Mapping[str, Any] | None) -> Any:
        """Return the flatness description; early files have none."""
        if data is None:
            return None
        outputs = [str(name) for name, _ in data.get("outputs", ())]
        named = {symbol.name: symbol for symbol in output_symbols(outputs)}
        reader = _MachineReader(self.coordinates, named | self.symbols, mistakes=self.mistakes)
        return reader.decode(data, "flat")

    def finish(self) -> None:
        """Raise if anything in the file was wrong.

        Raises:
            InputError: With every mistake.
        """
        if self.mistakes:
            raise InputError(self.mistakes[:20])

    def _body(self, data: Mapping[str, Any], number: int) -> Any:
        entries = {name: data[name] for name in BODY}
        entries |= {"whirl": data.get("whirl", 0.0), "drawn": data.get("drawn")}
        entries |= {"located": data.get("located", True)}
        entries |= {"prescribed": data.get("prescribed", False)}
        return self._made(lambda shapes, **of: Body(shape=shapes, **of), entries, "bodies", number)

    def decode(self, data: Any, *where: object) -> Any:
        """Decode plain data; None where invalid, with the mistake recorded."""
        if isinstance(data, list):
            return tuple(self.decode(entry, *where, k) for k, entry in enumerate(data, start=1))
        if not isinstance(data, dict):
            return data
        if "is" not in data:
            return self._noting(lambda: self._reference(data), *where)
        entries = {name: entry for name, entry in data.items() if name != "is"}
        return self._made(lambda **values: _record(data["is"], values), entries, *where)

    def _made(self, make: Callable[..., Any], entries: Mapping[str, Any], *where: object) -> Any:
        """Build an object from decoded entries; invalid entries are reported instead of it."""
        before = len(self.mistakes)
        values = {name: self.decode(entry, *where, name) for name, entry in entries.items()}
        return (
            self._noting(lambda: make(**values), *where) if len(self.mistakes) == before else None
        )

    def _noting(self, work: Callable[[], Any], *where: object) -> Any:
        try:
            return work()
        except DAMAGED as error:
            self.mistakes += _located(error, *where)

    def _reference(self, data: Mapping[str, Any]) -> Any:
        """Resolve an expression or a name."""
        match data:
            case {"expression": tree}:
                return tree_to_expression(tree, self.symbols)
            case {"body": name}:
                return _named("body", name, self.bodies)
            case {"attitude": name}:
                return _named("attitude", name, self.coordinates)
        raise ValueError(f"{str(data)[:60]} is no record")


def _named(kind: str, name: Any, known: Mapping[str, Any]) -> Any:
    if name not in known:
        raise UnknownNameError(kind, str(name), known=known)
    return known[name]


def _record(kind: Any, values: dict[str, Any]) -> Any:
    if kind == State.__name__:
        values["limits"] = _limits(values["limits"])
    if kind == QuasiVelocity.__name__ and values["speed"] is None:
        values["speed"] = math.inf
    return _named("record", kind, RECORDS)(**values)


def _symbols_of(coordinates: Iterable[Coordinate | Attitude]) -> Iterator[MachineSymbol]:
    """Yield the symbols of coordinates and of their rates."""
    for coordinate in coordinates:
        yield from (*coordinate.entries, *coordinate.rates)


def _read_coordinate(data: Mapping[str, Any]) -> Coordinate | Attitude:
    speed = math.inf if data["speed"] is None else data["speed"]
    if data["kind"] == "rotation":
        return rotation(data["name"], speed=speed, scale=data["scale"])
    declare = {declared.__name__: declared for declared in KINDS.values()}[data["kind"]]
    return declare(data["name"], *_limits(data["limits"]), speed=speed, scale=data["scale"])


def _limits(pair: Any) -> tuple[float, float]:
    """Return limits; missing ones are infinite."""
    lower, upper = pair
    if any(isinstance(limit, str) for limit in pair):
        raise ValueError(f"{pair} are no limits")
    return (-math.inf if lower is None else lower, math.inf if upper is None else upper)

"""A ``System`` as JSON and back: data in, data out, no code is run.

Expressions are typed trees, ``["mul", "m", ["pow", "R", 2]]``: a string is a symbol, a number a
number, a list an operation from a fixed table.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import sympy

from kinolab.dynamics.bodies import Body
from kinolab.dynamics.constraints import Constraint
from kinolab.dynamics.efforts import Force, Gravity, Input, Torque
from kinolab.dynamics.frames import Axis, Frame, Motion, Rotation, Translation
from kinolab.dynamics.shapes import SHAPES, Shape
from kinolab.dynamics.symbols import Coordinate, InputSymbol, Parameter, Rate
from kinolab.dynamics.system import System
from kinolab.errors import InputError, Mistake

FORMAT, VERSION = "kinolab machine", 1

FUNCTIONS: dict[str, type] = {
    function.__name__: function
    for function in (
        sympy.sin,
        sympy.cos,
        sympy.tan,
        sympy.exp,
        sympy.log,
        sympy.tanh,
        sympy.atan,
        sympy.Abs,
    )
}
OPERATIONS: dict[str, type] = {"add": sympy.Add, "mul": sympy.Mul, "pow": sympy.Pow}
SHAPE_NAMES: dict[str, type] = {shape.__name__: shape for shape in SHAPES}
EFFORTS: dict[str, type] = {"Torque": Torque, "Force": Force}
AXIS_OF: dict[type, str] = {Torque: "about", Force: "along"}
DEEPEST = 200  # nesting of an expression; Python's own stack ends at about five times that


def machine_to_json(system: System) -> str:
    """Return a system as JSON text."""
    return json.dumps(_machine(system), indent=1, ensure_ascii=False) + "\n"


def machine_from_json(text: str, *, where: str = "machine.json") -> System:
    """Read a system from JSON text.

    Raises:
        InputError: If the text is no machine; the mistake says where.
    """
    try:
        data = json.loads(text)
        if data.get("format") != FORMAT or data.get("version") != VERSION:
            what = f"this is not a {FORMAT} of version {VERSION}."
            raise InputError([Mistake(where, what)])
        return _read_machine(data)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
        what = f"the machine is damaged ({type(error).__name__}: {error})."
        raise InputError([Mistake(where, what)]) from error


def load_machine(path: Path) -> System:
    """Read a system from a file."""
    return machine_from_json(path.read_text(encoding="utf-8"), where=str(path))


def _machine(system: System) -> dict[str, Any]:
    velocities = system.velocities
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": system.name,
        "coordinates": [
            {
                "name": c.name,
                "topology": c.topology,
                "unit": c.unit,
                "limits": [_open(c.lower), _open(c.upper)],
                "speed": _open(c.speed),
                "scale": c.scale,
            }
            for c in system.coordinates
        ],
        "parameters": [
            {"name": p.name, "default": p.default, "unit": p.unit} for p in system.parameters
        ],
        "values": dict(system.values),
        "velocities": None if velocities is None else [c.name for c in velocities],
        "gravity": system.gravity
        and {
            "down": list(system.gravity.down),
            "strength": expression_to_tree(system.gravity.strength),
        },
        "bodies": [_body(body) for body in system.bodies],
        "constraints": [
            {"name": c.name, "velocity": expression_to_tree(c.velocity)} for c in system.constraints
        ],
        "inputs": [_input(entry) for entry in system.inputs],
    }


def _open(limit: float) -> float | None:
    """Write an absent limit as null, for JSON has no infinity."""
    return limit if abs(limit) < float("inf") else None


def _body(body: Body) -> dict[str, Any]:
    return {
        "name": body.name,
        "frame": _frame(body.frame),
        "mass": expression_to_tree(body.mass),
        "inertia": [expression_to_tree(moment) for moment in body.inertia],
        "shapes": [_shape(shape) for shape in body.shapes],
        "touches_ground": body.touches_ground,
        "color": body.color and list(body.color),
    }


def _frame(frame: Frame) -> list[list[Any]]:
    return [_motion(motion) for motion in frame.motions]


def _motion(motion: Motion) -> list[Any]:
    if isinstance(motion, Translation):
        return ["move", *(expression_to_tree(component) for component in motion.by)]
    return [f"rot_{motion.axis}", expression_to_tree(motion.angle)]


def _shape(shape: Shape) -> dict[str, Any]:
    def plain(value: Any) -> Any:
        if isinstance(value, tuple):
            return [plain(entry) for entry in value]
        return value if isinstance(value, str) else {"value": expression_to_tree(value)}

    fields = {name: plain(value) for name, value in vars(shape).items()}
    return {"shape": type(shape).__name__, **fields}


def _input(entry: Input) -> dict[str, Any]:
    axis: Axis = getattr(entry, AXIS_OF[type(entry)])
    return {
        "input": type(entry).__name__,
        "name": entry.name,
        "on": entry.on.name,
        "axis": {"frame": _frame(axis.frame), "name": axis.name},
        "reacts_on": entry.reacts_on and entry.reacts_on.name,
        "limit": list(entry.bounds),
    }


def expression_to_tree(expression: Any) -> Any:
    """Return an expression as nested lists of names and numbers."""
    expression = sympy.sympify(expression)
    if expression.is_Symbol:
        return expression.name
    if expression.is_Integer:
        return int(expression)
    if expression.is_Float:
        return float(expression)
    if expression.is_Rational:
        return ["ratio", int(expression.p), int(expression.q)]
    if expression in (sympy.pi, sympy.E):
        return [str(expression)]
    for table in (OPERATIONS, FUNCTIONS):
        for name, kind in table.items():
            if expression.func is kind:
                return [name, *(expression_to_tree(argument) for argument in expression.args)]
    what = f"{expression.func.__name__} cannot be written to a machine file."
    raise InputError([Mistake(str(expression), what)])


def tree_to_expression(tree: Any, symbols: Mapping[str, sympy.Symbol], depth: int = 0) -> Any:
    """Return the expression of a tree; unknown names and operations are ValueErrors."""
    if depth > DEEPEST:
        raise ValueError("an expression is nested too deeply")
    if isinstance(tree, bool) or tree is None:
        raise ValueError(f"{tree!r} is no expression")
    if isinstance(tree, int):
        return sympy.Integer(tree)
    if isinstance(tree, float):
        return sympy.Float(tree)
    if isinstance(tree, str):
        return symbols[tree]
    name, *rest = tree
    if name == "ratio":
        return sympy.Rational(int(rest[0]), int(rest[1]))
    if name in ("pi", "E"):
        return getattr(sympy, name)
    arguments = [tree_to_expression(entry, symbols, depth + 1) for entry in rest]
    kind = OPERATIONS.get(name) or FUNCTIONS.get(name)
    if kind is None:
        raise ValueError(f"unknown operation {name!r}")
    return kind(*arguments)


def _read_machine(data: Mapping[str, Any]) -> System:
    coordinates = [_read_coordinate(entry) for entry in data["coordinates"]]
    parameters = [Parameter(p["name"], p["default"], p["unit"]) for p in data["parameters"]]
    symbols: dict[str, sympy.Symbol] = {s.name: s for s in (*coordinates, *parameters)}
    symbols |= {f"{c.name}_dot": Rate(c) for c in coordinates}
    symbols |= {entry["name"]: InputSymbol(entry["name"]) for entry in data["inputs"]}

    def expression(tree: Any) -> Any:
        return tree_to_expression(tree, symbols)

    bodies = {entry["name"]: _read_body(entry, expression) for entry in data["bodies"]}
    gravity, velocities = data["gravity"], data["velocities"]
    return System(
        data["name"],
        bodies=list(bodies.values()),
        constraints=[Constraint(expression(c["velocity"]), c["name"]) for c in data["constraints"]],
        inputs=[_read_input(entry, bodies, expression) for entry in data["inputs"]],
        gravity=gravity and Gravity(_triple(gravity["down"]), expression(gravity["strength"])),
        velocities=None if velocities is None else [symbols[name] for name in velocities],
        coordinates=coordinates,
        values=data["values"],
    )


def _triple(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _read_coordinate(data: Mapping[str, Any]) -> Coordinate:
    lower, upper = data["limits"]
    infinity = float("inf")
    limits = (-infinity if lower is None else lower, infinity if upper is None else upper)
    speed = infinity if data["speed"] is None else data["speed"]
    return Coordinate(data["name"], data["topology"], data["unit"], limits, speed, data["scale"])


def _read_frame(data: Sequence[Sequence[Any]], expression: Callable[[Any], Any]) -> Frame:
    motions: list[Motion] = []
    for kind, *values in data:
        if kind == "move":
            x, y, z = (expression(value) for value in values)
            motions.append(Translation((x, y, z)))
        elif kind in ("rot_x", "rot_y", "rot_z"):
            motions.append(Rotation(kind[-1], expression(values[0])))
        else:
            raise ValueError(f"unknown motion {kind!r}")
    return Frame(tuple(motions))


def _read_body(data: Mapping[str, Any], expression: Callable[[Any], Any]) -> Body:
    x, y, z = (expression(moment) for moment in data["inertia"])
    color = data["color"]
    return Body(
        data["name"],
        _read_frame(data["frame"], expression),
        mass=expression(data["mass"]),
        inertia=(x, y, z),
        shape=tuple(_read_shape(shape, expression) for shape in data["shapes"]),
        touches_ground=bool(data["touches_ground"]),
        color=color and _triple(color),
    )


def _read_shape(data: Mapping[str, Any], expression: Callable[[Any], Any]) -> Shape:
    def value(entry: Any) -> Any:
        if isinstance(entry, list):
            return tuple(value(item) for item in entry)
        return entry if isinstance(entry, str) else expression(entry["value"])

    fields = {name: value(entry) for name, entry in data.items() if name != "shape"}
    shape: Shape = SHAPE_NAMES[data["shape"]](**fields)
    return shape


def _read_input(
    data: Mapping[str, Any], bodies: Mapping[str, Body], expression: Callable[[Any], Any]
) -> Input:
    kind = EFFORTS[data["input"]]
    axis = Axis(_read_frame(data["axis"]["frame"], expression), data["axis"]["name"])
    lower, upper = data["limit"]
    made: Input = kind(
        data["name"],
        on=bodies[data["on"]],
        reacts_on=bodies[data["reacts_on"]] if data["reacts_on"] else None,
        limit=(float(lower), float(upper)),
        **{AXIS_OF[kind]: axis},
    )
    return made

"""Every word of the vocabulary, given what it does not take, says which argument is wrong."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import pytest
import sympy as sp

import kinolab.systems
from kinolab import dynamics as kd
from kinolab.errors import InputError

X, TH, R = kd.length("x"), kd.angle("th"), kd.rotation("R")
FRAME = kd.move(X, 0, 0) @ kd.rot_z(TH)
BODY = kd.Body("b", FRAME, mass=1, inertia=1)
SYSTEM = kd.System("s", bodies=[BODY], inputs=[kd.Force("f", on=BODY, along=FRAME.x, limit=1.0)])
RUBBED = SYSTEM.changed(efforts=[kd.SlidingFriction((kd.rate(X), kd.rate(TH)), 1.0)])
MODEL = SYSTEM.model()
FIELDS = kd.vector_fields(SYSTEM)
FIELD = kd.VectorField((X, TH), (sp.cos(TH), 1))
ROPE = kd.closed(X, "rope")
HELD = kd.Control("u", limit=1.0)
SPEED = kd.Reference("v", limit=1.0)
TRIM = kd.Trim(MODEL.rest(), np.zeros(1))
EYE, EYES = np.eye(2), np.stack([np.eye(2)] * 3)
NUMBER, TEXT, TUPLE, NONE, LIST = WRONG = 3.5, "z q", ("z q",), None, ["z q"]
SWITCHING = SYSTEM.changed(modes=[kd.Mode("m")])
ABOUT = (("x", X),)  # of pairs
SAMPLE = dict.fromkeys(MODEL.state_names, 0.1)

VALID: dict[str, dict[str, Any]] = {
    "Attitude": {"name": "A", "speed": 1.0, "scale": 1.0, "serial": 1},
    "Axis": {"frame": FRAME, "name": "x"},
    "Body": {
        "name": "b",
        "frame": FRAME,
        "mass": 1,
        "inertia": 1,
        "added_mass": (1, 1, 1, 0, 0, 0),
        "shape": kd.Sphere(0.1),
        "touches_ground": True,
        "color": (0.0, 0.5, 1.0),
        "whirl": 1.0,
        "drawn": None,
        "located": True,
        "prescribed": False,
    },
    "BodyVelocity": dict.fromkeys(("x", "y", "z", "wx", "wy", "wz"), sp.Integer(1)),
    "Box": {"x": 1.0, "y": 1.0, "z": 1.0, "at": (0, 0, 0)},
    "Buoyancy": {"on": BODY, "lift": 1.0, "at": (0, 0, 0)},
    "Cable": {"between": (FRAME, kd.WORLD), "name": "c", "radius": 0.1, "collides": True},
    "Capsule": {"radius": 0.1, "length": 1.0, "axis": "z", "at": (0, 0, 0)},
    "Control": {"name": "u", "limit": 1.0, "unit": "N"},
    "Coordinate": {
        "name": "y",
        "topology": "line",
        "unit": "m",
        "limits": (0.0, 1.0),
        "speed": 1.0,
        "scale": 1.0,
    },
    "Coulomb": {"velocity": kd.rate(X), "strength": 1.0, "smoothing": 0.1},
    "Cylinder": {"radius": 0.1, "length": 1.0, "axis": "z", "at": (0, 0, 0)},
    "DecouplingFields": {
        "velocities": {"v": ()},
        "moved": {"v": ("x",)},
        "fields": FIELDS,
        "velocity_symbols": (X,),
        "damped": (),
        "together": False,
        "exhaustive": True,
    },
    "Disk": {"radius": 0.1, "thickness": 1.0, "axis": "z", "at": (0, 0, 0)},
    "DrawnMesh": {"points": "", "corners": "", "color": (1.0, 1.0, 1.0)},
    "Drive": {"name": "d", "on": X, "limit": 1.0},
    "Feedback": {"references": [SPEED], "law": {"f": SPEED.symbol}},
    "Filtration": {"growth": (1, 2), "dimension": 2, "complete": True, "margins": ()},
    "FlatOutputs": {"outputs": (("y1", X),), "determined": ((X, kd.output("y1")),)},
    "Force": {"name": "f", "on": BODY, "along": FRAME.x, "limit": 1.0, "reacts_on": None},
    "Frame": {"motions": FRAME.motions},
    "Gravity": {"down": (0.0, 0.0, -1.0), "strength": 9.81},
    "InvolutiveClosure": {
        "growth": (1,),
        "dimension": 1,
        "integrable": (),
        "combinations": (),
        "integrals": (),
        "redundant": (),
        "disguised": 0,
        "complete": True,
    },
    "LeastDissipation": {"rates": {"x_dot": 1.0}, "power": 1.0, "bound": 1.0},
    "LinearControllability": {"rank": 1, "dimension": 1, "directions": (), "modes": ()},
    "Load": {"magnitude": 1.0, "velocity": kd.rate(X)},
    "Model": {"system": SYSTEM},
    "Parameter": {"name": "p", "default": 1.0, "unit": "m"},
    "PlaneCurves": {"x": X, "y": X, "heading": TH, "steered": ()},
    "Mode": {
        "name": "m",
        "constraints": [kd.zero(kd.rate(X), "held")],
        "efforts": [],
        "requirements": [],
    },
    "Potential": {"energy": X**2},
    "Pull": {"name": "p", "between": (FRAME, kd.WORLD), "limit": 1.0},
    "QuasiVelocity": {
        "name": "v",
        "velocity": kd.rate(X),
        "unit": "m/s",
        "speed": 1.0,
        "scale": 1.0,
        "direction": "",
    },
    "Rate": {"name": "r", "on": X, "limit": 1.0},
    "Reference": {"name": "r", "limit": 1.0, "unit": "m"},
    "Regulator": {
        "references": [SPEED],
        "tracked": {X: 1.0},
        "about": {X: SPEED.symbol},
        "efforts": {"f": 1.0},
        "schedule": {"v": 1},
    },
    "Requirement": {"margin": X, "name": "r"},
    "SlidingFriction": {"slip": (kd.rate(X), kd.rate(TH)), "strength": 1.0, "smoothing": 0.1},
    "SmallTime": {"value": kd.SmallTime.LINEAR.value},
    "SmallTimeVerdict": {"outcome": kd.SmallTime.LINEAR, "degree": 1, "obstacle": None},
    "Rope": {"between": (FRAME, kd.WORLD), "stiffness": 1.0, "length": 1.0, "damping": 0.1},
    "Sphere": {"radius": 0.1, "at": (0, 0, 0)},
    "Spring": {"between": (FRAME, kd.WORLD), "stiffness": 1.0, "length": 1.0},
    "State": {
        "name": "s",
        "derivative": X,
        "limits": (0.0, 1.0),
        "unit": "A",
        "scale": 1.0,
        "velocity": kd.rate(X),
    },
    "System": {
        "name": "s",
        "bodies": [BODY],
        "constraints": [],
        "inputs": [],
        "efforts": [],
        "gravity": None,
        "states": [],
        "requirements": [],
        "collisions": [],
        "unwatched": [],
        "notes": [],
        "cables": [],
        "velocities": None,
        "coordinates": None,
        "values": None,
        "keep": (),
        "flat": None,
        "feedback": None,
        "modes": [],
        "transitions": [],
        "expected": [],
        "offers": [],
    },
    "Torque": {"name": "t", "on": BODY, "about": FRAME.z, "limit": 1.0, "reacts_on": None},
    "Trim": {"x": np.zeros(2), "u": np.zeros(1)},
    "VectorField": {"variables": (X,), "components": (1,)},
    "VectorFields": {name: getattr(FIELDS, name) for name in FIELDS.__dataclass_fields__},
    "Transition": {
        "name": "t",
        "source": "m",
        "target": "m",
        "until": X,
        "provided": kd.rate(X),
        "restitution": 0.5,
        "reset": {X: X},
    },
    "Viscous": {"velocity": kd.rate(X), "coefficient": 1.0},
    "StateFunctions": {"model": MODEL, "expressions": [X]},
    "Wrench": {
        "on": BODY,
        "force": (0, 0, 0),
        "torque": (0, 0, 0),
        "at": (0, 0, 0),
        "reacts_on": None,
    },
    "acceleration": {"coordinate": X},
    "allowed_motions": {"system": SYSTEM},
    "angle": {"name": "a", "lower": -1.0, "upper": 1.0, "speed": 1.0, "scale": 1.0},
    "clock": {"name": "t", "lower": 0.0, "upper": 9.0, "speed": 1.0, "scale": 1.0},
    "closed": {"position": X, "name": "c"},
    "decoupling_fields": {"system": SYSTEM},
    "dlqr": {"A": EYE, "B": EYE, "Q": EYE, "R": EYE},
    "filtration": {
        "fields": FIELDS,
        "at": SAMPLE,
        "strong": True,
        "exact": False,
        "tolerance": 1e-9,
        "work": 1000,
    },
    "flatness_of": {"system": SYSTEM},
    "force_of": {"constraint": ROPE},
    "growth_vector": {"fields": FIELDS, "at": SAMPLE, "exact": False, "tolerance": 1e-9},
    "hat": {"twist": (0, 0, 0, 0, 0, 0)},
    "homogeneous": {"frame": FRAME},
    "involutive_closure": {"system": SYSTEM},
    "in_mode": {"system": SWITCHING, "mode": "m"},
    "lag": {"name": "l", "signal": HELD.symbol, "time_constant": 0.1, "unit": "N"},
    "least_dissipation": {"system": RUBBED, "given": {"x_dot": 1.0}, "at": {"th": 0.1}},
    "length": {"name": "l", "lower": -1.0, "upper": 1.0, "speed": 1.0, "scale": 1.0},
    "lie_bracket": {"f": FIELD, "g": FIELD},
    "linear_controllability": {
        "model": MODEL,
        "x": MODEL.rest(),
        "u": (0.0,),
        "without": (),
        "tolerance": 1e-9,
    },
    "lqr": {"A": EYE, "B": EYE, "Q": EYE, "R": EYE},
    "move": {"x": 1.0, "y": 0.0, "z": 0.0},
    "orient": {"attitude": R},
    "output": {"name": "y", "order": 1},
    "parameter": {"name": "p", "default": 1.0, "unit": "m"},
    "rate": {"coordinate": X},
    "require": {"margin": X, "name": "r"},
    "rot_x": {"angle": TH},
    "rot_y": {"angle": TH},
    "rot_z": {"angle": TH},
    "direction": {"name": "d", "speed": 1.0, "scale": 1.0},
    "rotation": {"name": "R", "speed": 1.0, "scale": 1.0},
    "small_time_controllability": {
        "fields": FIELDS,
        "at": SAMPLE,
        "held": {"f": 0.0},
        "limits": {"f": (-1.0, 1.0)},
        "exact": False,
        "tolerance": 1e-9,
        "work": 1000,
    },
    "squared_turn": {"attitude": R, "rest": (0, 0, 0, 1)},
    "state": {"name": "s"},
    "toward": {"direction": "-z", "strength": 9.81},
    "trim": {"model": MODEL, "steady": [X], "fixed": [(X, 0.0)], "start": TRIM},
    "turn_rate": {"attitude": R},
    "tvlqr": {"A": EYES, "B": EYES, "Q": EYE, "R": EYE, "final": EYE},
    "unhat": {"matrix": sp.zeros(4, 4)},
    "vector_fields": {"system": SYSTEM},
    "velocity": {"frame": FRAME},
    "zero": {"velocity": kd.rate(X), "name": "z"},
}
NOT_CALLED = {"CURVATURE", "WORLD", "Constraint", "Shape"}  # things, and names of several types

# What may be left out by None.
OPTIONAL = {
    "shape",
    "added_mass",
    "color",
    "velocity",
    "at",
    "held",
    "limits",
    "start",
    "provided",
    "restitution",
}


def kind(value: Any) -> str:
    """Say which of the five wrong values a value is like."""
    if value is None:
        return "none"
    if isinstance(value, str):
        return "text"
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return "number" if is_number else type(value).__name__


def cases() -> Iterator[tuple[str, str]]:
    for name, arguments in VALID.items():
        yield from ((name, argument) for argument in arguments)


def call(name: str, /, **changes: Any) -> Any:
    function: Callable[..., Any] = getattr(kd, name)
    given = VALID[name] | changes
    parameters = [] if name == "SmallTime" else inspect.signature(function).parameters.values()
    first = [p.name for p in parameters if p.kind is not p.KEYWORD_ONLY]
    return function(*(given[key] for key in first), **rest(given, first))


def rest(given: Mapping[str, Any], first: list[str]) -> dict[str, Any]:
    return {key: value for key, value in given.items() if key not in first}


def test_the_table_speaks_of_every_word_and_every_argument() -> None:
    assert set(VALID) == set(kd.__all__) - NOT_CALLED
    for name, arguments in VALID.items():
        if name != "SmallTime":
            parameters = inspect.signature(getattr(kd, name)).parameters
            assert list(arguments) == list(parameters), name


@pytest.mark.parametrize("name", sorted(set(VALID) - {"SmallTime"}))
def test_what_is_right_is_taken(name: str) -> None:
    call(name)


@pytest.mark.parametrize(("name", "argument"), list(cases()))
def test_a_wrong_argument_is_named_together_with_its_function(name: str, argument: str) -> None:
    """Whatever it is given, a word takes it or says which argument of which word is wrong."""
    for wrong in WRONG:
        try:
            call(name, **{argument: wrong})
        except InputError as error:
            said = str(error)
            if takes(name, argument, wrong):
                continue  # it is of the right type; what is wrong is told where it matters
            assert name.lower() in said.lower(), said
            assert argument in said, said
            assert "Give" in said, said
        else:
            assert takes(name, argument, wrong), f"{wrong!r} was taken"


def takes(name: str, argument: str, value: Any) -> bool:
    """Whether a value has a type that the documentation allows."""
    if kind(value) == kind(VALID[name][argument]) and kind(value) in ("none", "text", "number"):
        return True
    if value is None:
        return argument in OPTIONAL
    return (name, argument, kind(value)) in ALSO


ALSO = {  # what an argument takes besides what the table gives it
    ("DecouplingFields", "damped", "tuple"),
    *(("InvolutiveClosure", a, "tuple") for a in ("integrable", "combinations", "redundant")),
    ("LinearControllability", "directions", "tuple"),
    ("SmallTimeVerdict", "obstacle", "tuple"),
    ("System", "expected", "tuple"),  # of remarks; examine says which are in vain
    ("System", "expected", "list"),
    ("System", "velocities", "text"),  # "all"
    *(("System", key, kind) for key in ("keep", "expected") for kind in ("tuple", "list")),
    *(("linear_controllability", "without", kind) for kind in ("tuple", "list")),
    *(
        (name, "velocity", "number")
        for name in ("Coulomb", "QuasiVelocity", "State", "Viscous", "zero")
    ),
    *((name, "angle", "number") for name in ("rot_x", "rot_y", "rot_z")),
    ("Potential", "energy", "number"),
    ("Rate", "on", "number"),
    ("Requirement", "margin", "number"),
    ("State", "derivative", "number"),
    ("Transition", "provided", "number"),
    ("Transition", "until", "number"),
    ("closed", "position", "number"),
    ("lag", "signal", "number"),
    ("require", "margin", "number"),
}


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (
            lambda: kd.force_of("rope"),  # type: ignore[arg-type]
            "force_of constraint: it is 'rope'. "
            "Give a constraint of zero(…) or a constraint of closed(…).",
        ),
        (
            lambda: kd.Torque("steer", on=BODY, about="z", limit=1.0),  # type: ignore[arg-type]
            "Torque 'steer' about: it is 'z'. Give an axis of a frame, such as fork.z.",
        ),
        (
            lambda: kd.Torque("steer", on="arm", about=FRAME.z, limit=1.0),  # type: ignore[arg-type]
            "Torque 'steer' on: it is 'arm'. Give a Body.",
        ),
        (
            lambda: kd.Body("arm", (0, 0, 1), mass=1),  # type: ignore[arg-type]
            "Body 'arm' frame: it is (0, 0, 1). Give a frame, such as move(x, y) @ rot_z(psi).",
        ),
        (
            lambda: kd.System("s", bodies=[BODY, "arm"]),  # type: ignore[list-item]
            "System 's' bodies entry 2: it is 'arm'. Give a Body.",
        ),
        (lambda: kd.hat((0, 0, 1)), "hat twist: it has 3 numbers. Give six."),
        (lambda: kd.unhat(sp.zeros(3, 3)), "unhat matrix: it is 3x3. Give a 4x4 matrix."),
        (
            lambda: FRAME @ (0, 0, 1),  # type: ignore[operator]
            "Frame @: it is (0, 0, 1). Give a frame, such as move(x, y) @ rot_z(psi).",
        ),
        (
            lambda: (0, 0, 1) @ FRAME,
            "Frame @: it is (0, 0, 1). Give a frame, such as move(x, y) @ rot_z(psi).",
        ),
    ],
)
def test_messages_say_what_would_fit(made: Callable[[], Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        made()
    assert str(caught.value) == said


def test_all_wrong_arguments_are_told_at_once() -> None:
    with pytest.raises(InputError) as caught:
        kd.Torque("steer", on="arm", about="z", limit="strong")  # type: ignore[arg-type]
    assert len(caught.value.mistakes) == 3


@pytest.mark.parametrize(
    "value", [np.float64(1.5), np.int64(2), sp.pi / 3, sp.Rational(1, 3), sp.Float(0.5)]
)
def test_numbers_of_numpy_and_sympy_are_numbers(value: Any) -> None:
    assert kd.angle("a", -value, value).upper == float(value)
    assert kd.Control("u", limit=value).limit == value
    kd.move(value)


def test_machines_of_the_library_are_taken_as_they_are() -> None:
    assert all(kinolab.systems.get(name) for name in kinolab.systems.names())


@pytest.mark.parametrize(
    ("call", "meant"),
    [
        (
            lambda: kd.Body("b", kd.move(), masss=1.0),
            r"Body\(\) got .*'masss'. Did you mean 'mass'",
        ),
        (lambda: kd.length("x", lowr=0.0), r"length\(\) got .*'lowr'. Did you mean 'lower'"),
        (lambda: kd.length("x", qqq=0.0), r"length\(\) got an unexpected keyword argument 'qqq'.$"),
    ],
)
def test_an_unknown_argument_is_met_by_the_nearest_one(call: Any, meant: str) -> None:
    with pytest.raises(TypeError, match=meant):
        call()

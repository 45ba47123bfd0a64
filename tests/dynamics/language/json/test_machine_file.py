"""Machines as JSON: they come back bit for bit, and damage is an InputError and nothing else."""

import copy
import json
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import kinolab.systems
from kinolab.dynamics import (
    WORLD,
    Body,
    Coordinate,
    Cylinder,
    Feedback,
    Force,
    Model,
    Reference,
    System,
    length,
    move,
    parameter,
)
from kinolab.dynamics.lagrange.equations import equations_of
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.dynamics.language.json.machine_file import (
    load_machine,
    machine_from_json,
    machine_to_json,
)
from kinolab.errors import InputError
from tests.dynamics.machines import CONSTRAINED, compiled, compiled_random

MACHINES: dict[str, Any] = dict.fromkeys(CONSTRAINED, compiled)
MACHINES |= {str(seed): lambda name: compiled_random(int(name)) for seed in range(10)}
MACHINES |= {
    name: lambda n: kinolab.systems.get(n).model() for name in ("pendulum", "rolling_disk")
}


@pytest.mark.parametrize("name", MACHINES)
def test_a_machine_comes_back_with_the_same_bits(name: str) -> None:
    model = MACHINES[name](name)
    text = machine_to_json(model.system)
    back = machine_from_json(text)
    assert machine_to_json(back) == text
    again = Model(back)
    assert again.state_names == model.state_names
    assert again.control_names == model.control_names
    np.testing.assert_array_equal(again.control_bounds, model.control_bounds)
    np.testing.assert_array_equal(again.state_bounds, model.state_bounds)
    rng = np.random.default_rng(0)
    x, u = rng.uniform(-0.7, 0.7, (20, model.nx)), rng.uniform(-1, 1, (20, model.nu))
    assert again.f(x, u).tobytes() == model.f(x, u).tobytes()
    assert again.frames(x).tobytes() == model.frames(x).tobytes()


@pytest.mark.parametrize("name", ["0", "1", "pendulum", "rolling_disk"])
def test_a_machine_comes_back_with_the_same_bounds_on_its_speed(name: str) -> None:
    """A coin read from a file still spins about its axle without moving."""
    model = MACHINES[name](name)
    again = Model(machine_from_json(machine_to_json(model.system)))
    x = np.random.default_rng(0).uniform(-0.7, 0.7, (20, model.nx))
    assert again.point_speed(x).tobytes() == model.point_speed(x).tobytes()


def test_facts_and_parameter_values_come_back() -> None:
    x = length("x", -1.0, speed=2.0, scale=0.5)
    m = parameter("m", 2.0, "kg")
    solid = Cylinder(0.1, m / 10, "x", (0.0, 0.2, 0.0))
    look = {"touches_ground": True, "color": (0.1, 0.2, 1.0), "whirl": 7.0}
    body = Body("b", move(x), mass=m, shape=solid, **look)
    push = Force("F", on=body, along=WORLD.x, limit=(-1, 3))
    system = System("s", bodies=[body], inputs=[push], values={"m": 5.0}, velocities=[x])
    back = machine_from_json(machine_to_json(system))
    c = back.coordinates[0]
    assert isinstance(c, Coordinate)
    assert (c.name, c.lower, c.upper, c.speed, c.scale) == ("x", -1.0, float("inf"), 2.0, 0.5)
    assert back.parameter_values == {"m": 5.0}
    assert back.parameters == (m,)
    (made,) = back.bodies
    assert {name: getattr(made, name) for name in look} == look
    assert made.mass == m
    (shape,) = made.shapes
    assert isinstance(shape, Cylinder)
    assert (float(shape.radius), shape.length, shape.axis) == (0.1, m / 10, "x")
    assert [float(a) for a in shape.at] == [0.0, 0.2, 0.0]
    assert bounds_of(back.inputs[0]) == (-1.0, 3.0)
    assert back.velocities == (c,)


# Damage


@cache
def text_of(name: str) -> str:
    return machine_to_json(
        kinolab.systems.get(name, m=1.5) if name != "cart" else CONSTRAINED["cart"]()
    )


def paths(data: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    found = [at]
    if not isinstance(data, dict | list):
        return found
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        found += paths(value, (*at, key))
    return found


def replaced(data: Any, path: tuple[Any, ...], value: Any) -> Any:
    if not path:
        return value
    made = copy.copy(data)
    made[path[0]] = replaced(data[path[0]], path[1:], value)
    return made


def removed(data: Any, path: tuple[Any, ...]) -> Any:
    made = copy.deepcopy(data)
    at = made
    for key in path[:-1]:
        at = at[key]
    del at[path[-1]]
    return made


def read(data: Any) -> System | None:
    """Read a machine; damage that is noticed is an InputError, which counts as well."""
    try:
        return machine_from_json(data if isinstance(data, str) else json.dumps(data))
    except InputError as error:
        assert error.mistakes  # noqa: PT017
        return None


OPERATIONS = ("add", "mul", "ratio", "sin", "log", "pi", "E", "pow", "sign", "eval")
junk = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-3, 3)
    | st.sampled_from([10**30, 10**400, 0.5, -1.0, 1e308, float("nan"), float("inf")])
    | st.sampled_from(
        ["", "x", "theta", "m", "add", "mul", "Frame", "Rotation", "ratio", "sin", "Sphere", "bob"]
    ),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.tuples(st.sampled_from(OPERATIONS), st.lists(inner, max_size=3)).map(
            lambda pair: [pair[0], *pair[1]]
        )
        | st.dictionaries(
            st.sampled_from(["is", "expression", "body", "name", "radius", "motions", "down"]),
            inner,
            max_size=3,
        )
    ),
    max_leaves=6,
)


@given(st.data(), st.sampled_from(["pendulum", "rolling_disk"]))
@settings(max_examples=250, deadline=None, suppress_health_check=list(HealthCheck))
def test_a_damaged_entry_is_an_input_error_or_harmless(data: Any, name: str) -> None:
    machine = json.loads(text_of(name))
    path = data.draw(st.sampled_from(paths(machine)))
    read(replaced(machine, path, data.draw(junk)))


@pytest.mark.parametrize("name", ["pendulum", "rolling_disk"])
def test_every_missing_entry_is_an_input_error_or_harmless(name: str) -> None:
    machine = json.loads(text_of(name))
    for path in paths(machine)[1:]:
        try:
            read(removed(machine, path))
        except Exception as error:
            pytest.fail(f"without {path}: {type(error).__name__}: {error}")


@given(st.integers(0, 4000), st.integers(0, 40), st.binary(max_size=6))
@settings(max_examples=150, deadline=None)
def test_truncated_and_overwritten_text_is_an_input_error_or_harmless(
    start: int, cut: int, patch: bytes
) -> None:
    text = text_of("pendulum")
    start %= len(text)
    read(text[:start])
    read(text[:start] + patch.decode("latin-1") + text[start + cut :])


def test_what_is_no_machine_is_refused_with_its_name() -> None:
    for text in ("[]", "3", "null", '"x"', "{}", '{"format": "kinolab machine", "version": 2}'):
        with pytest.raises(InputError, match=r"^my\.json: "):
            machine_from_json(text, where="my.json")
    with pytest.raises(InputError) as caught:
        machine_from_json("{}", where="my.json")
    assert str(caught.value) == "my.json: this is not a kinolab machine of version 1."


def pendulum() -> Any:
    return json.loads(text_of("pendulum"))


def with_bob(**changes: Any) -> Any:
    machine = pendulum()
    machine["bodies"][0].update(changes)
    return machine


HUGE = 10**400


def tree(value: Any) -> Any:
    """An expression as a machine file has it."""
    return {"expression": value}


def record(kind: str, **entries: Any) -> Any:
    return {"is": kind, **entries}


def moved(by: Any) -> Any:
    """The bob's frame, with another first offset."""
    turn = record("Rotation", axis="z", angle=tree("theta"))
    offset = record("Translation", by=[tree(by), tree(0), tree(0)])
    return record("Frame", motions=[turn, offset])


def turned(**turn: Any) -> Any:
    return record("Frame", motions=[record("Rotation", **turn)])


DISK = {"radius": 1.0, "thickness": 1.0, "at": [0.0, 0.0, 0.0]}
DAMAGED = {
    "a ratio of one number": with_bob(mass=tree(["ratio", 1])),
    "a ratio without numbers": with_bob(mass=tree(["ratio"])),
    "a ratio over zero": with_bob(mass=tree(["ratio", 1, 0])),
    "a turn without angle": with_bob(frame=turned(axis="x")),
    "a turn about no axis": with_bob(frame=turned(axis="w", angle=tree("theta"))),
    "a huge mass": with_bob(mass=tree(HUGE)),
    "a huge mass that is no expression": with_bob(mass=HUGE),
    "an infinite mass": with_bob(mass=tree(float("inf"))),
    "a mass that is no number": with_bob(mass=tree(float("nan"))),
    "a mass beyond floating point": with_bob(mass=tree(["pow", 2, 5000])),
    "an unknown function": with_bob(mass=tree(["eval", "m"])),
    "a mass that is a record": with_bob(mass=record("Sphere", radius=1.0)),
    "a mass that is a body": with_bob(mass={"body": "bob"}),
    "a reciprocal of zero in a frame": with_bob(frame=moved(["pow", 0, -1])),
    "an imaginary offset": with_bob(frame=moved(["pow", -1, ["ratio", 1, 2]])),
    "an offset that is no number": with_bob(frame=moved(float("nan"))),
    "an infinite offset": with_bob(frame=moved(float("inf"))),
    "a product beyond floating point": with_bob(mass=tree(["mul", 1e300, 1e300])),
    "an empty operation": with_bob(mass=tree([])),
    "an operation that is a list": with_bob(mass=tree([["add"], 1])),
    "an unknown record": with_bob(frame=record("Teapot")),
    "a record that is a list": with_bob(frame={"is": ["Frame"]}),
    "a frame that is a number": with_bob(frame=3),
    "a motion that is a number": with_bob(frame=record("Frame", motions=[3])),
    "a shape without dimension": with_bob(shapes=[record("Sphere")]),
    "a shape with an unknown dimension": with_bob(
        shapes=[record("Sphere", radius=1.0, colour=1.0)]
    ),
    "a shape with text for a radius": with_bob(shapes=[record("Sphere", radius="big")]),
    "a shape along no axis": with_bob(shapes=[record("Disk", axis="w", **DISK)]),
    "a shape that is a frame": with_bob(shapes=[turned(axis="x", angle=tree("theta"))]),
    "an axis that no frame has": replaced(pendulum(), ("inputs", 0, "about", "name"), "w"),
    "a huge limit": replaced(pendulum(), ("inputs", 0, "limit"), [-1, HUGE]),
    "an input on no body": replaced(pendulum(), ("inputs", 0, "on"), {"body": "nobody"}),
    "an input on a body that is text": replaced(pendulum(), ("inputs", 0, "on"), "bob"),
    "an input that is a potential": replaced(
        pendulum(), ("inputs", 0), record("Potential", energy=tree(1), name="torque")
    ),
    "a force that is an input": replaced(
        pendulum(), ("efforts",), [record("Control", name="c", limit=1.0, unit="")]
    ),
    "an unknown topology": replaced(pendulum(), ("coordinates", 0, "kind"), "banana"),
    "limits of text": replaced(pendulum(), ("coordinates", 0, "limits"), ["a", "b"]),
    "a huge speed": replaced(pendulum(), ("coordinates", 0, "speed"), HUGE),
    "a name that is a list": replaced(pendulum(), ("name",), ["pendulum"]),
    "gravity that is an empty table": replaced(pendulum(), ("gravity",), {}),
    "gravity that is false": replaced(pendulum(), ("gravity",), False),
    "gravity along no unit vector": replaced(pendulum(), ("gravity", "down"), [5, 0, 0]),
    "gravity that is no number": replaced(pendulum(), ("gravity", "down"), [float("nan"), 0, 0]),
    "a value that is text": replaced(pendulum(), ("values", "m"), "1.5"),
    "a value that is true": replaced(pendulum(), ("values", "m"), True),
    "values that are a list": replaced(pendulum(), ("values",), [1]),
    "velocities of another machine": replaced(pendulum(), ("velocities",), ["x"]),
    "velocities that are no choice": replaced(pendulum(), ("velocities",), "most"),
    "a body twice": replaced(pendulum(), ("bodies",), pendulum()["bodies"] * 2),
    "a coordinate twice": replaced(pendulum(), ("coordinates",), pendulum()["coordinates"] * 2),
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_this_damage_is_an_input_error(damage: str) -> None:
    """Noticed while reading, before anything is derived from it."""
    with pytest.raises(InputError):
        machine_from_json(json.dumps(DAMAGED[damage]))


def told(data: Any) -> str:
    with pytest.raises(InputError) as caught:
        machine_from_json(json.dumps(data))
    return str(caught.value)


MISFITS = {
    "Sphere radius: it is 'big'. Give a number": with_bob(shapes=[record("Sphere", radius="big")]),
    "Sphere radius: it is True. Give a number": with_bob(shapes=[record("Sphere", radius=True)]),
    "Disk at: it is (0.0, 0.0). Give a tuple": with_bob(
        shapes=[record("Disk", **DISK | {"axis": "z", "at": [0.0, 0.0]})]
    ),
    "Translation by: it is None. Give a tuple": with_bob(
        frame=record("Frame", motions=[record("Translation", by=None)])
    ),
    "Rotation angle: it is 'x'. Give an expression": with_bob(frame=turned(axis="x", angle="x")),
    "Body 'bob' mass: it is 'heavy'. Give a": with_bob(mass="heavy"),
    "Torque 'torque' on: it is 'bob'. Give a Body": DAMAGED["an input on a body that is text"],
    "gravity: it is False.": DAMAGED["gravity that is false"],
    "VelocityConstraint 'v' velocity: it is None. Give an expression": replaced(
        pendulum(), ("constraints",), [record("VelocityConstraint", velocity=None, name="v")]
    ),
}


@pytest.mark.parametrize("words", MISFITS)
def test_what_does_not_fit_is_told_as_it_is_told_to_who_writes_python(words: str) -> None:
    """The vocabulary checks its own arguments; a file has no second opinion on them."""
    assert words in told(MISFITS[words])


def test_all_that_is_wrong_is_told_at_once_and_where_it_stands() -> None:
    ball, disk = record("Sphere", radius="big"), record("Disk", **DISK | {"axis": "z", "at": None})
    lines = told(with_bob(shapes=[ball, disk], mass=tree(["eval", "m"]))).splitlines()
    where = ["bodies 1 mass: ", "bodies 1 shapes 1 Sphere radius: ", "bodies 1 shapes 2 Disk at: "]
    assert len(lines) == len(where)
    assert all(line.startswith(f"machine.json {at}") for line, at in zip(lines, where, strict=True))


def test_a_missing_key_and_an_unknown_name_are_told_as_such() -> None:
    assert told(removed(pendulum(), ("bodies",))) == "machine.json: the key 'bodies' is missing."
    stray = told(DAMAGED["an input on no body"])
    assert stray.startswith("machine.json inputs 1 on: no body is called 'nobody'.")
    assert "Known: bob." in stray


def test_an_expression_that_is_nested_too_deeply_is_refused() -> None:
    nested: Any = "m"
    for _ in range(201):
        nested = ["sin", nested]
    with pytest.raises(InputError, match="nested too deeply"):
        machine_from_json(json.dumps(with_bob(mass=tree(nested))))
    with pytest.raises(InputError):
        machine_from_json("[" * 100_000)


def test_a_power_that_no_computer_can_hold_is_refused_at_once() -> None:
    """9^(9^9) has 370 million digits; reading twenty bytes must not compute them."""
    text = json.dumps(with_bob(mass=tree(["pow", 9, ["pow", 9, 9]])))
    code = (
        "import sys; from kinolab.dynamics.language.json.machine_file import machine_from_json\n"
        "from kinolab.errors import InputError\n"
        "try: machine_from_json(sys.stdin.read())\n"
        "except InputError: print('refused')"
    )
    try:
        done = subprocess.run(
            [sys.executable, "-c", code],
            input=text,
            capture_output=True,
            text=True,
            timeout=120,  # it takes hours; a busy computer takes 6 s to start
            check=False,
        )
    except subprocess.TimeoutExpired:
        pytest.fail("it was still computing after two minutes")
    assert done.stdout == "refused\n"


def test_a_file_that_is_no_text_is_an_input_error(tmp_path: Path) -> None:
    path = tmp_path / "machine.json"
    path.write_bytes(b"\xff\xfe\x00{")
    with pytest.raises(InputError):
        load_machine(path)


def test_a_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "machine.json"
    path.write_text(text_of("pendulum"), encoding="utf-8")
    assert load_machine(path).name == "pendulum"


# Code

RUNS = "__import__('pathlib').Path({!r}).touch()"
BOB = ("bodies", 0)
PLACES: dict[str, tuple[Any, ...]] = {
    "the value of a parameter": ("values", "m"),
    "the default of a parameter": ("parameters", 0, "default"),
    "a mass": (*BOB, "mass"),
    "the expression of a mass": (*BOB, "mass", "expression"),
    "a moment of inertia": (*BOB, "inertia", 1),
    "the expression of a moment": (*BOB, "inertia", 1, "expression"),
    "the kind of a motion": (*BOB, "frame", "motions", 0, "is"),
    "an angle": (*BOB, "frame", "motions", 0, "angle"),
    "an offset": (*BOB, "frame", "motions", 1, "by", 0),
    "the expression of an offset": (*BOB, "frame", "motions", 1, "by", 0, "expression"),
    "a radius": (*BOB, "shapes", 0, "radius"),
    "the place of a shape": (*BOB, "shapes", 0, "at", 0),
    "the strength of gravity": ("gravity", "strength"),
    "the expression of gravity": ("gravity", "strength", "expression"),
    "the direction of gravity": ("gravity", "down", 0),
    "a limit": ("inputs", 0, "limit"),
    "the scale of a coordinate": ("coordinates", 0, "scale"),
    "the limit of a coordinate": ("coordinates", 0, "limits", 0),
    "the name of a coordinate": ("coordinates", 0, "name"),
    "the name of an input": ("inputs", 0, "name"),
    "the name of a parameter": ("parameters", 0, "name"),
    "the name of a body": (*BOB, "name"),
    "the name of an axis": ("inputs", 0, "about", "name"),
}


@pytest.mark.parametrize("place", PLACES)
def test_no_code_in_a_machine_file_is_run(place: str, tmp_path: Path) -> None:
    """Neither while it is read, nor while it is derived, drawn or printed."""
    mark = tmp_path / "ran"
    code = RUNS.format(str(mark))
    machine = replaced(pendulum(), PLACES[place], code)
    if place == "the name of a body":
        machine["inputs"][0]["on"] = {"body": code}
    try:
        system = machine_from_json(json.dumps(machine))
        assert not mark.exists()
        for body in system.bodies:
            system.resolved_shapes(body)
        model = Model(system)
        model.point_speed([0.1, 0.2])
        equations_of(system).text()
    except Exception:
        assert not mark.exists(), "code from the file was run"
    assert not mark.exists(), "code from the file was run"


def test_a_shape_of_text_is_not_evaluated(tmp_path: Path) -> None:
    mark = tmp_path / "ran"
    evil = RUNS.format(str(mark))
    shape = record("Cylinder", radius=evil, length=1.0, axis="z", at=[0.0, 0.0, 0.0])
    try:
        Model(machine_from_json(json.dumps(with_bob(shapes=[shape]))))
    except Exception:
        assert not mark.exists(), "code from the file was run"
    assert not mark.exists(), "code from the file was run"


def test_a_machine_that_can_be_written_can_be_read() -> None:
    """An input on a body that is not the system's must be noticed at the latest here."""
    x = length("x")
    body, stranger = Body("b", move(x), mass=1), Body("o", move(x), mass=1)
    push = Force("F", on=stranger, along=WORLD.x, limit=1)
    try:
        text = machine_to_json(System("s", bodies=[body], inputs=[push]))
    except InputError:
        return
    machine_from_json(text)


def shared(*entries: tuple[str, Any]) -> dict[str, Any]:
    """Return a machine with feedback in which names stand for expressions."""
    system = kinolab.systems.get("unicycle")
    data = json.loads(machine_to_json(system.with_feedback(lawful(system))))
    law = data["feedback"]["law"]
    law[0] = [law[0][0], {"expression": entries[-1][0]}]
    data["feedback"]["shared"] = [[name, {"expression": tree}] for name, tree in entries]
    return data


def lawful(system: Any) -> Feedback:
    """Return a law of a machine's own inputs, which does nothing."""
    point = Reference("aim", limit=1.0)
    return Feedback([point], [(entry.name, point.symbol) for entry in system.inputs])


def test_what_a_law_shares_is_put_in() -> None:
    read = machine_from_json(json.dumps(shared(("a", ["mul", 2, "aim"]), ("b", ["add", "a", "a"]))))
    assert isinstance(read.feedback, Feedback)
    assert read.feedback.law[0][1] == 4 * read.feedback.references[0].symbol


@pytest.mark.parametrize(
    ("entries", "text"),
    [
        ([("aim", ["mul", 2, "aim"])], "the name of something else"),
        ([("a", ["add", "b", 1]), ("b", 1)], "unknown symbol 'b'"),
        (
            [
                ("s0", "aim"),
                *((f"s{k}", ["add", ["sin", f"s{k - 1}"], f"s{k - 1}"]) for k in range(1, 60)),
            ],
            "too many terms where all is written out",
        ),
    ],
)
def test_what_a_law_cannot_share_is_refused_at_once(entries: Any, text: str) -> None:
    with pytest.raises(InputError, match=text):
        machine_from_json(json.dumps(shared(*entries)))

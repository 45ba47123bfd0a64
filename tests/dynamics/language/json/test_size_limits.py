"""Machine files that are too large or no text are refused, in words, before anything is built."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

import kinolab
from kinolab.dynamics import Model
from kinolab.dynamics.lagrange import equations as equations_module
from kinolab.dynamics.lagrange.equations import equations_of
from kinolab.dynamics.language.json.machine_file import (
    FEEDBACK_FILE,
    load_machine,
    machine_from_json,
    machine_to_json,
)
from kinolab.dynamics.language.json.size_limits import size_mistakes
from kinolab.dynamics.language.shapes.packed_rows import packed
from kinolab.errors import InputError
from kinolab.untrusted import BYTES
from tests.support import within


def document() -> dict[str, Any]:
    read: dict[str, Any] = json.loads(machine_to_json(kinolab.systems.get("pendulum")))
    return read


def with_potential(tree: Any) -> dict[str, Any]:
    data = document()
    data["efforts"] = [*data["efforts"], {"is": "Potential", "energy": {"expression": tree}}]
    return data


def terms(count: int) -> Any:
    return ["add", *(["mul", k, ["sin", ["mul", k, "theta"]]] for k in range(1, count + 1))]


def nested(operation: Callable[[Any], Any], deep: int) -> Any:
    tree: Any = "theta"
    for _ in range(deep):
        tree = operation(tree)
    return tree


def powers(deep: int) -> Any:
    return nested(lambda tree: ["pow", ["add", tree, 1], 9], deep)


def sines(deep: int) -> Any:
    return nested(lambda tree: ["sin", ["add", tree, 1]], deep)


def bodies(count: int) -> dict[str, Any]:
    data = document()
    bob = data["bodies"][0]
    data["bodies"] = [bob, *({**bob, "name": f"bob {k}"} for k in range(1, count))]
    return data


def coordinates(count: int) -> dict[str, Any]:
    data = document()
    theta = data["coordinates"][0]
    data["coordinates"] += [{**theta, "name": f"theta_{k}"} for k in range(1, count)]
    return data


def path(corners: int, symbol: str = "theta") -> Any:
    """A sum of maxima of a symbol and 0, as a path of straight lines is written."""
    rows = np.column_stack([np.arange(corners), np.cos(np.arange(corners))])
    return ["add", 1, ["hinges", symbol, packed(rows, "<f8")]]


def prescribed(corners: int, entries: int = 6, **facts: Any) -> dict[str, Any]:
    """A pendulum beside a body that goes a path."""
    data = document()
    entry = {"expression": path(corners // entries)}
    motions = [
        {"is": "Translation", "by": [entry] * 3},
        *({"is": "Rotation", "axis": axis, "angle": entry} for axis in "zyx"),
    ]
    bob = data["bodies"][0]
    body = {**bob, "name": "cart", "frame": {"is": "Frame", "motions": motions}}
    body |= {"mass": {"expression": 0}, "prescribed": True}
    data["bodies"] = [bob, {**body, **facts}]
    return data


LARGE: dict[str, tuple[dict[str, Any], str]] = {
    "6 000 terms": (with_potential(terms(6_000)), "5000 are the most. Shorten it."),
    "a power of powers of powers": (with_potential(powers(5)), "more than 4 powers are nested"),
    "a tower of powers": (
        with_potential(nested(lambda tree: ["pow", ["add", tree, 1], tree], 5)),
        "more than 4 powers are nested",
    ),
    "a sine of sines of sines": (
        with_potential(sines(80)),
        "nested too deeply, more than 60",
    ),
    "1 000 bodies": (bodies(1_000), "machine.json bodies: these are 1000 bodies"),
    "a path of 51 corners in a potential": (with_potential(path(51)), "51 maxima; 50 are the most"),
    "a path of 60 corners of a body with mass": (
        prescribed(60, mass={"expression": "m"}),
        "60 maxima; 50 are the most",
    ),
    "paths of 10 000 corners": (prescribed(10_000), "more than 20000 values"),
    "65 coordinates": (coordinates(65), "coordinates: these are 65 coordinates, and a machine may"),
}


@pytest.mark.parametrize(("data", "said"), LARGE.values(), ids=LARGE)
def test_what_would_take_minutes_is_refused_in_words(data: dict[str, Any], said: str) -> None:
    text = json.dumps(data)
    with within(20), pytest.raises(InputError) as caught:
        equations_of(machine_from_json(text))
    assert said in str(caught.value)
    assert all(mistake.where.startswith("machine.json") for mistake in caught.value.mistakes)


@pytest.mark.parametrize("corners", [60, 2_400])
def test_a_path_of_many_corners_is_read_and_compiled(corners: int) -> None:
    """The obstacle is where NumPy's sum over the corners says."""
    text = json.dumps(prescribed(corners))
    with within(30):
        machine = machine_from_json(text)
        model = Model(machine)
    assert machine_to_json(machine_from_json(machine_to_json(machine))) == machine_to_json(machine)
    at = 0.3 * corners / 6
    x = np.zeros((1, model.nx))
    x[0, 0] = at
    k = np.arange(corners // 6)
    expected = 1 + np.sum(np.cos(k) * np.maximum(at - k, 0.0))
    found = model.frames(x).reshape(-1, 3, 4)[-1, :, 3]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("rows", ["AAAA", "?", packed([[0.0, np.nan]], "<f8"), 3, ["add", 1]])
def test_a_path_that_is_damaged_is_refused(rows: Any) -> None:
    tree = ["add", 1, ["hinges", "theta", rows]]
    with within(20), pytest.raises(InputError):
        machine_from_json(json.dumps(with_potential(tree)))


def test_all_that_is_too_large_is_said_at_once() -> None:
    data = {**with_potential(terms(5_000)), "bodies": bodies(300)["bodies"]}
    assert len(list(size_mistakes(data))) == 3  # bodies, values in all, one expression


@pytest.mark.parametrize("tree", [powers(3), powers(4), sines(8), sines(20)], ids=str)
def test_equations_of_what_is_allowed_are_derived_and_right(
    tree: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They used to be expanded to hundreds of powers, or searched for identities without end.

    Half a second is enough to see that the search ends, as it does after four by default.
    m l^2 theta'' + dV/dtheta = torque; the derivative is compared with a central difference.
    """
    monkeypatch.setattr(equations_module, "SIMPLIFICATION_SECONDS", 0.5)
    with within(60):
        (equation,) = equations_of(machine_from_json(json.dumps(with_potential(tree)))).balance
    side = equation.lhs
    values = dict.fromkeys(side.free_symbols, 0.0) | {
        symbol: 1.0 for symbol in side.free_symbols if symbol.name in {"m", "l"}
    }
    (theta,) = (symbol for symbol in side.free_symbols if symbol.name == "theta")
    at, step = -0.7, 1e-6  # where none of these powers is large

    def potential(angle: float) -> float:
        return float(_value(tree, angle))

    slope = (potential(at + step) - potential(at - step)) / (2 * step)
    assert float(side.subs(values | {theta: at})) == pytest.approx(slope, rel=1e-6, abs=1e-8)


def _value(tree: Any, theta: float) -> Any:
    match tree:
        case "theta":
            return theta
        case ["add", a, b]:
            return _value(a, theta) + _value(b, theta)
        case ["pow", a, b]:
            return _value(a, theta) ** b
        case ["sin", a]:
            return sympy.sin(_value(a, theta))
    return tree


@pytest.mark.parametrize("name", kinolab.systems.names())
def test_every_machine_of_ours_is_far_from_too_large(name: str) -> None:
    text = machine_to_json(kinolab.systems.get(name))
    assert len(text) < BYTES["machine"] / 8
    assert list(size_mistakes(json.loads(text))) == []
    assert machine_to_json(machine_from_json(text)) == text


PLACES: dict[str, Callable[[dict[str, Any]], Any]] = {
    "the name": lambda data: data.update(name="pend\ud800ulum"),
    "a body's name": lambda data: data["bodies"][0].update(name="b\udfffob"),
    "a unit": lambda data: data["parameters"][0].update(unit="\ud800"),
    "a coordinate's name": lambda data: data["coordinates"][0].update(name="th\ud834"),
    "a key": lambda data: data.update({"\udc00": 1}),
    "the format": lambda data: data.update(format="\ud800"),
}


@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
def test_half_a_character_is_refused_wherever_it_stands(place: Callable[[Any], Any]) -> None:
    data = document()
    place(data)
    with pytest.raises(InputError, match=r"this is no Unicode text. Write it in UTF-8."):
        Model(machine_from_json(json.dumps(data)))


def test_a_machine_of_ones_own_has_names_that_can_be_written() -> None:
    broken = kinolab.systems.get("pendulum")
    with pytest.raises(InputError, match="no Unicode text"):
        type(broken)("pend\udcff", bodies=list(broken.bodies), inputs=list(broken.inputs))


@pytest.mark.parametrize("added", ["\x1b[31m", "\nall checks passed", "\u202e", "\x9b", 400 * "n"])
@pytest.mark.parametrize("name", ["rolling_disk", "coin", "no sideslip", "the rim grips"])
def test_a_name_that_could_steer_a_terminal_or_fill_it_is_refused(name: str, added: str) -> None:
    text = kinolab.systems.get("rolling_disk").model().files["machine.json"]
    changed = text.replace(f'"{name}"', json.dumps(name + added))
    with pytest.raises(InputError) as caught:
        Model(machine_from_json(changed))
    assert "this name has " in str(caught.value)
    assert added not in str(caught.value)


@pytest.mark.parametrize("name", ["machine.json", FEEDBACK_FILE])
def test_what_is_no_text_or_no_file_is_refused(name: str, tmp_path: Path) -> None:
    machine, file = tmp_path / "machine.json", tmp_path / name
    machine.write_text(json.dumps(document()))
    file.write_bytes(b'{"name": "\xff"}')
    with pytest.raises(InputError, match=f"{name}: this is not UTF-8 text. Save the file as UTF-8"):
        load_machine(machine)
    file.write_bytes(b" " * (BYTES["machine"] + 1))
    with pytest.raises(InputError, match=r"it cannot be read: it is larger than 2 MB\."):
        load_machine(machine)


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "machine.json")
    with within(20), pytest.raises(InputError, match="it is not an ordinary file"):
        load_machine(tmp_path / "machine.json")

"""Cables as part of a machine's description: names, files, mistakes, and how fast they move."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from kinolab.dynamics import (
    Body,
    Cable,
    System,
    angle,
    length,
    move,
    parameter,
    rot_x,
    rot_y,
    toward,
)
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import InputError

X, L, A, B = length("x"), length("l"), angle("a"), angle("b")
TOP = move(X, 0, 4)
LOAD = TOP @ rot_x(A) @ rot_y(B) @ move(0, 0, -L)
BODY, TROLLEY = Body("load", LOAD, mass=1.0), Body("trolley", TOP, mass=2.0)


def crane(*cables: Any, **parts: Any) -> System:
    return System("crane", bodies=[BODY, TROLLEY], gravity=toward("-z"), cables=cables, **parts)


def test_a_pair_of_frames_is_a_thin_rope_that_collides() -> None:
    (cable,) = crane((TOP, LOAD)).cables
    assert cable == Cable(between=(TOP, LOAD), name="cable", radius=0.01, collides=True)


def test_cables_without_a_name_are_numbered() -> None:
    named = Cable((LOAD, TOP), "guy")
    names = [cable.name for cable in crane((TOP, LOAD), named, [LOAD, TOP]).cables]
    assert names == ["cable 1", "guy", "cable 3"]
    again = crane((TOP, LOAD), named, [LOAD, TOP]).with_parameters()
    assert [cable.name for cable in again.cables] == names


def test_cables_come_back_from_a_file() -> None:
    r = parameter("r", 0.02, "m")
    thick = Cable((TOP, LOAD), "hose", radius=2 * r)
    drawn = Cable((TOP, LOAD), "line", collides=False)
    system = crane(thick, drawn, collisions=[("load", "hose")])
    text = machine_to_json(system)
    back = machine_from_json(text)
    assert machine_to_json(back) == text
    assert [(c.name, c.radius, c.collides) for c in back.cables] == [
        ("hose", 2 * r, True),
        ("line", 0.01, False),
    ]
    assert back.number(back.cables[0].radius) == pytest.approx(0.04)
    assert back.collisions == (("load", "hose"),)


def test_a_file_with_pairs_of_frames_is_still_read() -> None:
    """Before cables had names and radii, a file held the frames alone."""
    system = crane((TOP, LOAD))
    data = json.loads(machine_to_json(system))
    data["cables"] = [cable["between"] for cable in data["cables"]]
    assert set(data["cables"][0][0]) == {"is", "motions"}
    back = machine_from_json(json.dumps(data))
    assert machine_to_json(back) == machine_to_json(system)


@pytest.mark.parametrize("damage", [None, 1, "ab", ["ab"], [[]], [[1, 2]], [{"is": "Cable"}]])
def test_damaged_cables_in_a_file_are_refused(damage: object) -> None:
    data = json.loads(machine_to_json(crane((TOP, LOAD))))
    data["cables"] = damage
    with pytest.raises(InputError):
        machine_from_json(json.dumps(data))


def mistakes_of(*cables: Any, **parts: Any) -> list[str]:
    with pytest.raises(InputError) as caught:
        crane(*cables, **parts)
    return [str(mistake) for mistake in caught.value.mistakes]


def test_what_is_wrong_with_a_cable_is_told() -> None:
    rope = Cable((TOP, LOAD), "rope")
    assert mistakes_of(Cable((TOP, LOAD), "rope", radius=0.0)) == [
        "cable 'rope': its radius is 0 m. "
        "It must be positive; collides=False is for cables that are only drawn."
    ]
    assert mistakes_of(Cable((TOP, LOAD), "rope", radius=X)) == [
        "cable 'rope': its radius is x. Give a number, or an expression of parameters."
    ]
    assert mistakes_of(rope, rope) == [
        "cable 'rope': 2 have this name. Give each a name of its own."
    ]
    assert mistakes_of(Cable((TOP, LOAD), "load")) == [
        "cable 'load': 2 have this name. Give each a name of its own."
    ]
    with pytest.raises(InputError, match=r"'rope' between: .* Give a tuple of 2, each a frame"):
        Cable((TOP, BODY), "rope")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"'rope' between: it has 3 ends\. Give a pair"):
        Cable([TOP, LOAD, TOP], "rope")


def test_pairs_that_cannot_collide_are_refused() -> None:
    rope, drawn = Cable((TOP, LOAD), "rope"), Cable((TOP, LOAD), "line", collides=False)
    assert mistakes_of(rope, drawn, collisions=[("load", "rop"), ("load", "line")]) == [
        "system 'crane' collisions: no body or cable that collides is called 'rop'. "
        "Did you mean 'rope'? Known: load, trolley, rope.",
        "system 'crane' collisions: no body or cable that collides is called 'line'. "
        "Known: load, trolley, rope.",
    ]


def test_no_point_of_a_cable_is_faster_than_the_bound() -> None:
    """Points are followed by finite differences of both ends, and the bound is attained."""
    model = crane((TOP, LOAD), (LOAD, move(0, 1, 0))).model()
    rng, h = np.random.default_rng(0), 1e-6
    for _ in range(20):
        x = rng.uniform(-1, 1, model.nx) + np.array([0, 2.0, 0, 0, 0, 0, 0, 0])
        rates = model.f(x)
        later, before = model.cables(x + h * rates), model.cables(x - h * rates)
        speeds = (later - before) / (2 * h)  # of the ends, (cables, 2, 3)
        share = np.linspace(0, 1, 21)[:, None, None]
        points = np.linalg.norm((1 - share) * speeds[:, 0] + share * speeds[:, 1], axis=-1)
        bound = model.cable_speed(x)
        assert (points <= bound + 1e-6).all()  # [m/s]; rounding of 1e-16 m in 1e-6 s, and h^2
        np.testing.assert_allclose(points.max(axis=0), bound, atol=1e-6)


def test_ends_that_do_not_move_have_no_speed() -> None:
    model = crane((move(1, 0, 0), move(0, 1, 0)), (TOP, move(0, 0, 0))).model()
    x = np.zeros(model.nx)
    x[model.state_names.index("x_dot")] = -3.0
    np.testing.assert_allclose(model.cable_speed(x), [0.0, 3.0])

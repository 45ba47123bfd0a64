"""A winch is an input of one class outside the package, and obeys the laws of all others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab.dynamics import Body, Rate, Sphere, System, length, move
from kinolab.errors import InputError
from tests.extension import laws
from tests.extension.winch import Winch

Array = NDArray[np.float64]

APART, HIGH = 4.0, 3.0  # [m], of the two winches

CARRY = """\
schema = 1
title = "Two winches carry a lamp"
[system]
file = "machine.py:lamp"
[start]
x = 1.0
z = 1.0
[goal]
x = 3.0
z = 1.5
tolerance = 0.1
[integration]
step = 0.1
[render]
size = [160, 120]
[planner]
improve = 0
name = "rrt"
time_limit = 60.0
"""


def lamp(mass: float = 0.0) -> System:
    """A lamp in a vertical plane, on the ropes of two winches below a ceiling."""
    x, z = length("x", 0.2, 3.8), length("z", 0.2, 2.5)
    body = Body("lamp", move(x, 0, z), mass=mass, shape=Sphere(0.1))
    winches = [
        Winch(name, between=(move(at, 0, HIGH), body.frame), limit=1.0)
        for name, at in (("left", 0.0), ("right", APART))
    ]
    return System("lamp", bodies=[body], inputs=winches)


def states(count: int = 6) -> Array:
    return np.random.default_rng(4).uniform((0.4, 0.4), (3.6, 2.3), (count, 2))


def ropes(x: Array) -> Array:
    """Lengths of both ropes by Pythagoras, shape (2,)."""
    return np.hypot([x[0], x[0] - APART], x[1] - HIGH)


def test_ropes_become_longer_at_the_speeds_that_are_given() -> None:
    """Where both lengths are known, so is the lamp: x = (a^2 - b^2 + w^2) / (2 w)."""
    model, u, h = lamp().model(), np.array([0.4, -0.3]), 0.5
    assert model.nx == 2
    for x in states():
        a, b = ropes(x) + h * u
        along = (a**2 - b**2 + APART**2) / (2 * APART)
        expected = along, HIGH - np.sqrt(a**2 - along**2)
        found = model.step(x, u, h, substeps=64)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_the_lamps_velocity_has_the_given_shares_along_the_ropes() -> None:
    model, u = lamp().model(), np.array([-0.7, 0.2])
    for x in states():
        path = np.array([[x[0], x[1] - HIGH], [x[0] - APART, x[1] - HIGH]])
        expected = np.linalg.solve(path / ropes(x)[:, None], u)
        np.testing.assert_allclose(model.f(x, u), expected, rtol=1e-12, atol=1e-14)


def test_a_winch_cannot_jerk_what_has_mass() -> None:
    """As any imposed velocity, where another direction is free."""
    hung = lamp(mass=1.0)
    with pytest.raises(InputError, match="input 'left': its steps would be blows to a machine"):
        hung.changed(inputs=hung.inputs[:1]).model()


def test_both_derivations_agree() -> None:
    laws.both_derivations_agree(lamp(), states())


def test_the_page_computes_it() -> None:
    laws.the_page_computes_it(lamp(), states(3))


def test_its_file_has_an_imposed_velocity_in_its_place() -> None:
    back = laws.its_file_tells_it_without_its_code(lamp(), states())
    assert [(type(entry), entry.name) for entry in back.inputs] == [(Rate, "left"), (Rate, "right")]


def test_a_plan_is_certified_and_shown(tmp_path: Path) -> None:
    source = "from tests.extension.test_winch import lamp\n"
    laws.a_plan_is_certified_and_shown(tmp_path, source, CARRY)

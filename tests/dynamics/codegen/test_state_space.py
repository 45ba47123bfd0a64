"""The laws of a state space, for every machine: what a difference is, and where it leads."""

from __future__ import annotations

import ctypes
import gc

import numpy as np
import pytest

from kinolab import systems
from kinolab.dynamics import Model
from kinolab.dynamics.codegen.state_space import wrapped

ROUNDING = 1e-14  # of numbers up to about 10

NAMES = systems.names()


@pytest.fixture(scope="module", params=NAMES)
def model(request: pytest.FixtureRequest) -> Model:
    return systems.get(request.param).model()


def states(model: Model, seed: int, count: int = 30) -> np.ndarray:
    """Draw states far apart: angles of several turns, attitudes of all kinds."""
    x = np.random.default_rng(seed).normal(scale=5.0, size=(count, model.nx))
    for first in model.attitudes.values():
        own = slice(first, first + 4)
        x[:, own] /= np.linalg.norm(x[:, own], axis=1, keepdims=True)
    return x


def other_names(model: Model, x: np.ndarray, seed: int) -> np.ndarray:
    """Return the same states, written with other quaternions and after other whole turns."""
    random = np.random.default_rng(seed)
    same = x.copy()
    for i in np.flatnonzero(model.circular):
        same[:, i] += 2 * np.pi * random.integers(-3, 4, len(x))
    for first in model.attitudes.values():
        same[:, first : first + 4] *= random.choice([-1.0, 1.0], (len(x), 1))
    return same


def rotations(q: np.ndarray) -> np.ndarray:
    """Return rotation matrices of quaternions x, y, z, w: a textbook's formula, even in q."""
    x, y, z, w = q.T
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_a_difference_leads_from_one_state_to_the_other(model: Model) -> None:
    space, x, y = model.space, states(model, 0), states(model, 1)
    reached = space.retract(x, space.difference(x, y))
    lines = np.setdiff1d(np.arange(model.nx), [*np.flatnonzero(model.circular)])
    lines = [i for i in lines if not any(f <= i < f + 4 for f in model.attitudes.values())]
    np.testing.assert_allclose(reached[:, lines], y[:, lines], atol=ROUNDING)
    for part in (np.sin, np.cos):
        circles = model.circular
        np.testing.assert_allclose(part(reached[:, circles]), part(y[:, circles]), atol=ROUNDING)
    for first in model.attitudes.values():
        own = slice(first, first + 4)
        np.testing.assert_allclose(rotations(reached[:, own]), rotations(y[:, own]), atol=ROUNDING)


def test_how_a_state_is_written_does_not_show(model: Model) -> None:
    space, x, y = model.space, states(model, 2), states(model, 3)
    same = other_names(model, y, 4)
    np.testing.assert_allclose(space.distance(y, same), 0.0, atol=ROUNDING)
    np.testing.assert_allclose(
        space.difference(x, same), space.difference(x, y), atol=10 * ROUNDING
    )
    np.testing.assert_allclose(space.nearest(x, same), space.nearest(x, y), atol=10 * ROUNDING)


def test_the_way_is_the_short_one(model: Model) -> None:
    """No circle asks for more than half a turn, no attitude for a chord longer than sqrt(2)."""
    difference = model.space.difference(states(model, 5), states(model, 6))
    assert (np.abs(difference[:, model.circular]) <= np.pi).all()
    for first in model.attitudes.values():
        chords = np.linalg.norm(difference[:, first : first + 4], axis=1)
        assert (chords <= np.sqrt(2.0) + ROUNDING).all()


def test_a_chord_is_twice_the_sine_of_a_quarter_of_the_turn(model: Model) -> None:
    """The angle between two attitudes from their rotation matrices: cos a = (tr R - 1) / 2."""
    x, y = states(model, 7), states(model, 8)
    difference = model.space.difference(x, y)
    for first in model.attitudes.values():
        own = slice(first, first + 4)
        between = np.einsum("jin,jkn->ikn", rotations(x[:, own]), rotations(y[:, own]))
        angle = np.arccos(np.clip((np.trace(between) - 1) / 2, -1, 1))
        chord = np.linalg.norm(difference[:, own], axis=1)
        # The arc cosine loses half of the digits near 0 and pi.
        np.testing.assert_allclose(chord, 2 * np.sin(angle / 4), atol=1e-7)


def test_the_straight_way_begins_and_ends_where_it_should(model: Model) -> None:
    space, (x, y) = model.space, states(model, 9, 2)
    way = space.interpolate(x, y, np.linspace(0.0, 1.0, 11))
    assert way.shape == (11, model.nx)
    assert space.distance(way[0], x) <= ROUNDING
    assert space.distance(way[-1], y) <= ROUNDING
    for first in model.attitudes.values():
        lengths = np.linalg.norm(way[:, first : first + 4], axis=1)
        np.testing.assert_allclose(lengths, 1.0, atol=ROUNDING)
    middle = space.interpolate(x, y, 0.5)
    assert space.distance(middle, x) == pytest.approx(space.distance(middle, y), abs=1e-13)


def test_states_in_a_row_do_not_jump(model: Model) -> None:
    space = model.space
    way = space.interpolate(*states(model, 10, 2), np.linspace(0.0, 1.0, 40))
    smooth = space.continuous(other_names(model, way, 11))
    jumps = np.abs(np.diff(smooth, axis=0)).max(axis=0)
    # A fortieth of what lies between; on the great circle of a quaternion it is faster midway.
    assert (jumps <= 0.06 * np.maximum(np.abs(way[-1] - way[0]), 1.0) + 1e-12).all()


def test_poses_change_as_finite_differences_say(model: Model) -> None:
    """Central differences of step 1e-5 err by 1e-10 of third derivatives, and rounding of 1e-10."""
    step = 1e-5
    for x in states(model, 12, 3):
        table = np.stack([x + step * e for e in (*np.eye(model.nx), *-np.eye(model.nx))])
        above, below = np.split(model.frames(table), 2)
        differences = np.moveaxis((above - below) / (2 * step), 0, -1)
        exact = model.frames_jacobian(x)
        scale = max(1.0, np.abs(exact).max(initial=0.0))
        np.testing.assert_allclose(exact, differences, atol=2e-8 * scale)


def test_a_whole_turn_is_no_difference_and_small_ones_are_exact() -> None:
    small = np.array([1e-17, -3e-13, 0.5, -3.0])
    assert (wrapped(small) == small).all()
    np.testing.assert_allclose(wrapped(small + 6 * np.pi), small, atol=1e-14)
    assert wrapped(np.pi) == -np.pi


def test_compiled_code_may_call_the_same_functions_by_address() -> None:
    model = systems.get("satellite").model()
    x, y = states(model, 13, 2)
    pointer = ctypes.c_void_p
    kind = ctypes.CFUNCTYPE(ctypes.c_int32, *(pointer,) * 4, ctypes.c_int64)
    turn, out = np.where(model.circular, 2 * np.pi, 0.0), np.empty(model.nx)
    function = kind(model.address("difference"))
    assert function(x.ctypes.data, y.ctypes.data, turn.ctypes.data, out.ctypes.data, 0) == 0
    assert (out == model.space.difference(x, y)).all()


def test_an_angle_that_limits_keep_on_a_line_does_not_come_round() -> None:
    model = systems.get("pendulum").model()
    line = model.space.limited(np.zeros(2, dtype=bool))
    x, y = np.array([-3.0, 0.0]), np.array([3.0, 0.0])
    assert line.difference(x, y)[0] == 6.0
    assert model.space.difference(x, y)[0] == pytest.approx(6.0 - 2 * np.pi, abs=ROUNDING)
    assert (line.nearest(x, y) == y).all()


def test_a_space_outlives_its_model() -> None:
    """Its functions are machine code that somebody must own."""
    space = systems.get("pendulum").model().space
    gc.collect()
    assert space.distance([0.0, 0.0], [1.0, 0.0]) == pytest.approx(1.0)
    line = space.limited(np.zeros(2, bool))
    del space
    gc.collect()
    assert line.distance([0.0, 0.0], [4.0, 0.0]) == pytest.approx(4.0)

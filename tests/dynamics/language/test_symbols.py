"""Coordinates and parameters: SymPy symbols that carry facts."""

import copy
import math
import pickle
import subprocess
import sys
from typing import Any

import pytest
import sympy as sp

import kinolab.systems
from kinolab.dynamics import Coordinate, angle, length, parameter, rate, rotation
from kinolab.dynamics.symbols.symbols import Acceleration, InputSymbol
from kinolab.errors import InputError


def test_two_coordinates_of_one_name_are_two() -> None:
    assert length("x") != length("x")
    assert sp.expand(length("x") - length("x")) != 0


def test_parameters_of_equal_facts_are_equal() -> None:
    assert parameter("m", 1.0, "kg") == parameter("m", 1, "kg")
    assert parameter("m", 1.0, "kg") != parameter("m", 2.0, "kg")
    assert parameter("m", 1.0, "kg") != parameter("m", 1.0, "g")
    assert parameter("m", 1.0, "kg") != sp.Symbol("m", real=True)


def test_rates_belong_to_their_coordinate() -> None:
    x, other = length("x"), length("x")
    assert rate(x) == rate(x) != rate(other)
    assert rate(x).name == "x_dot"
    assert rate(x).coordinate is x
    assert Acceleration(x) != rate(x)
    assert Acceleration(x).name == "x_ddot"


def test_symbols_of_one_attitude_can_be_sorted() -> None:
    """SymPy compares what symbols carry; equal ones come as two objects."""
    R, other = rotation("R"), rotation("R")
    for name in ("quaternion", "turn_rate"):
        for first, again, third in zip(*(getattr(a, name) for a in (R, R, other)), strict=True):
            assert first.compare(again) == 0
            assert first.compare(third) == -third.compare(first) != 0


def test_facts_are_kept() -> None:
    x = length("x", 0, 10, speed=1.5, scale=2)
    assert (x.topology, x.unit, x.lower, x.upper, x.speed, x.scale) == ("line", "m", 0, 10, 1.5, 2)
    th = angle("th")
    assert (th.topology, th.unit, th.lower, th.speed) == ("circle", "rad", -math.inf, math.inf)
    assert angle("th", lower=0).topology == "line"
    assert x.is_real
    assert sp.sqrt(x**2) == sp.Abs(x)


def symbols() -> list[Any]:
    x = length("x", -1, 1)
    return [x, rate(x), Acceleration(x), parameter("m", 2.5, "kg"), InputSymbol("u"), sp.sin(x) * 2]


@pytest.mark.parametrize("index", range(6))
@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_symbols_survive_pickling_equal(index: int, protocol: int) -> None:
    symbol = symbols()[index]
    back = pickle.loads(pickle.dumps(symbol, protocol))
    assert back == symbol
    assert hash(back) == hash(symbol)
    assert sp.expand(back - symbol) == 0
    assert type(back) is type(symbol)
    assert copy.deepcopy(symbol) == symbol


CHILD = """
import pickle, sys
import kinolab.systems
system, expression = pickle.load(sys.stdin.buffer)
f = system.model().f([0.1, -0.2, 0.5, 1.0, 0.8, 3.0], [0.3, 0.1])
kept = expression.subs(system.coordinates[0], 2)
sys.stdout.buffer.write(pickle.dumps((f, system, kept)))
"""


def test_a_system_travels_to_a_fresh_process_and_back() -> None:
    """What spawn does to a worker: another interpreter, another count of coordinates."""
    system = kinolab.systems.get("rolling_disk", R=0.3)
    expression = system.coordinates[0] ** 2 + rate(system.coordinates[1])
    done = subprocess.run(
        [sys.executable, "-c", CHILD],
        input=pickle.dumps((system, expression)),
        capture_output=True,
        check=True,
    )
    f, back, kept = pickle.loads(done.stdout)
    x, u = [0.1, -0.2, 0.5, 1.0, 0.8, 3.0], [0.3, 0.1]
    assert f.tobytes() == system.model().f(x, u).tobytes()
    assert back == system
    assert kept == 4 + rate(system.coordinates[1])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: length("x", 2, 1),
            "coordinate 'x': its limits are 2 to 1. The lower limit must be below the upper one.",
        ),
        (
            lambda: length("x", math.nan, 1),
            "coordinate 'x': its limits are nan to 1. The lower limit must be below the upper one.",
        ),
        (
            lambda: angle("a", speed=0),
            "coordinate 'a': its speed limit is 0. It must be positive.",
        ),
        (lambda: angle("a", scale=-1), "coordinate 'a': its scale is -1. It must be positive."),
        (
            lambda: length("1x"),
            "coordinate '1x': this is not a usable name. "
            "Use letters, digits and underscores, beginning with a letter.",
        ),
        (
            lambda: parameter("m 1", 2.0),
            "parameter 'm 1': this is not a usable name. "
            "Use letters, digits and underscores, beginning with a letter.",
        ),
        (lambda: parameter("m", math.nan), "parameter 'm': its value is nan."),
        (lambda: parameter("m", math.inf), "parameter 'm': its value is inf."),
    ],
)
def test_a_wrong_declaration_is_an_error(make: Any, message: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert str(caught.value) == message


def test_several_mistakes_of_a_coordinate_are_reported_together() -> None:
    with pytest.raises(InputError) as caught:
        length("x", 2, 1, speed=-1, scale=math.inf)
    assert len(caught.value.mistakes) == 3


def test_coordinates_know_the_order_in_which_they_were_made() -> None:
    first, second = length("b"), length("a")
    assert isinstance(first, Coordinate)
    assert first.serial < second.serial

"""Slips of those who know NumPy and SymPy are caught where they happen."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

from kinolab.dynamics import (
    Body,
    Feedback,
    Reference,
    Regulator,
    System,
    Transition,
    angle,
    length,
    move,
    rot_y,
    zero,
)
from kinolab.errors import InputError
from kinolab.loading import find_machine

q, x = angle("q"), length("x")
frame: Any = move(x, 0, 0) @ rot_y(q)
symbol: Any = q
speed = Reference("v", limit=1.0)
numpy: Any = np


@pytest.mark.parametrize(
    "slip",
    [
        lambda: frame * frame,
        lambda: 2 * frame,
        lambda: frame + frame,
        lambda: frame - move(1.0),
        lambda: np.eye(4) @ frame,
        lambda: np.eye(4) * frame,
    ],
)
def test_frames_are_multiplied_with_at(slip: Callable[[], Any]) -> None:
    with pytest.raises(InputError, match=r"Frame.*@"):
        slip()


@pytest.mark.parametrize(
    "slip",
    [
        lambda: math.cos(symbol),
        lambda: np.cos(symbol),
        lambda: math.sqrt(symbol),
        lambda: numpy.arctan2(symbol, 1.0),
        lambda: np.deg2rad(symbol),
        lambda: float(symbol),
    ],
)
def test_functions_of_symbols_are_sympys(slip: Callable[[], Any]) -> None:
    with pytest.raises(InputError, match=r"q: it is a symbol.*from sympy import cos"):
        slip()


@pytest.mark.parametrize(
    ("slip", "remedy"),
    [
        (lambda: q.diff("t"), "rate"),
        (lambda: sympy.diff(q, sympy.Symbol("t")), "rate"),
        (q.diff, "rate"),
        (lambda: symbol.dot, "rate"),
        (lambda: symbol.deriv, "rate"),
        (lambda: symbol.ddot, "acceleration"),
    ],
)
def test_derivatives_by_time_are_rates(slip: Callable[[], Any], remedy: str) -> None:
    with pytest.raises(InputError, match=rf"Write {remedy}\(q\) for its time derivative\."):
        slip()


def test_what_is_right_stays_so() -> None:
    """Attributes are looked for by many, and coordinates are differentiated by each other."""
    assert not hasattr(q, "dot")
    assert (q.diff(q), q.diff(x), sympy.diff(x * sympy.cos(q), q)) == (1, 0, -x * sympy.sin(q))
    assert np.float64(2.0) * q == 2.0 * q
    assert np.dot([1, 2], [q, x]) == q + 2 * x


@pytest.mark.parametrize(
    ("slip", "told"),
    [
        (
            lambda given: Regulator([speed], tracked={x: 1.0}, about={x: 0}, efforts=given),
            "each key a text or the symbol of an input or the symbol of a reference, each value",
        ),
        (lambda given: Regulator([speed], tracked=given, about={x: 0}), "each value a number"),
        (lambda given: Feedback([speed], law=given), "the symbol of an input"),
        (lambda given: Transition("a", "m", "m", until=x, reset=given), "each key a symbol"),
    ],
)
def test_a_tuple_of_numbers_is_no_table(slip: Callable[[Any], Any], told: str) -> None:
    with pytest.raises(InputError, match=r"it is \(1\.0, 1\.0\)\. Give a table {key: value") as is_:
        slip((1.0, 1.0))
    assert told in str(is_.value)


def test_a_table_is_no_list_and_its_entries_are_named() -> None:
    body = Body("b", frame, mass=1.0, inertia=1.0)
    bodies: Any = {"b": body}
    with pytest.raises(InputError, match=r"bodies: it is a dict\. Give a list, each entry a Body"):
        System("s", bodies=bodies)
    wrong: Any = {x: "1"}
    with pytest.raises(InputError, match=r"Regulator tracked entry x: it is '1'\. Give a number\."):
        Regulator([speed], tracked=wrong, about={x: 0})


MACHINE = """
import math
import numpy as np
from kinolab.dynamics import Body, System, angle, length, move, rate, rot_y, zero

def machine():
    q, x = angle("q"), length("x")
    body = Body("b", move(x, 0, LINE) @ rot_y(q), mass=1.0, inertia=1.0)
    return System("s", bodies=[body])
"""


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("math.cos(q)", "q on line 8: it is a symbol"),
        ("move(x) * move(q)", "Frame on line 8: frames"),
        ("math.cos(2 * q)", "on line 8 .*from sympy import cos"),
        ("np.sin(q + x)", "on line 8 .*from sympy import cos"),
        ("max(x, 0)", r"on line 8 .*sympy\.Max"),
        ("round(2 * q)", "on line 8 .*from sympy import cos"),
    ],
)
def test_in_a_file_the_line_is_named(line: str, told: str, tmp_path: Path) -> None:
    """Also where SymPy itself raises, of an expression."""
    (tmp_path / "own.py").write_text(MACHINE.replace("LINE", line))
    with pytest.raises(InputError, match=told):
        find_machine(f"{tmp_path}/own.py")


def test_a_constraint_without_rates_says_how_one_is_written() -> None:
    """SymPy takes the derivative of an expression by time for 0, and no one is asked."""
    body = Body("b", frame, mass=1.0, inertia=1.0)
    slip = zero((x - 0.1 * q).diff("t"), "rolling")
    with pytest.raises(InputError, match=r"no rate occurs in it\. .* rate\(x\)"):
        System("s", bodies=[body], constraints=[slip]).model()

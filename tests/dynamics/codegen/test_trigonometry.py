"""Sine and cosine as machine code, against many digits."""

import ctypes
from collections.abc import Callable

import mpmath
import numpy as np
import pytest

from kinolab.dynamics.codegen.emission import declarations, emit_function
from kinolab.dynamics.codegen.integrators import LANES
from kinolab.dynamics.codegen.llvm_jit import Library, compile_ir, link
from kinolab.dynamics.codegen.trigonometry import LARGEST, emit_sine_and_cosine
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from kinolab.numerics.arrays import Array

POINTER, LONG = ctypes.c_void_p, ctypes.c_int64
DIGITS = 400  # enough for angles of 1e300
RANDOM = np.random.default_rng(1)
ANGLES = {
    "one turn": RANDOM.uniform(-7, 7, 4000),
    "of every size": RANDOM.uniform(-1, 1, 4000) * 10 ** RANDOM.uniform(-15, 6, 4000),
    "around multiples of a quarter": np.arange(-1000, 1000) * np.pi / 4,
    "beyond what is reduced here": np.array([LARGEST, 1.1 * LARGEST, -1e9, 1e22, 1e300]),
}


@pytest.fixture(scope="module")
def library() -> Library:
    tape = ExpressionGraph()
    angle = tape.variable("angle")
    outputs = [tape.unary("sin", angle), tape.unary("cos", angle)]
    text = [*declarations(), emit_sine_and_cosine(1), emit_sine_and_cosine(LANES)]
    text += [
        emit_function(name, tape, {"x": (angle,)}, outputs, lanes=lanes)
        for name, lanes in (("alone", 1), ("in_lanes", LANES))
    ]
    return link(compile_ir("\n".join(text)), ["alone", "in_lanes"])


def function(library: Library, name: str) -> Callable[[Array, Array], int]:
    call = ctypes.CFUNCTYPE(ctypes.c_int32, POINTER, POINTER, LONG)(library.address(name))
    return lambda x, out: int(call(x.ctypes.data, out.ctypes.data, 0))


def alone(library: Library, angles: Array) -> Array:
    """Return sines and cosines (n, 2), one call each."""
    one, out = function(library, "alone"), np.empty((len(angles), 2))
    for angle, row in zip(angles, out, strict=True):
        assert one(np.array([angle]), row) == 0
    return out


@pytest.mark.parametrize("angles", ANGLES.values(), ids=ANGLES)
def test_both_are_right_to_two_units_in_the_last_place(library: Library, angles: Array) -> None:
    found = alone(library, angles)
    with mpmath.workdps(DIGITS):
        for angle, pair in zip(angles.tolist(), found.tolist(), strict=True):
            for value, exact in zip(pair, (mpmath.sin(angle), mpmath.cos(angle)), strict=True):
                assert abs(value - exact) <= 2 * np.spacing(abs(float(exact)))


@pytest.mark.parametrize("angles", ANGLES.values(), ids=ANGLES)
def test_lanes_say_the_same_bit_by_bit(library: Library, angles: Array) -> None:
    """Also where one lane is beyond what is reduced, and its neighbours are not."""
    mixed = np.concatenate([angles, np.resize([0.3, 1e9], -len(angles) % LANES)])
    RANDOM.shuffle(mixed)
    found, out, call = [], np.empty((2, LANES)), function(library, "in_lanes")
    for first in range(0, len(mixed), LANES):
        assert call(mixed[first : first + LANES].copy(), out) == 0
        found.append(out.T.copy())
    assert (np.concatenate(found) == alone(library, mixed)).all()


@pytest.mark.parametrize("angle", [np.nan, np.inf, -np.inf])
def test_what_has_no_sine_is_told(library: Library, angle: float) -> None:
    out = np.zeros(2)
    assert function(library, "alone")(np.array([angle]), out) != 0
    assert np.isnan(out).all()
    lanes = np.full((2, LANES), 9.0)
    angles = np.full(LANES, 0.5)
    angles[2] = angle
    assert function(library, "in_lanes")(angles, lanes) == 0b100
    assert lanes[0, 0] == pytest.approx(np.sin(0.5), abs=2e-16)

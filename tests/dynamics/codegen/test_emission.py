"""Nodes as machine code: every operation is what it is on the tape."""

import ctypes
import math
from typing import Any

import numpy as np
import pytest
import sympy as sp

from kinolab.dynamics import Body, Model, System, Wrench, length, move
from kinolab.dynamics.codegen.emission import emit_function
from kinolab.dynamics.codegen.integrators import LANES
from kinolab.dynamics.codegen.llvm import literal
from kinolab.dynamics.codegen.llvm_jit import compile_ir, link
from kinolab.dynamics.codegen.machine_code import STEP
from kinolab.dynamics.derivation.expression_graph import UNARY, ExpressionGraph
from kinolab.numerics.arrays import Array

POINTER, LONG = ctypes.c_void_p, ctypes.c_int64


@pytest.mark.parametrize("name", sorted(UNARY))
def test_every_function_is_compiled_to_itself(name: str) -> None:
    """Through a machine whose height is the function: frames give its value."""
    function = {"fabs": sp.Abs, "sqrt": sp.sqrt}.get(name) or getattr(sp, name)
    q = length("q", 0.2, 3.0)
    body = Body("b", move(q, 0, function(q)), mass=1)
    model = System("s", bodies=[body]).model()
    for value in (0.25, 0.9, 2.5):
        height = model.frames([value, 0.0])[0, 11]
        assert height == pytest.approx(UNARY[name](value), rel=4e-16)


@pytest.mark.parametrize("value", [0.1, -0.0, 1e-310, math.pi, -1e300])
def test_a_literal_is_exact(value: float) -> None:
    tape = ExpressionGraph()
    text = emit_function("g", tape, {"x": ()}, [tape.constant(value)])
    library = link(compile_ir(text), ["g"])
    out = np.empty(1)
    function = ctypes.CFUNCTYPE(ctypes.c_int32, POINTER, POINTER, LONG)(library.address("g"))
    assert function(out.ctypes.data, out.ctypes.data, 0) == 0
    assert out[0] == value
    assert literal(1.0) == "0x3FF0000000000000"


def test_a_maximum_is_compiled() -> None:
    tape = ExpressionGraph()
    a, b = tape.variable("a"), tape.variable("b")
    text = emit_function("g", tape, {"x": (a, b)}, [tape.maximum(a, b)])
    library = link(compile_ir(text), ["g"])
    function = ctypes.CFUNCTYPE(ctypes.c_int32, POINTER, POINTER, LONG)(library.address("g"))
    for pair in ((1.0, 2.0), (3.0, -4.0)):
        x, out = np.array(pair), np.empty(1)
        assert function(x.ctypes.data, out.ctypes.data, 0) == 0
        assert out[0] == max(pair)


VALUES = np.array([0.25, 0.9, 2.5, 0.01])  # one for each lane


@pytest.mark.parametrize("name", sorted(UNARY))
def test_every_function_is_the_same_in_every_lane(name: str) -> None:
    """Through a machine whose speed is the function of a coordinate."""
    function = {"fabs": sp.Abs, "sqrt": sp.sqrt}.get(name) or getattr(sp, name)
    model, h = _driven(function), 1e-3
    x = np.vstack([VALUES, np.zeros((3, LANES))])
    status, after = _in_lanes(model, "euler", x, h)
    assert status == 0
    expected = [UNARY[name](value) * h for value in VALUES.tolist()]
    assert after[3] == pytest.approx(expected, rel=1e-15, abs=0)


@pytest.mark.parametrize("method", ["euler", "rk4"])
def test_a_lane_that_fails_is_told_and_the_others_go_on(method: str) -> None:
    """The force is the logarithm of a coordinate: two of the lanes begin where there is none."""
    model, h = _driven(sp.log), 0.5
    begin = np.array([1.0, -1.0, 4.0, -0.5])
    status, after = _in_lanes(model, method, np.vstack([begin, np.zeros((3, LANES))]), h)
    assert status == 0b1010
    good = [0, 2]
    # the coordinate under the logarithm rests, so that the force is constant
    assert after[3, good] == pytest.approx(h * np.log(begin[good]), rel=1e-14, abs=0)
    assert not np.isfinite(after[3, 1::2]).any()


def _driven(function: Any) -> Model:
    """A mass of 1 kg that is pushed by a function of where another one rests."""
    q, y = length("q", -3.0, 3.0), length("y")
    still, pushed = Body("still", move(q, 0, 0), mass=1), Body("pushed", move(0, y, 0), mass=1)
    push = Wrench(on=pushed, force=(0, function(q), 0))
    return System("s", bodies=[still, pushed], efforts=[push]).model()


def _in_lanes(model: Model, method: str, x: Array, h: float) -> tuple[int, Array]:
    """Make a step without inputs from every column of x (nx, LANES)."""
    after, p, u = np.zeros_like(x), np.append(model.parameter_vector(), 0.0), np.zeros(1)
    step = STEP(model.in_lanes(method)[0])
    return step(x.ctypes.data, u.ctypes.data, p.ctypes.data, h, after.ctypes.data, 1, 0), after

"""Nodes as machine code: every operation is what it is on the tape."""

import ctypes
import math

import numpy as np
import pytest
import sympy as sp

from kinolab.dynamics import Body, System, length, move
from kinolab.dynamics.codegen.emission import emit_function
from kinolab.dynamics.codegen.llvm import literal
from kinolab.dynamics.codegen.llvm_jit import compile_ir, link
from kinolab.dynamics.derivation.expression_graph import UNARY, ExpressionGraph

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

"""Single-precision numbers in lanes that processors handle at once, for compiled code.

numba's compiler vectorises simple inner loops only, and what a loop adds up in an array goes
through memory. Values of the type below stay in registers across loops. Processors whose registers
are shorter take several per value.
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model
from numba.np.arrayobj import make_array

LANES = 16
NOTHING, FAR = np.float32(0.0), np.float32(np.inf)
BEFORE_ALL = -1  # a key below all others, from which ``next_key`` begins

FLOAT, INT, LONG, BIT = ir.FloatType(), ir.IntType(32), ir.IntType(64), ir.IntType(1)
FLOATS, INTS = ir.VectorType(FLOAT, LANES), ir.VectorType(INT, LANES)


class LanesType(types.Type):  # type: ignore[misc]
    """numba type of LANES single-precision numbers."""

    def __init__(self) -> None:
        super().__init__(name=f"float32x{LANES}")


LANES_TYPE = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, FLOATS)


def _define_operator(symbol: Any, instruction: str) -> None:
    """Let an operator between two values in lanes be an instruction."""

    @infer_global(symbol)
    class _Typing(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
            return signature(LANES_TYPE, *args) if args == (LANES_TYPE, LANES_TYPE) else None

    @lower_builtin(symbol, LANES_TYPE, LANES_TYPE)  # type: ignore[untyped-decorator]
    def _lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        return getattr(builder, instruction)(*args)


for _symbol, _instruction in (
    (operator.add, "fadd"),
    (operator.iadd, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
):
    _define_operator(_symbol, _instruction)


def _spread(builder: Any, value: Any, kind: Any) -> Any:
    """Return a vector whose entries are all the same value."""
    empty = ir.Constant(kind, ir.Undefined)
    one = builder.insert_element(empty, value, ir.Constant(INT, 0))
    return builder.shuffle_vector(one, empty, ir.Constant(INTS, [0] * LANES))


def _least(builder: Any, integers: Any) -> Any:
    """Return the least of integers in lanes."""
    kind = ir.FunctionType(INT, [INTS])
    name = f"llvm.vector.reduce.smin.v{LANES}i32"
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [integers])


def _address(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Return the address of the array entry that the first two arguments name."""
    array = make_array(sig.args[0])(context, builder, args[0])
    indices = cgutils.unpack_tuple(builder, args[1])
    entry = cgutils.get_item_pointer(context, builder, sig.args[0], array, indices)
    return builder.bitcast(entry, FLOATS.as_pointer())


@intrinsic  # type: ignore[untyped-decorator]
def load(typing: Any, array: Any, at: Any) -> Any:  # noqa: ARG001
    """Return LANES neighbours of a float32 array, the first of them at a tuple of indices."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = builder.load(_address(context, builder, sig, args))
        value.align = 4
        return value

    return LANES_TYPE(array, at), lower


@intrinsic  # type: ignore[untyped-decorator]
def store(typing: Any, array: Any, at: Any, value: Any) -> Any:  # noqa: ARG001
    """Write LANES neighbours of a float32 array, the first of them at a tuple of indices."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        builder.store(args[2], _address(context, builder, sig, args)).align = 4
        return context.get_dummy_value()

    return types.none(array, at, value), lower


@intrinsic  # type: ignore[untyped-decorator]
def spread(typing: Any, number: Any) -> Any:  # noqa: ARG001
    """Return a number in all lanes."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        return _spread(builder, args[0], FLOATS)

    return LANES_TYPE(types.float32), lower


def _choice(comparison: str) -> Any:
    """Return a function that takes from two values, lane by lane, the one that compares so.

    It takes the second if either is not a number.
    """

    @intrinsic  # type: ignore[untyped-decorator]
    def choose(typing: Any, one: Any, other: Any) -> Any:  # noqa: ARG001
        def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
            return builder.select(builder.fcmp_ordered(comparison, *args), *args)

        return LANES_TYPE(one, other), lower

    return choose


minimum, maximum = _choice("<"), _choice(">")


def _mask(comparison: str) -> Any:
    """Return a function that tells which lanes compare so with a number: a bit for each."""

    @intrinsic  # type: ignore[untyped-decorator]
    def compare(typing: Any, value: Any, number: Any) -> Any:  # noqa: ARG001
        def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
            mask = builder.fcmp_ordered(comparison, args[0], _spread(builder, args[1], FLOATS))
            return builder.zext(builder.bitcast(mask, ir.IntType(LANES)), LONG)

        return types.int64(LANES_TYPE, types.float32), lower

    return compare


lanes_below, lanes_up_to, lanes_at = _mask("<"), _mask("<="), _mask("==")


@intrinsic  # type: ignore[untyped-decorator]
def first_lane(typing: Any, mask: Any) -> Any:  # noqa: ARG001
    """Return the first lane whose bit is set, if any is."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        return builder.cttz(args[0], ir.Constant(BIT, 1))

    return types.int64(types.int64), lower


@intrinsic  # type: ignore[untyped-decorator]
def least(typing: Any, value: Any) -> Any:  # noqa: ARG001
    """Return the least of numbers of which none is negative: ordered like the integers they are."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        return builder.bitcast(_least(builder, builder.bitcast(args[0], INTS)), FLOAT)

    return types.float32(LANES_TYPE), lower


@intrinsic  # type: ignore[untyped-decorator]
def ranked(typing: Any, value: Any) -> Any:  # noqa: ARG001
    """Return numbers, none of them negative, whose last bits say their lanes, for ``next_key``."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        bits = builder.and_(builder.bitcast(args[0], INTS), ir.Constant(INTS, [-LANES] * LANES))
        bits = builder.or_(bits, ir.Constant(INTS, list(range(LANES))))
        return builder.bitcast(bits, FLOATS)

    return LANES_TYPE(LANES_TYPE), lower


@intrinsic  # type: ignore[untyped-decorator]
def next_key(typing: Any, value: Any, key: Any) -> Any:  # noqa: ARG001
    """Return the bits of the least of ``ranked`` numbers above a key, which ends with its lane.

    Keys are ordered like the numbers. The last one is followed by one that infinity is below.
    """

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        bits = builder.bitcast(args[0], INTS)
        above = builder.icmp_signed(">", bits, _spread(builder, builder.trunc(args[1], INT), INTS))
        rest = builder.select(above, bits, ir.Constant(INTS, [2**31 - 1] * LANES))
        return builder.sext(_least(builder, rest), LONG)

    return types.int64(LANES_TYPE, types.int64), lower


@intrinsic  # type: ignore[untyped-decorator]
def bits_of(typing: Any, number: Any) -> Any:  # noqa: ARG001
    """Return the bits of a number, to compare keys with."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        return builder.sext(builder.bitcast(args[0], INT), LONG)

    return types.int64(types.float32), lower

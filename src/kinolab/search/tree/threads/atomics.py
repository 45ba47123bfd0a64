"""Memory that several threads read and write at once, for compiled code."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

WORD = 8  # bytes of an entry
IN_ORDER = "seq_cst"  # all threads see all writes in one order


def _entry(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Return the address of the array entry that the first two arguments name."""
    array = make_array(sig.args[0])(context, builder, args[0])
    return cgutils.get_item_pointer(context, builder, sig.args[0], array, [args[1]])


@intrinsic  # type: ignore[untyped-decorator]
def atomic_load(typing: Any, array: Any, at: Any) -> Any:  # noqa: ARG001
    """Return an entry of an int64 array, and see what was written before it was."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load_atomic(_entry(context, builder, sig, args), IN_ORDER, WORD)

    return types.int64(array, types.int64), lower


@intrinsic  # type: ignore[untyped-decorator]
def atomic_store(typing: Any, array: Any, at: Any, value: Any) -> Any:  # noqa: ARG001
    """Write an entry of an int64 array, after all that was written before."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        builder.store_atomic(args[2], _entry(context, builder, sig, args), IN_ORDER, WORD)
        return context.get_dummy_value()

    return types.none(array, types.int64, types.int64), lower


@intrinsic  # type: ignore[untyped-decorator]
def atomic_add(typing: Any, array: Any, at: Any, value: Any) -> Any:  # noqa: ARG001
    """Add to an entry of an int64 array; return what it was."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.atomic_rmw("add", _entry(context, builder, sig, args), args[2], IN_ORDER)

    return types.int64(array, types.int64, types.int64), lower


@intrinsic  # type: ignore[untyped-decorator]
def compare_and_swap(typing: Any, array: Any, at: Any, was: Any, becomes: Any) -> Any:  # noqa: ARG001
    """Change an entry of an int64 array if it is what it was; say whether it was."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        where = _entry(context, builder, sig, args)
        swapped = builder.cmpxchg(where, args[2], args[3], IN_ORDER, IN_ORDER)
        return builder.extract_value(swapped, 1)

    return types.boolean(array, types.int64, types.int64, types.int64), lower


@intrinsic  # type: ignore[untyped-decorator]
def yield_processor(typing: Any) -> Any:  # noqa: ARG001
    """Let other threads run that wait for this processor, if any do."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
        kind = ir.FunctionType(ir.IntType(32), [])
        builder.call(cgutils.get_or_insert_function(builder.module, kind, "sched_yield"), [])
        return context.get_dummy_value()

    return types.none(), lower


@intrinsic  # type: ignore[untyped-decorator]
def record_at(typing: Any, address: Any, like: Any) -> Any:  # noqa: ARG001
    """Return the record at an address; it has the fields of another one."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], context.get_value_type(sig.return_type))

    return like(types.int64, like), lower

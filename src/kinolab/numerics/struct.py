"""Named tuples passed to compiled code by reference.

numba passes a tuple by value: hundreds of words per call where a tuple of tuples of arrays holds a
whole problem, and as many variables in every compiled function. A record is one address; a field is
read where it is accessed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from copy import copy
from ctypes import addressof, c_char
from functools import cache
from struct import Struct
from typing import Any

import numpy as np
from llvmlite import ir
from numba import from_dtype, types
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    models,
    register_model,
    unbox,
)
from numba.np import arrayobj
from numpy.typing import NDArray

WORD = 8  # bytes


class RecordType(types.Type):  # type: ignore[misc]
    """numba type of a record: the type of each field and its offset in words."""

    def __init__(self, kind: str, fields: tuple[tuple[str, Any, int], ...]) -> None:
        self.fields = {name: (held, offset) for name, held, offset in fields}
        what = hashlib.blake2b(repr(fields).encode(), digest_size=6).hexdigest()
        super().__init__(name=f"{kind}_{what}")


class Record:
    """A named tuple of arrays, numbers and nested tuples, for compiled code.

    Arrays are shared, not copied: changed entries are seen by compiled code.

    Args:
        held: The tuple. Its arrays must be contiguous; they are kept alive.
    """

    def __init__(self, held: Any) -> None:
        self.held = held
        shape: list[Any] = []
        words: list[float] = []
        _gather(held, shape, words)
        layout = _layouts.get(tuple(shape))
        if layout is None:
            layout = _layouts[tuple(shape)] = _layout(held)
        self._numba_type_, pack = layout  # numba's fastest way to find the type
        self._memory = np.frombuffer(pack(*words), np.uint64)
        self.address = address_of(self._memory)

    def of(self, held: Any) -> Record:
        """Return the record of a tuple that shares most of its arrays with this one, sooner.

        Args:
            held: The tuple; what it does not share has the same layout.
        """
        made = copy(self)
        made.held, made._memory = held, self._memory.copy()
        _change(made._memory, self._numba_type_, held, self.held, 0)
        made.address = address_of(made._memory)
        return made


def _change(memory: NDArray[np.uint64], kind: RecordType, held: Any, old: Any, first: int) -> None:
    """Write the words of what differs between two tuples of a kind, from an offset on."""
    for name, value, before in zip(held._fields, held, old, strict=True):
        if value is before:
            continue
        known, offset = kind.fields[name]
        at = first + offset
        if isinstance(value, tuple):
            _change(memory, known, value, before, at)
        elif isinstance(value, np.ndarray):
            memory[at : at + 1 + value.ndim] = address_of(value), *value.shape
        else:
            memory[at : at + 1].view(known.name)[0] = value


def _gather(held: Any, shape: list[Any], words: list[float]) -> None:
    """Append what tells the layout of a tuple, and its words."""
    shape.append(type(held))
    for value in held:
        if isinstance(value, np.ndarray):
            if not value.flags.c_contiguous:
                name = next(name for name in held._fields if getattr(held, name) is value)
                raise ValueError(f"{name} of {type(held).__name__} is not contiguous")
            shape += (value.dtype, value.ndim)
            words.append(address_of(value))
            words += value.shape
        elif isinstance(value, tuple):
            _gather(value, shape, words)
        else:
            number = _number(value)
            shape.append(number)
            words.append(number(value))


def address_of(array: NDArray[Any]) -> int:
    """Return where an array of any shape begins, four times as soon as its ``ctypes`` says."""
    if array.size and array.flags.writeable and array.flags.c_contiguous:
        return addressof(c_char.from_buffer(array))  # type: ignore[arg-type]  # NumPy knows no Buffer
    address: int = array.__array_interface__["data"][0]
    return address


# Of a tuple: the type of its record, and what makes words of its numbers.
_layouts: dict[tuple[Any, ...], tuple[RecordType, Callable[..., bytes]]] = {}


def _layout(held: Any) -> tuple[RecordType, Callable[..., bytes]]:
    codes: list[str] = []
    kind = _lay_out(held, codes)
    return kind, Struct("".join(["=", *codes])).pack


def _lay_out(held: Any, codes: list[str]) -> RecordType:
    """Append the codes of a tuple's words, as ``struct`` has them; return its record type."""
    fields: list[tuple[str, Any, int]] = []
    first = len(codes)
    for name, value in zip(held._fields, held, strict=True):
        begin = len(codes)
        if isinstance(value, np.ndarray):
            kind: Any = _array(value.dtype, value.ndim)
            codes += ["Q", *value.ndim * "q"]
        elif isinstance(value, tuple):
            kind = _lay_out(value, codes)
        else:
            kind = types.int64 if _number(value) is int else types.float64
            codes.append("q" if _number(value) is int else "d")
        fields.append((name, kind, begin - first))
    return _record_type(type(held).__name__, tuple(fields))


@cache
def _record_type(kind: str, fields: tuple[tuple[str, Any, int], ...]) -> RecordType:
    return RecordType(kind, fields)


@cache
def _array(dtype: Any, axes: int) -> Any:
    return types.Array(from_dtype(dtype), axes, "C")  # numba is slow to construct these


def _number(value: Any) -> type[int] | type[float]:
    return int if isinstance(value, bool | np.bool_ | int | np.integer) else float


register_model(RecordType)(models.OpaqueModel)


@unbox(RecordType)  # type: ignore[untyped-decorator]
def _unbox(_type: RecordType, value: Any, c: Any) -> NativeValue:
    address = c.pyapi.object_getattr_string(value, "address")
    pointer = c.pyapi.long_as_voidptr(address)
    c.pyapi.decref(address)
    return NativeValue(pointer)


@infer_getattr
class _Fields(AttributeTemplate):  # type: ignore[misc]
    key = RecordType

    def generic_resolve(self, record: RecordType, name: str) -> Any:
        return record.fields[name][0] if name in record.fields else None


@lower_getattr_generic(RecordType)  # type: ignore[untyped-decorator]
def _field(context: Any, builder: Any, record: RecordType, address: Any, name: str) -> Any:
    held, offset = record.fields[name]
    where = builder.gep(address, [ir.Constant(ir.IntType(64), WORD * offset)])
    if isinstance(held, RecordType):
        return where
    kind = context.get_value_type(held.dtype if isinstance(held, types.Array) else held)
    if not isinstance(held, types.Array):
        return _word(builder, where, kind)
    size = ir.Constant(ir.IntType(64), context.get_abi_sizeof(context.get_data_type(held.dtype)))
    data = _word(builder, where, context.get_data_type(held.dtype).as_pointer())
    shape = [_word(builder, where, ir.IntType(64), 1 + k) for k in range(held.ndim)]
    strides = [size]
    for length in shape[:0:-1]:
        strides.insert(0, builder.mul(strides[0], length))
    array = arrayobj.make_array(held)(context, builder)
    arrayobj.populate_array(
        array, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None
    )
    return array._getvalue()


def _word(builder: Any, where: Any, kind: Any, offset: int = 0) -> Any:
    """Load a word, which is invariant while compiled code runs."""
    place = builder.gep(where, [ir.Constant(ir.IntType(64), WORD * offset)])
    read = builder.load(builder.bitcast(place, kind.as_pointer()))
    read.set_metadata("invariant.load", builder.module.add_metadata([]))
    return read

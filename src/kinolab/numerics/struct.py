"""Named tuples passed to compiled code by reference.

numba passes a tuple by value: hundreds of words per call where a tuple of tuples of arrays holds a
whole problem, and as many variables in every compiled function. A record is one address; a field is
read where it is accessed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from copy import copy
from ctypes import addressof, c_char
from functools import cache
from struct import Struct
from typing import Any, TypeAlias

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
LINE = 64  # bytes of a processor's cache, which threads share or not

Own: TypeAlias = Mapping[
    str, "Own"
]  # names of what is copied of a tuple, of tuples in it all or some


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
            codes: list[str] = []
            kind = _lay_out(held, codes)
            layout = _layouts[tuple(shape)] = kind, Struct("".join(["=", *codes])).pack
        self._numba_type_, pack = layout  # numba's fastest way to find the type
        self._memory = np.frombuffer(pack(*words), np.uint64)
        self.address = address_of(self._memory)

    def apart(self, own: Own) -> Record:
        """Return a record of the same tuple, in which some arrays are copies.

        These share no cache line with anything else, so that threads can write to them without
        waiting for each other.

        Args:
            own: Names of the arrays; of a tuple in it all are copied, or those named for it.
        """
        made = copy(self)
        memory = np.empty(_room(self.held, own) + LINE, np.uint8)
        begin = address_of(memory)
        made._memory = self._memory.copy()
        copies = _Copies(memory, begin, -begin % LINE, made._memory)
        made.held = copies.of(self.held, self._numba_type_, own, 0)
        made.address = address_of(made._memory)
        return made


def _room(held: Any, own: Own) -> int:
    """Return how many bytes copies of some arrays of a tuple take, in whole cache lines."""
    room = 0
    for name in own or held._fields:
        value = getattr(held, name)
        if isinstance(value, tuple):
            room += _room(value, own.get(name, {}))
        elif isinstance(value, np.ndarray):
            room += -(-value.nbytes // LINE) * LINE
    return room


class _Copies:
    """Copies arrays of tuples, one after the other, and tells the words of a record where they are.

    Args:
        memory: For the copies (bytes,).
        at: Where in it the first copy begins.
    """

    def __init__(
        self, memory: NDArray[np.uint8], begin: int, at: int, words: NDArray[np.uint64]
    ) -> None:
        self._memory, self._begin, self._at, self._words = memory, begin, at, words

    def of(self, held: Any, kind: RecordType, own: Own, first: int) -> Any:
        """Return a tuple with copies.

        Args:
            own: Names of what is copied, all if there are none.
            first: Its first word.
        """
        changed: dict[str, Any] = {}
        for name in own or held._fields:
            value, (known, offset) = getattr(held, name), kind.fields[name]
            if isinstance(value, tuple):
                changed[name] = self.of(value, known, own.get(name, {}), first + offset)
            elif isinstance(value, np.ndarray):
                copied = np.ndarray(value.shape, value.dtype, self._memory, self._at)
                copied[...] = value
                changed[name] = copied
                self._words[first + offset] = self._begin + self._at
                self._at += -(-value.nbytes // LINE) * LINE
        return held._replace(**changed)


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

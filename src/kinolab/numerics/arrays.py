"""Array types of kinolab, float64 unless stated otherwise; allocation as declared; JSON numbers."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, TypeAlias, TypeVar, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Singles: TypeAlias = NDArray[np.float32]
Bytes: TypeAlias = NDArray[np.uint8]
T = TypeVar("T", bound=tuple[Any, ...])

# Products of five such numbers are doubles, which reach from 1e-308 to 1e308.
MULTIPLIABLE = (1e-60, 1e60)


def finite_or_none(value: float) -> float | None:
    """Return a number, or None where it is not finite: JSON has neither NaN nor infinity."""
    return value if math.isfinite(value) else None


def allocate(kind: type[T], sizes: dict[str, int], **given: Any) -> T:
    """Return a named tuple whose arrays are allocated.

    A field says its shape: ``Annotated[Array, "capacity", "nx"]``. Arrays with a capacity are left
    as memory is, since what they hold is written before it is read, and to clear it all would take
    milliseconds. All others are zero. A field that is a named tuple is allocated likewise.

    Args:
        kind: The tuple's class.
        sizes: Lengths of axes, by name.
        given: All fields that are not to be allocated.
    """
    for name, hint in _fields_of(kind).items():
        if name not in given and hasattr(hint, "_fields"):
            given[name] = allocate(hint, sizes)
        elif name not in given:
            array, *axes = get_args(hint)
            make = np.empty if any("capacity" in str(axis) for axis in axes) else np.zeros
            shape = [axis if isinstance(axis, int) else sizes[axis] for axis in axes]
            given[name] = make(shape, get_args(get_args(array)[1])[0])
    return kind(**given)


@cache
def _fields_of(kind: Any) -> dict[str, Any]:
    return get_type_hints(kind, include_extras=True)

"""Array types of kinolab, float64 unless stated otherwise; allocation as declared; JSON numbers."""

from __future__ import annotations

import math
from functools import cache, partial
from typing import Annotated, Any, TypeAlias, TypeVar, get_args, get_origin, get_type_hints

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
        sizes: Lengths of axes, by name.
        given: All fields that are not to be allocated.
    """
    for name, (make, axes) in _declared(kind).items():
        if name not in given:
            shape = [axis if isinstance(axis, int) else sizes[axis] for axis in axes]
            given[name] = make(shape) if axes else allocate(make, sizes)
    return kind(**given)


@cache
def _declared(kind: Any) -> dict[str, tuple[Any, tuple[str | int, ...]]]:
    """Return what makes each array, and its axes; without axes, the class of a tuple or a number.

    Types are looked through once: a search is made in milliseconds, and has hundreds of arrays.
    """
    found = {}
    for name, hint in get_type_hints(kind, include_extras=True).items():
        array, *axes = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        dtype = _scalar(array) if axes else None
        make = np.empty if any("capacity" in str(axis) for axis in axes) else np.zeros
        found[name] = partial(make, dtype=dtype) if axes else array, tuple(axes)
    return found


def _scalar(array: Any) -> Any:
    """Return the type of an array's numbers; how deep it is within differs between NumPy's."""
    inner = [one for one in get_args(array) if one is not Any]
    scalars = (one for one in inner if isinstance(one, type) and issubclass(one, np.generic))
    return next(scalars, None) or next(filter(None, map(_scalar, inner)), None)

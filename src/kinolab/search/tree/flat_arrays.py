"""Arrays for compiled kernels: allocated as the fields of named tuples declare them, and copied."""

from __future__ import annotations

from typing import Any, TypeVar, get_args, get_type_hints

import numpy as np

from kinolab.numerics.jit import kernel

T = TypeVar("T")


def allocate(kind: type[T], sizes: dict[str, int], **given: Any) -> T:
    """Return a named tuple whose arrays are allocated.

    A field says its shape: ``Annotated[Array, "capacity", "nx"]``. Arrays with a capacity are left
    as memory is, since what they hold is written before it is read, and to clear it all would take
    milliseconds. All others are zero.

    Args:
        kind: The tuple's class.
        sizes: Lengths of axes, by name.
        given: All fields that are not to be allocated.
    """
    for name, hint in get_type_hints(kind, include_extras=True).items():
        if name not in given:
            array, *axes = get_args(hint)
            make = np.empty if "capacity" in axes else np.zeros
            shape = [axis if isinstance(axis, int) else sizes[axis] for axis in axes]
            given[name] = make(shape, get_args(get_args(array)[1])[0])
    return kind(**given)


@kernel
def copy(source, target):  # type: ignore[no-untyped-def]
    """Write the entries of an array (n,) to another one (n,)."""
    for i in range(source.shape[0]):
        target[i] = source[i]

"""Entries of arrays, written by compiled kernels."""

from __future__ import annotations

from kinolab.numerics.jit import kernel


@kernel
def copy(source, target):  # type: ignore[no-untyped-def]
    """Write the entries of an array (n,) to another one (n,)."""
    for i in range(source.shape[0]):
        target[i] = source[i]

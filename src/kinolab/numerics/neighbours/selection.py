"""Selection: a range's smaller values first."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.jit import kernel


@kernel
def partition_median(values, axis, order, first, last, at):  # type: ignore[no-untyped-def]
    """Quickselect in ``order``: no value before ``at`` exceeds one after it.

    The partition has no branch that depends on a value, which processors would guess wrongly.

    Args:
        values: Shape (n, d).
        axis: The column to compare.
        order: Rows of ``values``, shape (n,); written.
        first, last: Range to sort, both ends included.
        at: Position in that range.

    Source: Hoare, Algorithm 65: find, Communications of the ACM 4(7), 1961; the partition is
    Lomuto's, in Bentley, Programming Pearls, 2nd ed., 2000, column 11; the pivot, Singleton,
    Algorithm 347, Communications of the ACM 12(3), 1969.
    """
    while first < last:
        a, b = values[order[first], axis], values[order[(first + last) // 2], axis]
        c = values[order[last], axis]
        pivot = max(min(a, b), min(max(a, b), c))  # the median of three
        above = first
        for k in range(first, last + 1):
            row = order[k]
            order[k], order[above] = order[above], row
            above += np.int64(values[row, axis] < pivot)
        if at < above:
            last = above - 1
        elif above > first:
            first = above
        else:  # nothing is below the pivot: what equals it comes first
            for k in range(first, last + 1):
                row = order[k]
                order[k], order[above] = order[above], row
                above += np.int64(values[row, axis] <= pivot)
            if at < above:
                return
            first = above

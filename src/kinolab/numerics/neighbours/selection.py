"""Selection: a range's smaller values first."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.jit import kernel

SAMPLED = 32  # the pivot of longer ranges is of nine samples, not three


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
    Lomuto's, in Bentley, Programming Pearls, 2nd ed., 2000, column 11; the pivot, Bentley,
    McIlroy, Engineering a sort function, Software: Practice and Experience 23(11), 1993.
    """
    while first < last:
        pivot = pivot_of(values, axis, order, first, last)
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


@kernel
def pivot_of(values, axis, order, first, last):  # type: ignore[no-untyped-def]
    """Return a value near the median of a range, as ``partition_median`` takes it."""
    if last - first < SAMPLED:
        return median_of_three(values, axis, order, first, last)
    step, middle = (last - first) // 8, (first + last) // 2
    low = median_of_three(values, axis, order, first, first + 2 * step)
    centre = median_of_three(values, axis, order, middle - step, middle + step)
    high = median_of_three(values, axis, order, last - 2 * step, last)
    return max(min(low, centre), min(max(low, centre), high))


@kernel
def median_of_three(values, axis, order, first, last):  # type: ignore[no-untyped-def]
    """Return the median of the values at both ends of a range and halfway."""
    a, c = values[order[first], axis], values[order[last], axis]
    b = values[order[(first + last) // 2], axis]
    return max(min(a, b), min(max(a, b), c))

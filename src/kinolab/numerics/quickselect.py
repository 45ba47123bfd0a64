"""Finding the middle of some values without sorting them, for trees that are halved."""

from __future__ import annotations

from kinolab.numerics.jit import kernel


@kernel
def partition_median(values, axis, order, first, last, at):  # type: ignore[no-untyped-def]
    """Sort ``order`` between first and last so far that no value before ``at`` exceeds one after.

    Args:
        values: Shape (n, d).
        axis: The column that is compared.
        order: Rows of ``values``, shape (n,); written.
        first, last: The ends of the part that is sorted, both included.
        at: In that part.

    Source: Hoare, Algorithm 65: find, Communications of the ACM 4(7), 1961.
    """
    while first < last:
        pivot = values[order[(first + last) // 2], axis]
        i, j = first, last
        while i <= j:
            while values[order[i], axis] < pivot:
                i += 1
            while values[order[j], axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i, j = i + 1, j - 1
        if at <= j:
            last = j
        elif at >= i:
            first = i
        else:
            return

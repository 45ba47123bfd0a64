"""Few rectangles that cover the marked cells of a grid exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Integers


def rectangles(marked: NDArray[np.bool_]) -> Integers:
    """Cover the marked cells (ny, nx) by rectangles that share no cell.

    Runs of cells along an axis are joined with equal ones beside them; the axis is the one that
    takes fewer rectangles.

    Returns:
        First row, first column, and those one past the last, of each, shape (n, 4).
    """
    along_x, along_y = _joined_runs(marked), _joined_runs(marked.T)
    return along_x if len(along_x) <= len(along_y) else along_y[:, [1, 0, 3, 2]]


def _joined_runs(marked: NDArray[np.bool_]) -> Integers:
    """Join the runs of rows that begin and end alike in rows that follow each other."""
    padded = np.zeros((marked.shape[0], marked.shape[1] + 2), np.int8)
    padded[:, 1:-1] = marked
    change = np.diff(padded, axis=1)
    row, begin = np.nonzero(change == 1)
    end = np.nonzero(change == -1)[1]
    order = np.lexsort((row, end, begin))
    row, begin, end = row[order], begin[order], end[order]
    fresh = np.ones(len(row), dtype=bool)
    fresh[1:] = (begin[1:] != begin[:-1]) | (end[1:] != end[:-1]) | (row[1:] != row[:-1] + 1)
    first = np.flatnonzero(fresh)
    last = np.append(first[1:], len(row)) - 1 if len(row) else first
    found = np.stack([row[first], begin[first], row[last] + 1, end[first]], axis=1)
    return found.astype(np.int64)

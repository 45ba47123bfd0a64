"""Search graph: the states that a search explored and the edges between them."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.untrusted import array_file, why

Integers: TypeAlias = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class SearchGraph:
    """A tree or a roadmap of states.

    Attributes:
        x: States, shape (n, nx).
        edges: Pairs of rows of ``x``, the earlier one first, shape (m, 2).
    """

    x: Array
    edges: Integers

    @classmethod
    def of_tree(
        cls, states: Callable[[Integers], Array], parents: Integers, *, most: int = 10_000
    ) -> SearchGraph:
        """Return the graph of a tree, thinned to about ``most`` states.

        Each remaining state is connected to its nearest remaining ancestor.

        Args:
            states: Returns the states of given rows, shape (rows, nx).
            parents: Row of each state's parent, shape (n,); -1 for a root.
            most: Approximate number of states to keep.
        """
        size = len(parents)
        kept = np.zeros(size, dtype=bool)
        kept[:: max(-(-size // most), 1)] = True
        kept |= np.asarray(parents) < 0
        above, own = np.asarray(parents).astype(np.int64), np.flatnonzero(kept)
        ancestors = above[own]
        while (skipped := (ancestors >= 0) & ~kept[ancestors]).any():
            ancestors = np.where(skipped, above[ancestors], ancestors)
        rows, joined = np.cumsum(kept) - 1, ancestors >= 0
        edges = np.stack([rows[ancestors[joined]], rows[own[joined]]], axis=1)
        return cls(np.array(states(own)), edges.astype(np.int32))

    def to_npz(self, state_names: Sequence[str]) -> bytes:
        """Serialise as ``search.npz``."""
        out = io.BytesIO()
        np.savez_compressed(
            out, x=self.x, edges=self.edges.astype(np.int32), state_names=np.array(state_names)
        )
        return out.getvalue()


def read_graph(path: Path, state_names: Sequence[str]) -> SearchGraph:
    """Read a ``search.npz``.

    Raises:
        InputError: If it is damaged or belongs to another machine.
    """
    try:
        file = array_file(path)
        x, edges, names = file["x"], file["edges"], file["state_names"]
    except (KeyError, OSError, ValueError) as error:
        raise InputError(
            [Mistake(str(path), f"it is damaged ({why(error)}).", "Plan again.")]
        ) from error
    fits = x.ndim == 2 and x.dtype.kind == "f" and x.shape[1] == len(state_names)
    fits &= names.dtype.kind == "U" and names.tolist() == list(state_names)
    inside = edges.ndim == 2 and edges.shape[1] == 2 and edges.dtype.kind == "i"
    if not (fits and inside and (not edges.size or 0 <= edges.min() <= edges.max() < len(x))):
        raise InputError([Mistake(str(path), "it is not of this machine.", "Plan again.")])
    if not np.isfinite(x).all():
        row, column = np.argwhere(~np.isfinite(x))[0]
        where = f"{path} row {row + 1} column {state_names[column]}"
        raise InputError([Mistake(where, f"{x[row, column]} is not finite.", "Plan again.")])
    return SearchGraph(x, edges)

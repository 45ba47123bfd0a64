"""KPIECE's cells in their hash table: found again until they are removed, few and many alike."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Record
from kinolab.search.tree import search_state
from kinolab.search.tree.kpiece.kpiece_grid import (
    BLOCK,
    FEW,
    clear_cells,
    first_place,
    holds,
    kpiece_grid,
    put,
)

CAPACITY = 2000


@kernel
def put_all(cells, keys):  # type: ignore[no-untyped-def]
    for node in range(keys.shape[0]):
        put(cells, keys[node], node, 1.0)


@kernel
def held_of(cells, keys, held):  # type: ignore[no-untyped-def]
    for k in range(keys.shape[0]):
        held[k] = holds(cells, keys[k])


@pytest.mark.parametrize("count", [1, 40, CAPACITY])
def test_cells_are_found_again_until_they_are_removed(count: int) -> None:
    """Half the keys share the slot where the search for them begins."""
    problem = kinolab.load("pendulum_swingup")
    grid = kpiece_grid(problem, search_state(problem, 1.0, 1).problem, CAPACITY, 1.0, 40)
    cells, generator = Record(grid), np.random.default_rng(count)
    slots = len(grid.table)
    assert 40 * FEW < slots < CAPACITY * FEW  # both ways to remove them
    for _ in range(3):
        keys = generator.integers(0, 2**28, count)
        keys[::2] = 7 + slots * np.arange(len(keys[::2]))
        assert len({first_place(key, slots - 1) for key in keys[::2].tolist()}) == 1
        distinct, times = np.unique(keys, return_counts=True)
        put_all(cells, keys)
        held = np.zeros(len(distinct), np.int64)
        held_of(cells, distinct, held)
        np.testing.assert_array_equal(held, times)
        assert grid.size[0] == len(distinct)
        clear_cells(cells)
        held_of(cells, distinct, held)
        assert not held.any()
        assert not grid.table.any()
        assert not grid.importance[: len(distinct) + BLOCK].any()

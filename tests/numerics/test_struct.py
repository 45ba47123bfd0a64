"""Records against the named tuples that they stand for."""

from __future__ import annotations

import pickle
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import typeof

from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Record


class Inner(NamedTuple):
    singles: Any
    share: float


class Outer(NamedTuple):
    table: Any
    count: int
    inner: Inner
    sound: bool
    flags: Any


@kernel
def total(outer):  # type: ignore[no-untyped-def]
    found = outer.inner.share * outer.count
    for i in range(outer.table.shape[0]):
        for j in range(outer.table.shape[1]):
            if not (outer.sound and outer.flags[i]):
                found += outer.table[i, j]
    for i in range(outer.inner.singles.shape[0]):
        outer.inner.singles[i] += outer.table[0, i]
    return found


def example(sound: bool = True) -> Outer:
    table = np.arange(6.0).reshape(2, 3)
    inner = Inner(np.zeros(3, np.float32), 0.5)
    return Outer(table, 7, inner, sound, np.array([True, False]))


@pytest.mark.parametrize("sound", [True, False])
def test_compiled_code_reads_and_writes_what_the_tuple_holds(sound: bool) -> None:
    held = example(sound)
    assert total(Record(held)) == 3.5 + (12.0 if sound else 15.0)
    assert held.inner.singles.tolist() == [0.0, 1.0, 2.0]
    held.table[0] = 10.0
    total(Record(held))
    assert held.inner.singles.tolist() == [10.0, 11.0, 12.0]


def test_records_of_one_form_share_compiled_code_and_others_do_not() -> None:
    kind = typeof(Record(example()))
    assert kind == typeof(Record(example(sound=False)))
    assert pickle.loads(pickle.dumps(kind)) == kind
    assert kind != typeof(Record(example()._replace(table=np.zeros(3))))
    assert kind != typeof(Record(example()._replace(count=7.0)))


def test_an_array_that_is_not_contiguous_is_refused() -> None:
    with pytest.raises(ValueError, match="table of Outer is not contiguous"):
        Record(example()._replace(table=np.zeros((4, 4))[:, ::2]))


def test_a_record_of_a_changed_tuple_reads_the_changes_and_shares_the_rest() -> None:
    first = Record(example())
    inner = Inner(np.ones(3, np.float32), 2.0)
    held = first.held._replace(count=3, inner=inner, flags=np.array([True, True]))
    changed = first.of(held)
    assert typeof(changed) == typeof(first)
    assert total(changed) == 2.0 * 3
    assert inner.singles.tolist() == [1.0, 2.0, 3.0]
    assert first.held.inner.singles.tolist() == [0.0, 0.0, 0.0]
    assert total(first) == 3.5 + 12.0

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


def test_a_record_apart_has_copies_of_what_was_named_and_shares_the_rest() -> None:
    first = Record(example())
    apart = first.apart({"inner": {"singles": {}}, "flags": {}})
    assert typeof(apart) == typeof(first)
    first.held.flags[:] = True
    apart.held.flags[:] = False
    assert total(first) == 3.5
    assert total(apart) == 3.5 + 15.0
    first.held.table[0, 0] = 100.0  # which both have
    assert total(apart) == 3.5 + 115.0
    assert first.held.inner.singles.tolist() == [0.0, 1.0, 2.0]
    assert apart.held.inner.singles.tolist() == [100.0, 2.0, 4.0]


def test_copies_of_all_in_a_tuple_lie_in_cache_lines_of_their_own() -> None:
    whole = Record(example()).apart({})
    places = sorted(
        array.__array_interface__["data"][0]
        for array in (whole.held.table, whole.held.inner.singles, whole.held.flags)
    )
    assert not any(place % 64 for place in places)
    assert all(np.diff(places) >= 64)
    assert total(whole) == 3.5 + 12.0

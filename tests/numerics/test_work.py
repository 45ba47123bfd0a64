"""What is charged, and on which clocks it is counted."""

from __future__ import annotations

import pytest

from kinolab.numerics.work import charge, counted_work, in_whole_ticks


def test_clocks_count_what_is_charged_inside_them() -> None:
    with counted_work() as outer:
        charge(1.0)
        with counted_work() as inner:
            charge(2.0)
        charge(4.0)
    charge(8.0)
    assert (inner.seconds, outer.seconds) == (2.0, 7.0)


def test_work_counted_apart_is_charged_by_whoever_waited_for_it() -> None:
    with counted_work() as outer:
        with counted_work(apart=True) as inner:
            charge(2.0)
            with counted_work() as innermost:
                charge(1.0)
        assert outer.seconds == 0.0
        charge(inner.seconds)
    assert (innermost.seconds, inner.seconds, outer.seconds) == (1.0, 3.0, 3.0)


def test_the_parts_in_which_something_is_charged_make_no_difference() -> None:
    each = in_whole_ticks(5.756e-6)
    assert each == pytest.approx(5.756e-6, abs=2**-41)
    with counted_work() as at_once:
        charge(0.1)
        charge(7919 * each)
        charge(0.3)
    with counted_work() as in_parts:
        charge(0.3)
        for _ in range(7919):
            charge(each)
        charge(0.1)
    assert in_parts.seconds == at_once.seconds

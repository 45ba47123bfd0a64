"""What is charged, and on which clocks it is counted."""

from __future__ import annotations

from kinolab.numerics.work import charge, counted_work


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

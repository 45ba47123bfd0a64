"""How far along a path at which time: a smooth share from 0 to 1."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.steering.path_motion import TimeScaling

TIMINGS = [
    TimeScaling(1.0, 0.0),
    TimeScaling(0.5, 2.0),
    TimeScaling(3.0, 0.25),
    TimeScaling(0.01, 100.0),
]
each = pytest.mark.parametrize("timing", TIMINGS)


@each
def test_the_share_grows_from_0_to_1_and_rests_at_both_ends(timing: TimeScaling) -> None:
    share, rate, slope = timing.at(np.linspace(0, timing.duration, 10_001))
    assert (share[0], share[-1]) == pytest.approx((0, 1), abs=1e-12)
    assert (np.diff(share) >= -1e-15).all()
    assert [rate[0], rate[-1], slope[0], slope[-1]] == pytest.approx([0] * 4, abs=1e-12)
    assert rate.max() == pytest.approx(timing.speed, rel=1e-12)
    assert np.abs(slope).max() <= 2.1875 * timing.speed / timing.ramp * (1 + 1e-12)


@each
def test_rate_and_slope_are_the_derivatives_of_the_share(timing: TimeScaling) -> None:
    """By central differences, which err by the square of their step."""
    t, h = np.linspace(0, timing.duration, 997)[1:-1], 1e-5 * timing.ramp
    (before, slow, _), (after, fast, _) = timing.at(t - h), timing.at(t + h)
    _, rate, slope = timing.at(t)
    assert (after - before) / (2 * h) == pytest.approx(rate, abs=1e-6 * timing.speed)
    assert (fast - slow) / (2 * h) == pytest.approx(slope, abs=1e-6 * timing.speed / timing.ramp)


def test_two_more_derivatives_are_continuous() -> None:
    """The third jumps by nothing where ramps end, nor does the fourth: polynomials on both sides.

    On a grid of step h a continuous slope's second differences, divided by h, are of order h.
    """
    timing = TimeScaling(1.0, 1.0)
    jumps = []
    for h in (1e-3, 5e-4):
        _, _, slope = timing.at(np.arange(0, 3 + h / 2, h))
        fourth = np.diff(slope, 2) / h**2
        jumps.append(float(np.abs(np.diff(fourth)).max()))
    assert jumps[1] < 0.6 * jumps[0]  # a jump would stay as it is


@each
@pytest.mark.parametrize("step", [0.1, 0.05, 0.7, 1 / 3])
def test_a_stretched_timing_takes_whole_steps_and_hardly_more(
    timing: TimeScaling, step: float
) -> None:
    longer = timing.stretched(step)
    count = longer.duration / step
    assert count == pytest.approx(round(count), abs=1e-9)
    assert round(count) >= 2
    assert timing.duration - 1e-6 <= longer.duration <= max(timing.duration + step, 2 * step)
    assert longer.cruise * timing.ramp == pytest.approx(timing.cruise * longer.ramp)  # same shape


def test_whole_steps_are_not_made_one_more_by_rounding() -> None:
    assert TimeScaling(0.3, 0.1).stretched(0.1).duration == pytest.approx(0.7, abs=1e-12)


def test_before_and_after_it_stands() -> None:
    share, rate, slope = TimeScaling(1.0, 0.5).at(np.array([-1e-9, 2.5 + 1e-9]))
    assert share == pytest.approx([0, 1], abs=1e-8)
    assert [*rate, *slope] == pytest.approx([0] * 4, abs=1e-8)

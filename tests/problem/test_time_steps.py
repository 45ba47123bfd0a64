"""How many steps cover a duration."""

from __future__ import annotations

import pytest

from kinolab.problem.time_steps import covering_steps


@pytest.mark.parametrize(
    ("duration", "step", "steps"),
    [
        (1.0, 0.1, 10),
        (0.3, 0.1, 3),  # 0.3 / 0.1 is 2.9999999999999996
        (0.7, 0.1, 7),  # 0.7 / 0.1 is 6.999999999999999
        (0.1 + 0.2, 0.1, 3),  # 3.0000000000000004 steps
        (1.00000005, 0.1, 10),  # half a millionth of a step too long
        (1.0000002, 0.1, 11),
        (1.001, 0.1, 11),
        (0.05, 0.1, 1),
        (0.0, 0.1, 0),
    ],
)
def test_a_duration_that_is_whole_steps_but_for_rounding_takes_no_further_one(
    duration: float, step: float, steps: int
) -> None:
    assert covering_steps(duration, step) == steps

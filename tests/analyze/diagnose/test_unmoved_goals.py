"""Coordinates that no motion from a start changes, against a machine whose equation says so."""

from __future__ import annotations

import pytest

import kinolab
from kinolab.analyze.diagnose.unmoved_goals import unmoved_goals, unmoved_sentences
from kinolab.dynamics import Body, Pull, System, angle, length, move, rot_y, toward
from kinolab.problem import PlanningTask


def hoist(theta: float) -> PlanningTask:
    """A load on a winch: r theta'' + 2 r' theta' + g sin(theta) = 0 has no input."""
    r, q = length("r", 0.3, 3.0, speed=2.0), angle("theta", speed=6.0)
    hook = move(0, 0, 4)
    load = Body("load", hook @ rot_y(q) @ move(0, 0, -r), mass=1.0)
    winch = Pull("winch", between=(hook, load.frame), limit=30.0)
    machine = System("hoist", bodies=[load], inputs=[winch], gravity=toward("-z"))
    return kinolab.load(
        {"system": machine, "start": {"r": 1.0, "theta": theta}, "goal": {"r": 2.0, "theta": 0.7}}
    )


def test_a_load_that_hangs_at_rest_stays_on_the_vertical() -> None:
    found = unmoved_goals(hoist(0.0))
    assert [entry.name for entry in found] == ["theta"]
    (sentence,) = unmoved_sentences(found)
    assert "From this start theta stays where it is" in sentence
    assert "[start] theta = 0.1" in sentence


@pytest.mark.parametrize("theta", [0.2, -0.2])
def test_one_that_swings_does_not(theta: float) -> None:
    found = unmoved_goals(hoist(theta))
    assert found == ()
    assert list(unmoved_sentences(found)) == []

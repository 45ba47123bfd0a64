"""What falls faster than it may move is not led anywhere by inputs computed beforehand."""

from __future__ import annotations

import kinolab
from kinolab.analyze.diagnose.growing_errors import growing_errors_sentence
from kinolab.dynamics import Body, System, Torque, angle, move, rot_y, toward
from kinolab.problem.static_holding import start_holding

LENGTH = 0.02  # [m]; upright, a point mass falls e-fold within sqrt(l / g) = 0.045 s


def finger(speed: float) -> System:
    """A point mass on a light rod, upright at q = 0."""
    q = angle("q", speed=speed)
    tip = Body("tip", rot_y(q) @ move(0, 0, LENGTH), mass=0.01)
    motor = Torque("motor", on=tip, about=tip.frame.y, limit=1.0)
    return System("finger", bodies=[tip], inputs=[motor], gravity=toward("-z", 9.81))


def said(speed: float, start: float = 0.0) -> str:
    goal = {"q": start + 1.0, "at_rest": True}
    table = {"system": finger(speed), "start": {"q": start}, "goal": goal}
    problem = kinolab.load({**table, "bounds": {"q": [-2.0, 6.0]}})
    return growing_errors_sentence(problem, start_holding(problem))


def test_a_way_that_takes_longer_than_errors_are_small_is_told() -> None:
    """1 rad at 0.5 rad/s is 2 s: e^44."""
    told = said(0.5)
    assert "grow e-fold within 0.045 s where it starts, and the way takes 2 s at least" in told
    assert told.endswith("faster ([bounds]), or give it a law (System(..., feedback=...)).")


def test_what_moves_quickly_or_hangs_is_not() -> None:
    assert said(5.0) == ""  # e^4.4
    assert said(0.5, 3.14159265) == ""

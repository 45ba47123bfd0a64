"""Is there a state in the goal at all? Heights and lengths of machines tell."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import kinolab
from kinolab.analyze.diagnose.state_clearance import approach_sentences, unmet_sentences
from kinolab.problem.goal_entries import goal_entries
from kinolab.problem.goal_states import goal_states
from kinolab.scenario import builtin_scenarios
from tests.analyze.diagnose.scenarios import PENDULUM
from tests.support import OPEN, problem_of

CAR = """\
schema = 1
title = "A car"

[system]
name = "car"

[world]
bounds = { x = [0, 20], y = [0, 20] }

[[goal.point]]
body = "chassis"
position = [8.0, 9.0, 2.0]
tolerance = 0.1
"""


def test_a_goal_in_mid_air_is_out_of_a_cars_reach(tmp_path: Path) -> None:
    """Its centre is 0.3 m above the ground, wherever it drives."""
    problem = problem_of(tmp_path, CAR, "bounds.phi_dot=[-1, 1]")
    goals = goal_states(problem)
    assert goals.inside == ()
    assert problem.frames(goals.nearest)[0, [3, 7]] == pytest.approx([8.0, 9.0], abs=1e-3)
    assert list(unmet_sentences(problem, goals.nearest)) == [
        "The machine has no configuration in the goal: the nearest one misses "
        "distance of chassis = 1.7 (wanted 0 ± 0.1)."
    ]


def test_a_goal_on_the_ground_is_found(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, CAR.replace("2.0]", "0.3]"), "bounds.phi_dot=[-1, 1]")
    goals = goal_states(problem)
    assert goals.inside
    assert problem.goal_excess(goals.nearest) <= 1.0


@pytest.mark.parametrize("name", builtin_scenarios())
def test_every_scenario_has_states_in_its_goal_at_rest(name: str) -> None:
    problem = kinolab.load(name)
    goals = goal_states(problem)
    assert goals.inside
    assert all(problem.goal_excess(x) <= 1.0 for x in goals.inside)


PAIR = """
from kinolab.dynamics import (
    WORLD, Body, Sphere, System, Torque, angle, closed, move, rot_z
)

def pair():
    a, b = angle("a", speed=5.0), angle("b", speed=5.0)
    ball = {"mass": 1.0, "inertia": (1, 1, 1), "shape": Sphere(0.1)}
    one = Body("one", rot_z(a) @ move(1, 0, 0), **ball)
    two = Body("two", move(3, 0, 0) @ rot_z(b) @ move(1, 0, 0), **ball)
    return System("pair", bodies=[one, two], constraints=[closed(a - b, "together")],
                  inputs=[Torque("turn", on=one, about=WORLD.z, limit=1.0)])
"""


def test_a_loop_is_closed_in_the_goal(tmp_path: Path) -> None:
    """One angle is wanted; the other one must follow it."""
    (tmp_path / "pair.py").write_text(PAIR)
    text = PENDULUM.replace('name = "pendulum"', 'file = "pair.py:pair"').replace("theta", "a")
    goals = goal_states(problem_of(tmp_path, text))
    assert goals.inside
    for x in goals.inside:
        assert math.remainder(x[0] - x[1], 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_what_was_reached_and_what_was_missed_is_told(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "goal.tolerance=0.1", "goal.psi=3.0")
    x = problem.start.copy()
    x[:3] = 0.05, 2.0, -3.0
    entries = goal_entries(problem, x)
    assert [(entry.name, entry.reached) for entry in entries] == [
        ("y", False),
        ("psi", False),
        ("x", True),
    ]
    assert entries[1].error == pytest.approx(2 * 3.141592653589793 - 6.0)  # round the circle
    assert list(approach_sentences(entries, moved=True)) == [
        "The nearest approach misses y = 2 (wanted 0 ± 0.1), psi = -3 (wanted 3 ± 0.1); "
        "it reaches x."
    ]
    assert next(approach_sentences(entries, moved=False)).startswith(
        "Nothing came nearer than the start, which misses y = 2 "
    )


def test_an_approach_that_misses_nothing_is_not_worth_a_sentence(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM, "start.theta=1.57")
    assert list(approach_sentences(goal_entries(problem, problem.start), moved=True)) == []

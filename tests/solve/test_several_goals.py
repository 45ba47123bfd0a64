"""Several goals: reached in the order written or the best one; the proof says when."""

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.errors import EndpointError, InputError
from kinolab.problem.goals_reached import goals_reached
from kinolab.runs.report import goal_distance_by_unit
from kinolab.simulation.reference import resimulate
from kinolab.verification import verify
from tests.support import problem_of

PUCK = """
from kinolab.dynamics import Body, Force, Sphere, System, length, move

def puck() -> System:
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    f = move(x, y, 0)
    b = Body("puck", f, mass=1.0, shape=Sphere(0.1))
    forces = [Force("px", on=b, along=f.x, limit=1.0), Force("py", on=b, along=f.y, limit=1.0)]
    return System("puck", bodies=[b], inputs=forces)
"""
HEAD = """
schema = 1
title = "A puck with several goals"
[system]
file = "puck.py:puck"
[bounds]
x = [-6.0, 6.0]
y = [-6.0, 6.0]
[start]
x = 0.0
y = 0.0
[planner]
improve = 1
"""


def goal(x: float, y: float, *lines: str) -> str:
    told = "\n".join(lines)
    return f"[[goal]]\nx = {x}\ny = {y}\ntolerance = 0.05\nat_rest = true\n{told}\n"


def puck(folder: Path, *goals: str, head: str = HEAD) -> kinolab.Problem:
    (folder / "puck.py").write_text(PUCK, encoding="utf-8")
    return problem_of(folder, head + "\n".join(goals), name="goals.toml")


def least_time(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Rest to rest with acceleration 1 and speed 2 along each axis: the slower axis decides."""
    return max(2 * d**0.5 if d <= 4 else 2 + d / 2 for d in np.abs(np.subtract(b, a)).tolist())


def test_goals_are_reached_in_the_order_written(tmp_path: Path) -> None:
    places = [(2.0, 0.0), (2.0, 3.0), (0.0, 3.0)]
    plan = puck(tmp_path, *(goal(*place) for place in places)).solve(seed=1)
    assert plan.status == "solved"
    assert plan.certificate is not None
    assert plan.trajectory is not None
    times = plan.certificate.reached
    assert list(times) == sorted(times)
    for time, place in zip(times, places, strict=True):
        assert plan.trajectory.at(time).x[:2] == pytest.approx(place, abs=0.05)
    least = sum(least_time(a, b) for a, b in zip([(0.0, 0.0), *places], places, strict=False))
    assert least * 0.97 <= times[-1] <= 1.1 * least  # tolerances take some of it


def test_it_stays_as_long_as_it_must(tmp_path: Path) -> None:
    plan = puck(tmp_path, goal(1.0, 0.0, "hold = 1.5"), goal(2.0, 0.0, "hold = 0.5")).solve(seed=1)
    assert plan.status == "solved"
    assert plan.certificate is not None
    assert plan.trajectory is not None
    t, x = plan.trajectory.t, plan.trajectory.x
    for begin, seconds, place in zip(plan.certificate.reached, (1.5, 0.5), (1.0, 2.0), strict=True):
        there = (t >= begin - 1e-9) & (t <= begin + seconds + 1e-9)
        assert np.abs(x[there, 0] - place).max() <= 0.05
    assert t[-1] == pytest.approx(plan.certificate.reached[-1] + 0.5)


@pytest.mark.search
def test_any_order_is_as_short_as_the_best_of_all(tmp_path: Path) -> None:
    places = [(3.0, 0.5), (-1.0, 1.0), (1.0, -1.0), (2.0, 1.5)]
    plan = puck(tmp_path, *(goal(*p, 'order = "any"') for p in places)).solve(seed=1)
    assert plan.status == "solved"
    assert plan.certificate is not None
    best = min(
        sum(least_time(a, b) for a, b in zip([(0.0, 0.0), *order], order, strict=False))
        for order in permutations(places)
    )
    assert plan.duration is not None
    assert plan.duration <= 1.1 * best
    assert sorted(plan.certificate.reached)[-1] == pytest.approx(plan.duration, abs=0.5)


def test_the_end_is_told_from_the_goal_where_it_is(tmp_path: Path) -> None:
    """The goal that is written last is the nearest, and reached first."""
    places = [(2.0, 0.0), (1.0, 0.0)]
    problem = puck(tmp_path, *(goal(*p, 'order = "any"') for p in places))
    plan = problem.solve(seed=1)
    assert plan.certificate is not None
    assert plan.trajectory is not None
    there = float(np.hypot(*(plan.trajectory.x[-1][:2] - places[0])))
    by_unit = goal_distance_by_unit(problem, plan)
    assert by_unit is not None
    assert by_unit["m"] == pytest.approx(there, abs=1e-12)
    second, first = plan.certificate.reached
    assert f"reaches [goal] at {first:.2f} s, [[via]] 1 at {second:.2f} s" in str(plan)
    assert f"ending {there:.3g} m and" in str(plan)


def test_a_motion_that_leaves_one_out_or_takes_them_in_another_order_does_not_pass(
    tmp_path: Path,
) -> None:
    first, second = goal(1.0, 0.0), goal(2.0, 0.0)
    straight = puck(tmp_path, first, second).solve(seed=1)
    assert straight.trajectory is not None
    for wrong in ((second, first), (first, goal(1.0, 1.0), second)):
        certificate = verify(puck(tmp_path, *wrong), straight.trajectory)
        assert "goals on the way" in {check.name for check in certificate.failures}
    other = puck(tmp_path, goal(2.0, 0.0, 'order = "any"'), first)
    assert verify(other, straight.trajectory).passed
    waiting = puck(tmp_path, goal(1.0, 0.0, "hold = 1.0"), second)
    assert not verify(waiting, straight.trajectory).passed


def test_when_goals_are_reached_is_told_of_the_rows_alone(tmp_path: Path) -> None:
    problem = puck(tmp_path, goal(1.0, 0.0, "hold = 0.2"), goal(2.0, 0.0))
    t = 0.1 * np.arange(8.0)
    x = np.zeros((8, 4))
    x[:, 0] = [0.0, 1.0, 0.5, 1.0, 1.0, 1.0, 1.5, 2.0]
    assert goals_reached(problem, t, x) == pytest.approx([0.3, 0.7])
    x[4, 0] = 0.9
    assert np.isnan(goals_reached(problem, t, x)[0])


def test_each_impossible_goal_is_named(tmp_path: Path) -> None:
    with pytest.raises(EndpointError) as refused:
        puck(tmp_path, goal(9.0, 0.0), goal(1.0, 0.0), goal(0.0, 7.0)).solve()
    assert "x is 9, outside" in str(refused.value)
    assert "[[via]] 1" in str(refused.value)
    assert "y is 7, outside" in str(refused.value)


def test_wrong_names_are_told_of_every_goal(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        puck(tmp_path, "[[goal]]\nz = 1.0\n", "[[goal]]\nxx = 1.0\n")
    assert "'z'" in str(refused.value)
    assert "'xx'" in str(refused.value)


def test_who_cannot_stand_still_cannot_stay(tmp_path: Path) -> None:
    moving = "[[goal]]\nx = 1.0\nx_dot = 0.5\ntolerance = 0.05\nhold = 1.0\n"
    with pytest.raises(EndpointError, match="cannot stay"):
        puck(tmp_path, moving, goal(2.0, 0.0)).solve(seed=1)


def test_who_leaves_between_two_rows_has_not_stayed(tmp_path: Path) -> None:
    """It moves on a parabola that begins and ends in the goal, and is 0.125 m away in between."""
    first = "[[goal]]\nx = 0.0\ny = 0.0\ntolerance = 0.05\nhold = 1.0\n"
    last = "[[goal]]\nx = 0.5\ny = 0.0\ntolerance = 0.05\n"
    problem = puck(
        tmp_path, first, last, head=HEAD.replace("y = 0.0\n[pl", "y = 0.0\nx_dot = -0.5\n[pl")
    )
    motion = resimulate(problem, np.arange(3.0), np.array([[1.0, 0.0], [0.0, 0.0]]))
    assert motion.x[:, 0] == pytest.approx([0.0, 0.0, 0.5])
    assert [check.name for check in verify(problem, motion).failures] == ["goals on the way"]

"""Goals of which any will do, of formulas, and by a predicate, against closed forms of a puck."""

from pathlib import Path

import numpy as np
import pytest

from kinolab.errors import EndpointError, InputError
from kinolab.problem.goal_entries import goal_entries
from kinolab.runs import check_run, read_run
from kinolab.verification import verify
from tests.solve.test_several_goals import HEAD, puck

REST = "[goal]\nat_rest = true\ntolerance = 0.05\n"
PLACES = [(5.0, 5.0), (1.0, -1.0), (-3.0, 0.0)]
ANY = "\n".join(f"[[goal.any_of]]\nx = {x}\ny = {y}" for x, y in PLACES)
HALF_PLANE = '[[goal.region]]\nexpression = "x + y"\nleast = 3.0\n'


def test_of_several_goals_the_nearest_is_taken(tmp_path: Path) -> None:
    """From rest to rest over 1 m with 1 m/s^2 takes 2 s; the others are 3 m away or more."""
    problem = puck(tmp_path, REST + ANY)
    plan = problem.solve(seed=1)
    assert plan.status == "solved"
    assert plan.trajectory is not None
    assert plan.duration == pytest.approx(2.0, rel=1e-3)
    assert plan.trajectory.x[-1] == pytest.approx([1.0, -1.0, 0.0, 0.0], abs=1e-6)
    run = plan.save(tmp_path / "run")
    assert check_run(run).passed


def test_a_motion_to_any_of_the_goals_passes_and_to_none_does_not(tmp_path: Path) -> None:
    problem, alone = puck(tmp_path, REST + ANY), "x = {}\ny = {}\n"
    for (x, y), passes in ((PLACES[0], True), (PLACES[2], True), ((2.0, 2.0), False)):
        there = puck(tmp_path, REST + alone.format(x, y)).solve(seed=1)
        assert there.trajectory is not None
        assert verify(problem, there.trajectory).passed is passes


def test_one_goal_that_cannot_be_leaves_the_others(tmp_path: Path) -> None:
    outside = "[[goal.any_of]]\nx = 9.0\n"
    plan = puck(tmp_path, REST + outside + "[[goal.any_of]]\nx = 1.0\n").solve(seed=1)
    assert plan.status == "solved"
    with pytest.raises(EndpointError, match="x is 9, outside"):
        puck(tmp_path, REST + outside).solve()


def test_any_of_several_on_the_way(tmp_path: Path) -> None:
    last = "[[goal]]\nx = 1.0\ny = 1.0\nat_rest = true\ntolerance = 0.05\n"
    first = "[[goal]]\nat_rest = true\ntolerance = 0.05\n" + ANY + "\n"
    plan = puck(tmp_path, first + last).solve(seed=1)
    assert plan.status == "solved"
    assert plan.certificate is not None
    assert plan.certificate.reached[0] == pytest.approx(2.0, rel=0.05)


def test_a_half_plane_is_entered_the_shortest_way(tmp_path: Path) -> None:
    """A tenth beyond x + y = 3 both axes go 1.55 m, in 2 sqrt(1.55) s from rest to rest."""
    problem = puck(tmp_path, REST + HALF_PLANE)
    plan = problem.solve(seed=1, improve=3, time_limit=120.0)
    assert plan.status == "solved"
    assert plan.trajectory is not None
    assert plan.duration == pytest.approx(2 * np.sqrt(1.55), rel=0.01)
    assert plan.trajectory.x[-1, :2].sum() >= 3.0
    assert check_run(plan.save(tmp_path / "run")).passed
    beyond = puck(tmp_path, REST + HALF_PLANE.replace("3.0", "3.2"))
    assert {one.name for one in verify(beyond, plan.trajectory).failures} == {"goal"}


def test_a_curved_band_is_entered_the_shortest_way(tmp_path: Path) -> None:
    """Of all places with x y = 3/4, the middle, x = y = sqrt(3/4) takes least time."""
    band = '[[goal.region]]\nexpression = "puck.x * y"\nleast = 0.5\nmost = 1.0\n'
    plan = puck(tmp_path, REST + band).solve(seed=1, improve=3, time_limit=120.0)
    assert plan.status == "solved"
    assert plan.duration == pytest.approx(2 * 0.75**0.25, rel=0.01)


@pytest.mark.parametrize(
    ("region", "told"),
    [
        ('expression = "x_dot"\nleast = 1.0', "x_dot is no coordinate"),
        ('expression = "x + px"\nleast = 1.0', "px is no coordinate"),
        ('expression = "z"\nleast = 1.0', "no name is called 'z'"),
        ('expression = "x"', "nothing limits its formula"),
        ('expression = "x"\nleast = 2.0\nmost = 1.0', "1 is not above least, 2"),
    ],
)
def test_regions_that_cannot_be_are_refused(tmp_path: Path, region: str, told: str) -> None:
    with pytest.raises(InputError) as refused:
        puck(tmp_path, f"[[goal.region]]\n{region}\n")
    assert told in str(refused.value)


def test_a_formula_out_of_reach_is_named(tmp_path: Path) -> None:
    far = '[[goal.region]]\nexpression = "x**2 + y**2"\nleast = 90.0\n'
    with pytest.raises(EndpointError, match=r"has 90 <= x\*\*2 \+ y\*\*2"):
        puck(tmp_path, far).solve()


@pytest.mark.parametrize("planner", ["auto", "rrt", "sst"])
def test_a_plan_ends_where_a_predicate_holds(tmp_path: Path, planner: str) -> None:
    wide = puck(tmp_path, "[goal]\nx = 2.0\ntolerance = 0.2\n", head=HEAD)
    problem = wide.with_predicate(lambda x: bool(x[1] > 1.0 and x[2] < 0.5))
    plan = problem.solve(planner, seed=1, improve=1)
    assert plan.status == "solved"
    assert plan.trajectory is not None
    assert plan.certificate is not None
    x, y, x_dot, _ = plan.trajectory.x[-1]
    assert abs(x - 2.0) <= 0.2
    assert y > 1.0
    assert x_dot < 0.5
    assert "a predicate of the goal's end" in str(plan.certificate.conditions)
    other = wide.with_predicate(lambda x: bool(x[1] < 1.0))
    assert {one.name for one in verify(other, plan.trajectory).failures} == {"goal"}


def test_what_is_no_function_is_no_predicate(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="Give a function of the state"):
        puck(tmp_path, REST).with_predicate(3)  # type: ignore[arg-type]


def test_tables_within_tables_are_written_as_they_are_read(tmp_path: Path) -> None:
    """A run has its scenario with it; the goal that is missed least is the one that is told."""
    inner = 'region = [{ expression = "x", least = 2.0 }]\n'
    point = 'point = [{ body = "puck", position = [1.0, 0.0, 0.0] }]\n'
    first = "[[goal]]\ntolerance = 0.05\n" + point
    last = f"[[goal]]\nat_rest = true\n[[goal.any_of]]\nx = -5.0\n[[goal.any_of]]\n{inner}"
    problem = puck(tmp_path, first, last)
    plan = problem.solve(seed=1, improve=1)
    assert plan.status == "solved"
    run = plan.save(tmp_path / "run")
    assert read_run(run).problem.scenario.goals.keys() == problem.scenario.goals.keys()
    assert check_run(run).passed
    assert plan.trajectory is not None
    assert all(entry.reached for entry in goal_entries(problem, plan.trajectory.x[-1]))

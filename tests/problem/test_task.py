"""Start and goal, and the problem as OMPL sees it."""

from __future__ import annotations

import gc
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.errors import EndpointError, InputError
from kinolab.problem import PlanningTask
from tests.support import OPEN, WALL, Array, problem_of


def endpoint_mistakes(problem: PlanningTask) -> list[str]:
    with pytest.raises(EndpointError) as caught:
        problem.check_endpoints()
    return [str(mistake) for mistake in caught.value.mistakes]


# --- start and goal ---


def test_a_start_inside_a_wall_names_the_pair(tmp_path: Path) -> None:
    (told,) = endpoint_mistakes(problem_of(tmp_path, OPEN + WALL, "start.x=2.9"))
    assert "[start]" in told
    assert "coin touches wall" in told


def test_a_start_inside_a_solid_names_the_pair(tmp_path: Path) -> None:
    tetrahedron = "OFF\n4 4 0\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
    (tmp_path / "rock.off").write_text(tetrahedron)
    rock = '\n[[world.obstacle]]\nmesh = "rock.off"\nposition = [-2.5, -1.5, -0.5]\n'
    (told, *_) = endpoint_mistakes(problem_of(tmp_path, OPEN + rock))
    assert "coin is inside rock" in told


def test_a_start_beyond_a_limit_names_it(tmp_path: Path) -> None:
    told = endpoint_mistakes(problem_of(tmp_path, OPEN, "start.x=-5.5"))
    assert any("[start]" in mistake and "x is -5.5, outside -5 to 5" in mistake for mistake in told)


def test_start_and_goal_are_told_together(tmp_path: Path) -> None:
    told = endpoint_mistakes(problem_of(tmp_path, OPEN + WALL, "start.x=2.9", "goal.y=7"))
    assert any("[start]" in mistake for mistake in told)
    assert any("[goal]" in mistake and "y is 7" in mistake for mistake in told)


def test_a_goal_wholly_inside_a_wall_names_the_pair(tmp_path: Path) -> None:
    overrides = ("goal.x=3", "goal.tolerance=0.01")
    (told,) = endpoint_mistakes(problem_of(tmp_path, OPEN + WALL, *overrides))
    assert "[goal]" in told
    assert "coin touches wall" in told


def test_a_goal_whose_middle_is_blocked_but_whose_edge_is_free_is_possible(tmp_path: Path) -> None:
    """The wall is 0.1 m thick, the goal 1 m wide: beside the wall there is room for the coin."""
    problem_of(tmp_path, OPEN + WALL, "goal.x=3", "goal.tolerance=0.5").check_endpoints()


def test_a_goal_whose_middle_is_outside_but_whose_edge_is_inside_is_possible(
    tmp_path: Path,
) -> None:
    problem_of(tmp_path, OPEN, "goal.x=5.1", "goal.tolerance=0.5").check_endpoints()


@pytest.mark.parametrize("spread", [0.0, 0.1, 1.0])
def test_samples_of_a_goal_whose_middle_is_outside_lie_at_the_limit_or_inside(
    spread: float, tmp_path: Path
) -> None:
    """With a factor below 0.4, nothing of the goal about x = 0 +- 0.5 lies below x = -0.2."""
    text = OPEN.replace("x = [-5, 5]", "x = [-5, -0.2]")
    problem, random = problem_of(tmp_path, text), np.random.default_rng(1)
    one = np.array([problem.sample_goal(random, spread) for _ in range(50)])
    for drawn in (one, problem.sample_goals(random, np.full(50, spread))):
        assert (drawn[:, 0] <= -0.2 + 1e-8).all()  # how far a limit may be passed
        assert (drawn[:, 0] >= min(-0.5 * spread, -0.2) - 1e-8).all()


def test_limits_that_leave_nothing_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="limits of y exclude each other: 20 to 5"):
        problem_of(tmp_path, OPEN, "goal={ x = 0 }", "bounds.y=[20, 30]")


def test_a_world_without_a_sensible_size_is_refused(tmp_path: Path) -> None:
    huge = "bounds={ x = [-1e308, 1e308], y = [-1e308, 1e308] }"
    with pytest.raises(InputError, match="x may be as large as 1e\\+308"):
        problem_of(tmp_path, OPEN, "world.bounds={}", huge)
    wide = "bounds={ x = [-1e8, 1e8], y = [-1e8, 1e8] }"
    problem_of(tmp_path, OPEN, "world.bounds={}", wide).check_endpoints()


def test_a_start_two_millimetres_from_a_wall_can_drive_away(tmp_path: Path) -> None:
    """The coin's rim is 0.25 m behind its centre, the wall's face 0.252 m."""
    wall = '\n[[world.obstacle]]\nname = "wall"\nbox = [0.1, 2, 1]\nposition = [-1.302, 0, 0.5]\n'
    problem = problem_of(tmp_path, OPEN + wall)
    problem.check_endpoints()
    assert problem.solve(seed=1, max_iterations=5000).status == "solved"


def test_a_limit_on_an_angle_means_the_circle_to_planner_and_verifier(tmp_path: Path) -> None:
    """Limits wider than a turn forbid nothing."""
    overrides = ("bounds.psi=[-4, 4]", "start.psi=3", "goal={ x = -4.5, y = -1, tolerance = 0.5 }")
    problem = problem_of(tmp_path, OPEN, *overrides)
    for seed in (1, 2, 3):
        found = problem.solve(seed=seed, max_iterations=20_000)
        assert found.status == "solved", found.certificate


# --- limits of several states ---

LIMITS = {
    "cone": 'keep_out=[{ body = "coin", axis = "x", direction = [1, 0, 0], half_angle = 0.5 }]',
    "rate": "bounds.x_dot=[-0.2, 0.2]",  # which follows from the coin's turn and roll
}
NAN = 3  # in every ten states, the first that holds one


@pytest.mark.parametrize("name", ["submarine_corridor", "vehicle_parking", "two_cranes", *LIMITS])
def test_limits_of_many_states_are_those_of_each(name: str, tmp_path: Path) -> None:
    own = name in LIMITS
    problem = problem_of(tmp_path, OPEN, LIMITS[name]) if own else kinolab.load(name)
    x = around(problem, 300)
    outside = problem.outside_limits(x)
    assert outside.tolist() == [any(problem.limit_violations(state)) for state in x]
    assert 0 < outside.sum() < len(x)  # both are there
    assert outside[NAN::10].all()


@pytest.mark.parametrize("name", ["submarine_corridor", "satellite_pointing", *LIMITS])
def test_margins_of_poses_are_negative_where_the_world_is_left(name: str, tmp_path: Path) -> None:
    own = name in LIMITS
    problem = problem_of(tmp_path, OPEN, LIMITS[name]) if own else kinolab.load(name)
    x = around(problem, 300)
    frames = problem.model.frames(x[np.isfinite(x).all(axis=1)])
    beyond = (problem.pose_margins(frames) < 0).any(axis=1)
    assert beyond.tolist() == [any(problem.outside_world(poses)) for poses in frames]
    assert 0 < beyond.sum() < len(frames)  # both are there


def around(problem: PlanningTask, count: int) -> Array:
    """Return random states within limits and some way beyond, one in ten with a NaN."""
    random = np.random.default_rng(0)
    lower, upper = np.clip(problem.sampling_bounds.T, -50.0, 50.0)
    x: Array = random.uniform(lower, upper, (count, len(lower)))
    for first in problem.model.attitudes.values():
        x[:, first : first + 4] /= np.linalg.norm(x[:, first : first + 4], axis=1, keepdims=True)
    beyond = random.integers(0, len(lower), count)
    some = random.random(count) < 0.3
    x[some, beyond[some]] *= 1.5
    x[NAN::10, 0] = np.nan
    return x


# --- the goal ---


def test_angles_of_the_goal_are_compared_on_the_circle(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "goal={ psi = 3.1, tolerance = 0.1 }")
    x = np.zeros(6)
    for psi, distance in ((-3.1, 2 * np.pi - 6.2), (3.1 + 4 * np.pi, 0.0), (0.0, 3.1)):
        x[2] = psi
        assert problem.goal_distance(x) == pytest.approx(distance, abs=1e-12)
        assert problem.goal_excess(x) == pytest.approx(distance / 0.1, abs=1e-11)


def test_a_goal_may_be_a_ball_instead_of_a_box(tmp_path: Path) -> None:
    goal = "goal={ x = 1.0, psi = 3.1, norm = 'euclidean', tolerance = { x = 0.5, psi = 0.2 } }"
    problem = problem_of(tmp_path, OPEN, goal)
    x = np.array([1.4, 7.0, -3.1, 0.0, 0.0, 0.0])
    shares = np.hypot(0.4 / 0.5, (2 * np.pi - 6.2) / 0.2)
    assert problem.goal_excess(x) == pytest.approx(shares, abs=1e-12)
    random = np.random.default_rng(0)
    for spread in (1.0, 3.0):
        drawn = np.array([problem.sample_goal(random, spread) for _ in range(2000)])
        away = np.hypot((drawn[:, 0] - 1.0) / 0.5, (drawn[:, 2] - 3.1) / 0.2) / spread
        assert 0.99 < away.max() <= 1.0 + 1e-12
        assert np.mean(away < 0.5) == pytest.approx(0.25, abs=0.03)  # all places alike


def test_deviations_from_a_goal_may_be_added(tmp_path: Path) -> None:
    """The region is a diamond; half as far away lies a quarter of its area."""
    goal = "goal={ x = 1.0, psi = 3.1, norm = 'sum', tolerance = { x = 0.5, psi = 0.2 } }"
    problem = problem_of(tmp_path, OPEN, goal)
    x = np.array([1.4, 7.0, -3.1, 0.0, 0.0, 0.0])
    assert problem.goal_excess(x) == pytest.approx(0.8 + (2 * np.pi - 6.2) / 0.2, abs=1e-12)
    random = np.random.default_rng(0)
    for spread in (1.0, 3.0):
        one = [problem.sample_goal(random, spread) for _ in range(2000)]
        for drawn in (np.array(one), problem.sample_goals(random, np.full(2000, spread))):
            away = (np.abs(drawn[:, 0] - 1) / 0.5 + np.abs(drawn[:, 2] - 3.1) / 0.2) / spread
            assert 0.99 < away.max() <= 1.0 + 1e-12
            assert np.mean(away < 0.5) == pytest.approx(0.25, abs=0.03)
            assert np.mean(drawn[:, 0] > 1) == pytest.approx(0.5, abs=0.05)


def test_points_and_directions_of_the_goal_are_those_of_the_body(tmp_path: Path) -> None:
    """theta = pi / 2 puts the bob at (0, 1, 0) and turns its x axis to y."""
    text = """
schema = 1
title = "Reach"
[system]
name = "pendulum"
[[goal.point]]
body = "bob"
position = [0.0, 1.0, 0.3]
tolerance = 0.1
[[goal.direction]]
body = "bob"
axis = "x"
target = [0, 5, 0]
tolerance = 0.2
"""
    problem = problem_of(tmp_path, text)
    x = np.array([np.pi / 2, 0.0])
    assert problem.goal_distance(x) == pytest.approx(0.3)
    assert problem.goal_excess(x) == pytest.approx(3.0)
    x[0] -= 0.5  # the direction is off by 0.5 rad, the point by a chord and 0.3 m
    chord = 2 * np.sin(0.25)
    assert problem.goal_distance(x) == pytest.approx(np.sqrt(chord**2 + 0.3**2 + 0.5**2))


def test_a_goal_out_of_reach_is_told_by_how_much_and_nothing_else_is_blamed(tmp_path: Path) -> None:
    """The bob is 1 m from its pivot; a point 3 m away is out of reach, ball or no ball."""
    text = """
schema = 1
title = "Out of reach"
[system]
name = "pendulum"
[[goal.point]]
body = "bob"
position = [3.0, 0.0, 0.0]
tolerance = 0.1
"""
    ball = '[[world.obstacle]]\nname = "ball"\nsphere = 0.3\nposition = [1.0, 0.0, 0.0]\n'
    for problem in (problem_of(tmp_path, text), problem_of(tmp_path, text + ball)):
        (mistake,) = problem._goal_mistakes()
        assert mistake.where == "table.toml [[goal.point]] 1"
        assert mistake.what == (
            "no configuration was found that brings the point of bob to [3, 0, 0]: the closest "
            "misses by about 2 m, and the tolerance is 0.1 m."
        )


def test_a_direction_that_no_configuration_has_is_told_by_how_much(tmp_path: Path) -> None:
    """A pendulum swings about z: its x axis stays in the plane, an angle of pi / 3 from this."""
    text = """
schema = 1
title = "Out of the plane"
[system]
name = "pendulum"
[[goal.direction]]
body = "bob"
axis = "x"
target = [0, 0.5, 0.8660254]
tolerance = 0.1
"""
    (mistake,) = problem_of(tmp_path, text)._goal_mistakes()
    assert mistake.where.endswith("[[goal.direction]] 1")
    assert "the closest misses by about 1 rad" in mistake.what


@pytest.mark.parametrize("tolerance", [1e-9, 1e-6, 1e-3])
def test_a_point_at_the_very_end_of_an_arm_is_not_out_of_reach(
    tolerance: float, tmp_path: Path
) -> None:
    """One can see no further than rounding where the arm is stretched."""
    text = """
schema = 1
title = "At arm's length"
[system]
name = "pendulum"
[[goal.point]]
body = "bob"
position = [0.6, 0.8, 0.0]
"""
    problem = problem_of(tmp_path, text + f"tolerance = {tolerance}\n")
    assert not list(problem._goal_mistakes())


def test_a_planner_reaches_a_point_of_a_body(tmp_path: Path) -> None:
    text = """
schema = 1
title = "Swing to the side"
[system]
name = "pendulum"
[[goal.point]]
body = "bob"
position = [0.9, 0.43589, 0.0]
tolerance = 0.1
"""
    problem = problem_of(tmp_path, text)
    found = problem.solve(seed=1, max_iterations=20_000, optimize=False)
    assert found.status == "solved"
    assert found.trajectory is not None
    theta = found.trajectory.x[-1, 0]
    assert np.hypot(np.cos(theta) - 0.9, np.sin(theta) - 0.43589) <= 0.1


# --- OMPL ---


def test_circles_wrap_in_the_spaces_distance(table: PlanningTask) -> None:
    """3.1 and -3.1 rad lie 2 pi - 6.2 apart; the other entries add their weighted norms."""
    bridge = table.to_ompl()
    a, b = bridge.space.allocState(), bridge.space.allocState()
    bridge.write(a, [0, 0, 3.1, 0, 0, 0])
    bridge.write(b, [0, 0, -3.1, 0, 0, 0])
    psi = table.weights[2] * (2 * np.pi - 6.2)
    assert bridge.space.distance(a, b) == pytest.approx(psi)
    bridge.write(b, [0, 0, 3.1, 0, 0, 6.0])
    assert bridge.space.distance(a, b) == pytest.approx(6.0 / 12)  # weighted by the largest speed


def test_states_are_written_and_read_in_the_machines_order(table: PlanningTask) -> None:
    bridge = table.to_ompl()
    state, values = bridge.space.allocState(), [1.0, -2.0, 0.5, -0.25, 3.0, -4.0]
    bridge.write(state, values)
    assert bridge.read(state) == values


def test_weights_that_differ_and_angles_in_between_keep_the_order(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "metric={ x = 1, y = 2, psi_dot = 3, phi_dot = 3 }")
    bridge = problem.to_ompl()
    state, values = bridge.space.allocState(), [1.0, -2.0, 0.5, -0.25, 3.0, -4.0]
    bridge.write(state, values)
    assert bridge.read(state) == values


def test_a_metric_of_zeros_is_refused(tmp_path: Path) -> None:
    zeros = "metric={ x = 0, y = 0, psi = 0, phi = 0, psi_dot = 0, phi_dot = 0 }"
    with pytest.raises(InputError, match="all weights are 0"):
        problem_of(tmp_path, OPEN, zeros)


def _solves(problem: PlanningTask, name: str) -> bool:
    """Run OMPL's own planner with a projection of one's own."""
    from ompl import base as ob
    from ompl import control as oc
    from ompl import util as ou

    bridge = problem.to_ompl()

    class OnThePlane(ob.ProjectionEvaluator):  # type: ignore[misc]
        def getDimension(self) -> int:
            return 2

        def defaultCellSizes(self) -> None:
            self.setCellSizes([0.5, 0.5])  # [m]

        def project(self, state: Any, projection: Any) -> None:
            projection[0], projection[1] = state[0][0], state[0][1]  # x and y come first

    bridge.space.registerDefaultProjection(OnThePlane(bridge.space))
    ou.RNG.setSeed(1)
    planner = getattr(oc, name)(bridge.space_information)
    planner.setProblemDefinition(bridge.problem_definition)
    planner.setup()
    planner.solve(ob.timedPlannerTerminationCondition(10.0))
    return bool(bridge.problem_definition.hasExactSolution())


@pytest.mark.parametrize("name", ["KPIECE1", "EST"])
def test_ompls_planner_solves_a_problem_on_a_grid_of_ones_own(
    table: PlanningTask, name: str
) -> None:
    assert _solves(table, name)


def test_the_ompl_objects_outlive_the_bridge(table: PlanningTask) -> None:
    from ompl import base as ob
    from ompl import control as oc
    from ompl import util as ou

    def parts() -> tuple[Any, Any]:
        bridge = table.to_ompl()
        return bridge.space_information, bridge.problem_definition

    information, definition = parts()
    gc.collect()
    ou.RNG.setSeed(1)
    planner = oc.RRT(information)
    planner.setProblemDefinition(definition)
    planner.setup()
    planner.solve(ob.timedPlannerTerminationCondition(10.0))
    assert definition.hasExactSolution()


@pytest.mark.parametrize("name", ["rrt", "est", pytest.param("syclop_rrt", marks=pytest.mark.long)])
def test_thirty_solves_leave_nothing_behind(table: PlanningTask, name: str) -> None:
    for seed in range(1, 4):  # whatever is kept once is kept by now
        table.solve(planner=name, seed=seed, max_iterations=20)
    gc.collect()
    objects, resident = len(gc.get_objects()), _resident()
    for seed in range(1, 31):
        table.solve(planner=name, seed=seed, max_iterations=20)
    gc.collect()
    assert len(gc.get_objects()) - objects < 300  # ten per solve
    assert _resident() - resident < 30  # [MB]; one per solve


def _resident() -> float:
    """Return the memory of this process in [MB]; 0 where the system does not tell."""
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[1]) * 4096 / 1e6 if statm.exists() else 0.0


def test_solving_warns_of_nothing(table: PlanningTask) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        table.solve(seed=3, max_iterations=2000)

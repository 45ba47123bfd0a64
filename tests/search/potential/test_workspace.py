"""Which bodies lead, which points of them are pulled, and where these can be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import WORLD, Body, Force, System, Torque, angle, length, move, rot_z
from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Sphere
from kinolab.problem import PlanningTask
from kinolab.search.potential.control_points import ControlPoint, control_points, place
from kinolab.search.potential.field import Repulsion
from kinolab.search.potential.field_setup import navigation_field
from kinolab.search.potential.leading_bodies import leading_bodies
from kinolab.search.potential.workspace import around_goal, grid_of, inscribed_radius, open_cells
from kinolab.simulation import Propagator
from kinolab.world import BodyGeometry
from tests.support import OPEN, WALL, problem_of


def names(problem: PlanningTask) -> list[str]:
    return [point.name for point in control_points(problem)]


@pytest.mark.parametrize(
    ("scenario", "points"),
    [
        ("crane_factory", ["load"]),
        ("diffdrive_warehouse", ["front of robot", "back of robot"]),
        ("submarine_corridor", ["front of hull", "back of hull"]),
        ("vehicle_parking", ["front of chassis", "back of chassis"]),
        ("two_cranes", ["load_a", "load_b"]),
        ("rolling_disk_maze", ["coin"]),
        ("pendulum_swingup", ["front of bob", "back of bob"]),
    ],
)
def test_the_bodies_that_lead_are_pulled(scenario: str, points: list[str]) -> None:
    """A load leads its trolley; what is slender and turns is pulled at both ends."""
    assert names(kinolab.load(scenario)) == points


def test_a_body_is_pulled_at_its_middle_where_the_goal_leaves_its_heading_free(
    tmp_path: Path,
) -> None:
    text = (kinolab.load("diffdrive_trap").scenario.folder / "diffdrive_trap.toml").read_text()
    free = text.replace("psi = 0.0\n", "").replace(
        "psi = 0.2                                   # [rad]\n", ""
    )
    assert names(problem_of(tmp_path, free)) == ["robot"]


def test_the_goals_of_points_are_where_the_goal_puts_them() -> None:
    """A robot in its bay heads along +x; its ends lie 0.1 m before and behind its hull's middle."""
    front, back = control_points(kinolab.load("diffdrive_warehouse"))
    assert front.goal[:2] == pytest.approx([12.6 - 0.03 + 0.1, 8.6], abs=1e-9)
    assert back.goal[:2] == pytest.approx([12.6 - 0.03 - 0.1, 8.6], abs=1e-9)


def test_a_ball_as_wide_as_a_plank_fits_around_either_end() -> None:
    """2 m long, 0.6 m wide and 0.2 m thick: its control points are 1 - 0.3 m from its middle."""
    x, y = (length(name, -5.0, 5.0, speed=1.0) for name in "xy")
    psi = angle("psi", speed=1.0)
    frame = move(x, y, 0.5) @ rot_z(psi)
    plank = Body("plank", frame, mass=1.0, inertia=(1.0, 1.0, 1.0), shape=Box(2.0, 0.6, 0.2))
    pushes = [
        Force("along", on=plank, along=WORLD.x, limit=1.0),
        Force("across", on=plank, along=WORLD.y, limit=1.0),
        Torque("turn", on=plank, about=WORLD.z, limit=1.0),
    ]
    goal = {"x": 3.0, "y": 1.0, "psi": np.pi / 2}
    system = System("plank", bodies=[plank], inputs=pushes)
    front, back = control_points(kinolab.load({"title": "A plank", "system": system, "goal": goal}))
    assert front.at == pytest.approx([0.7, 0.0, 0.0])
    assert back.at == pytest.approx([-0.7, 0.0, 0.0])
    assert front.goal == pytest.approx([3.0, 1.7, 0.5])


def test_a_goal_s_point_is_pulled_itself(tmp_path: Path) -> None:
    text = OPEN.replace(
        "[goal]\nx = 0.0\ny = 0.0\ntolerance = 0.5\n",
        "[goal]\n[[goal.point]]\nbody = 'coin'\nat = [0.0, 0.0, 0.0]\n"
        "position = [1.0, 2.0, 0.25]\ntolerance = 0.1\n",
    )
    (point,) = control_points(problem_of(tmp_path, text))
    assert point.goal.tolist() == [1.0, 2.0, 0.25]


def test_a_crane_s_load_is_carried_by_three_lengths() -> None:
    problem = kinolab.load("crane_factory")
    (carrier,) = leading_bodies(problem)
    assert [problem.model.state_names[i] for i in carrier.lengths] == ["x", "y", "l"]


# --- where a point can be ---


def coin(tmp_path: Path, *overrides: str) -> tuple[PlanningTask, ControlPoint]:
    problem = problem_of(tmp_path, OPEN + WALL, *overrides)
    return problem, control_points(problem)[0]


def test_cells_are_open_where_the_machine_fits_in_some_attitude(tmp_path: Path) -> None:
    """The coin is 0.5 m long and 0.05 m thick; the wall's face is at x = 2.95, y from -2 to 2."""
    problem, point = coin(tmp_path)
    grid = grid_of(problem, point, 0.1, 16.0)
    free = open_cells(Propagator(problem), point, grid, lambda: False)
    assert free is not None
    beside = free[grid.cell_of(np.array([2.95 - 0.06, 0.5, 0.25]))]
    touching = free[grid.cell_of(np.array([2.95 + 0.05, 0.5, 0.25]))]
    assert beside  # with its face to the wall
    assert not touching
    assert free[grid.cell_of(np.array([4.0, 0.5, 0.25]))]  # behind the wall, reached around it


def test_what_cannot_be_reached_is_not_open(tmp_path: Path) -> None:
    """A wall across the whole table."""
    problem = problem_of(tmp_path, OPEN + WALL.replace("4.0, 1.0", "10.0, 1.0"))
    point = control_points(problem)[0]
    grid = grid_of(problem, point, 0.1, 16.0)
    free = open_cells(Propagator(problem), point, grid, lambda: False)
    assert free is not None
    assert free[grid.cell_of(np.array([-4.0, 0.0, 0.25]))]
    assert not free[grid.cell_of(np.array([4.0, 0.0, 0.25]))]


def test_a_search_that_must_end_does_not_go_on_looking(tmp_path: Path) -> None:
    problem, point = coin(tmp_path)
    grid = grid_of(problem, point, 0.02, 64.0)
    assert open_cells(Propagator(problem), point, grid, lambda: True) is None


@pytest.mark.parametrize("memory", [0.1, 1.0])
def test_cells_grow_where_memory_is_short(memory: float, tmp_path: Path) -> None:
    problem, point = coin(tmp_path)
    grid = grid_of(problem, point, 1e-3, memory)
    assert np.prod(grid.shape) * 64 <= memory * 1e6
    assert grid.size > 1e-3
    finer = grid_of(problem, point, 1e-3, 4 * memory)
    assert finer.size < grid.size


@pytest.mark.parametrize("resolution", [0.07, 0.1, 0.33])
def test_the_goal_is_a_corner_of_cells_and_the_workspace_is_covered(
    resolution: float, tmp_path: Path
) -> None:
    problem, point = coin(tmp_path)
    grid = grid_of(problem, point, resolution, 16.0)
    assert grid.axes == (0, 1)
    corner = (point.goal[:2] - grid.origin) / grid.size
    assert corner == pytest.approx(np.rint(corner), abs=1e-9)
    assert len(around_goal(grid, point.goal)) == 4
    top = grid.origin + grid.size * np.array(grid.shape)
    assert (grid.origin <= -5 + 1e-6).all()
    assert (top >= 5 - 1e-6).all()


def test_an_arm_s_point_is_judged_by_the_largest_ball_in_it() -> None:
    """No length carries a pendulum's bob: cells are open where a ball about the point fits."""
    problem = kinolab.load("pendulum_swingup")
    point = control_points(problem)[0]
    grid = grid_of(problem, point, 0.1, 16.0)
    free = open_cells(Propagator(problem), point, grid, lambda: False)
    assert free is not None
    hanging = place(point.at, problem.frames(problem.start)[0][None])[0]
    assert free[grid.cell_of(hanging)]
    assert 0 < (~free).sum() < free.size


@pytest.mark.parametrize(
    ("shape", "at", "radius"),
    [
        (Sphere(0.5, at=(1, 0, 0)), (1.2, 0, 0), 0.3),
        (Box(2.0, 1.0, 0.4), (0.9, 0, 0), 0.1),
        (Box(2.0, 1.0, 0.4), (0, 0, 0.1), 0.1),
        (Cylinder(0.3, 2.0, axis="x"), (0.5, 0.1, 0), 0.2),
        (Cylinder(0.3, 2.0, axis="x"), (0.9, 0.0, 0), 0.1),
        (Capsule(0.3, 2.0, axis="y"), (0, 1.1, 0), 0.2),
        (Capsule(0.3, 2.0, axis="y"), (0.1, 0.5, 0), 0.2),
        (Box(2.0, 1.0, 0.4), (5.0, 0, 0), 0.0),
    ],
)
def test_the_largest_ball_in_a_shape(
    shape: Box, at: tuple[float, float, float], radius: float
) -> None:
    found = inscribed_radius(BodyGeometry("body", (shape,)), np.array(at))
    assert found == pytest.approx(radius, abs=1e-12)


def way_to_goal(problem: PlanningTask, *, resolution: float, grid_memory: float) -> float:
    """Return the length of the way from the start, by navigation functions, in [m]."""
    field = navigation_field(
        Propagator(problem),
        Repulsion(0.0, 0.3),
        resolution=resolution,
        grid_memory=grid_memory,
        clearance_cost_radius=0.0,
        stop=lambda: False,
    )
    assert field is not None
    return float(field.potential(problem.start[None])[0])


def test_cells_are_halved_where_they_cut_the_start_off(tmp_path: Path) -> None:
    """Two walls leave a gap of 0.2 m for a coin 0.05 m thick; cells of 0.5 m do not see it."""
    walls = "".join(
        f'\n[[world.obstacle]]\nname = "{name}"\n'
        f"box = [0.4, 4.9, 1.0]\nposition = [1.0, {y}, 0.5]\n"
        for name, y in (("left", 2.55), ("right", -2.55))
    )
    problem = problem_of(tmp_path, OPEN + walls, "goal.x=3.0", "goal.y=0.3", "goal.tolerance=0.1")
    way = way_to_goal(problem, resolution=0.5, grid_memory=16.0)
    assert 4.0 < way < 5.0  # [m]; 4.01 m straight, a thousand times more through a wall


def test_a_world_may_lie_anywhere(tmp_path: Path) -> None:
    """A kilometre away the way around a wall to the goal is as long."""

    def way(x: float) -> float:
        bounds = f"{{ x = [{x - 5}, {x + 5}], y = [-5, 5] }}"
        moved = (f"world.bounds={bounds}", f"start.x={x - 1}", f"goal.x={x + 4.5}")
        wall = WALL.replace("[3.0,", f"[{x + 3},")
        problem = problem_of(tmp_path, OPEN + wall, *moved)
        return way_to_goal(problem, resolution=0.0, grid_memory=64.0)

    assert way(1000.0) == pytest.approx(way(0.0), rel=1e-6)

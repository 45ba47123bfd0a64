"""``[world] clearance``: plans keep this distance from obstacles, judged by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.analyze.simulate import simulate
from kinolab.dynamics import Body, Box, Force, Sphere, System, length, move
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.errors import EndpointError, InputError
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.verification import collision_check
from kinolab.world import (
    BodyGeometry,
    CollisionChecker,
    World,
    box_obstacle,
    sphere_obstacle,
)
from kinolab.world.distances import triangle_tree

RADIUS, POST, CLEARANCE = 0.1, 0.5, 0.3  # [m]
IDENTITY = np.hstack([np.eye(3), np.zeros((3, 1))])

SCENARIO = f"""
schema = 1
title = "A ball around a post"
[system]
file = "machine.json"
[world]
bounds = {{ x = [-1.0, 5.0], y = [-2.0, 2.0] }}
clearance = {CLEARANCE}
[[world.obstacle]]
name = "post"
sphere = {POST}
position = [2.0, 0.1, 0.0]
[goal]
x = 4.0
y = 0.0
at_rest = true
tolerance = 0.2
[integration]
step = 0.05
"""


def puck() -> System:
    x, y = length("x", speed=1.0), length("y", speed=1.0)
    body = Body("puck", move(x, y), mass=1.0, shape=Sphere(RADIUS))
    forces = [Force("f_x", on=body, along=move().x, limit=2.0)]
    forces.append(Force("f_y", on=body, along=move().y, limit=2.0))
    return System("puck", bodies=[body], inputs=forces)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("puck")
    (place / "machine.json").write_text(machine_to_json(puck()))
    (place / "puck.toml").write_text(SCENARIO)
    return place


@pytest.fixture(scope="module")
def problem(folder: Path) -> PlanningTask:
    return kinolab.load(folder / "puck.toml")


@pytest.mark.parametrize("planner", ["rrt", "rrt_fast", "kpiece_fast", "shooting"])
def test_every_kind_of_planner_keeps_its_distance(problem: PlanningTask, planner: str) -> None:
    found = problem.solve(planner=planner, seed=1, time_limit=60.0, improve=0.2)
    assert found.status == "solved"
    assert found.trajectory is not None
    t, x = found.trajectory.t, found.trajectory.x
    dense = np.linspace(t[0], t[-1], 20 * len(t))  # at most 1 m/s: 2.5 mm from look to look
    path = np.stack([np.interp(dense, t, x[:, i]) for i in (0, 1)], axis=1)
    gaps = np.linalg.norm(path - [2.0, 0.1], axis=1) - POST - RADIUS
    assert gaps.min() > CLEARANCE - 2e-3  # between knots the path is a parabola, not a chord
    assert gaps.min() < 2 * CLEARANCE  # it came by


def test_a_plan_that_was_made_for_less_clearance_fails(folder: Path, problem: PlanningTask) -> None:
    careless = kinolab.load(folder / "puck.toml", overrides=["world.clearance=0.0"])
    found = careless.solve(planner="rrt_fast", seed=1, max_iterations=20_000, improve=0.2)
    assert found.trajectory is not None
    assert collision_check(careless, found.trajectory).passed
    check = collision_check(problem, found.trajectory)
    assert not check.passed
    assert "puck near post" in check.detail


def test_a_start_that_is_too_near_is_refused(folder: Path) -> None:
    close = 2.0 - POST - RADIUS - 0.5 * CLEARANCE
    problem = kinolab.load(folder / "puck.toml", overrides=[f"start.x={close}", "start.y=0.1"])
    with pytest.raises(EndpointError, match="puck is nearer to post than"):
        problem.check_endpoints()


WIRE = "v 0 -3 0\nv 0 3 0\nv 0 1 0\nf 1 2 3\n"  # its corners are on one line
SAIL = "v 0 -3 -1\nv 0 3 -1\nv 0 0 3\nf 1 2 3\n"


def through_a_mesh(folder: Path, mesh: str) -> tuple[PlanningTask, Trajectory]:
    """A puck that slides along the x axis, through a mesh at x = 3.62 m, within 4 s."""
    (folder / "mesh.obj").write_text(mesh)
    post = f'name = "post"\nsphere = {POST}\nposition = [2.0, 0.1, 0.0]\n'
    placed = (
        'name = "mesh"\nmesh = "mesh.obj"\nposition = [2.0, 0.0, 0.0]\nrpy = [0.02, 0.0, 0.3]\n'
    )
    text = SCENARIO.replace(post, placed).replace(f"clearance = {CLEARANCE}", "")
    assert placed in text
    (folder / "mesh.toml").write_text(f"{text}[start]\nx_dot = 0.99\n")
    problem = kinolab.load(folder / "mesh.toml")
    return problem, simulate(problem, 4.0)


def test_a_wire_of_triangles_without_area_is_met(folder: Path) -> None:
    problem, motion = through_a_mesh(folder, WIRE)
    check = collision_check(problem, motion)
    assert not check.passed
    assert "puck touches mesh" in check.detail


def test_a_gap_that_is_wrongly_proved_does_not_pass(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """FCL is asked at every knot, whatever bounds say, and its word counts."""
    true = triangle_tree._planes
    monkeypatch.setattr(triangle_tree, "_planes", lambda t: np.add(true(t), [0.0, 0.0, 0.0, 10.0]))
    problem, motion = through_a_mesh(folder, SAIL)
    poses, ends = problem.placement(np.array([3.62, 0.0, 0.99, 0.0]))
    assert not problem.checker().collides(poses, ends)  # it is in the middle of the sail
    check = collision_check(problem, motion)
    assert not check.passed
    assert "mesh" in check.detail


def test_clearance_is_a_distance(folder: Path) -> None:
    with pytest.raises(InputError, match=r"world\.clearance"):
        kinolab.load(folder / "puck.toml", overrides=["world.clearance=-1"])


def test_corners_of_boxes_are_judged_by_their_distance() -> None:
    """Inflating a box by 0.1 moves its corners by 0.17: that is not the distance."""
    body = (BodyGeometry("crate", (Box(1.0, 1.0, 1.0),), False, "blue"),)
    diagonal = np.ones(3) / np.sqrt(3)

    def pose(gap: float) -> np.ndarray:
        """Place the crate so that its corner is a gap from a ball of radius 0.2 at the origin."""
        place = IDENTITY.copy()
        place[:, 3] = 0.5 * np.ones(3) + (0.2 + gap) * diagonal
        return place.reshape(1, 12)

    ball = sphere_obstacle("ball", 0.2)
    checker = CollisionChecker(body, World((ball,), clearance=0.1))
    poses = np.array([pose(gap) for gap in (0.3, 0.12, 0.101, 0.099, 0.05, -0.01)])
    assert [checker.collides(p) for p in poses] == [False, False, False, True, True, True]
    assert checker.first_collision(poses) == 3
    assert checker.first_collision(poses[:3]) is None
    assert checker.clearance(poses[0]) == pytest.approx(0.2, abs=1e-6)
    assert [contact.kind for contact in checker.contacts(poses[4])] == ["near"]
    assert [contact.kind for contact in checker.contacts(poses[5])] == ["touches"]
    assert checker.contacts(poses[2]) == []
    assert checker.inflated(0.1, ground=False).collides(poses[1])


def test_the_ground_is_not_kept_away_from() -> None:
    body = (BodyGeometry("crate", (Box(1.0, 1.0, 1.0),), False, "blue"),)
    world = World((box_obstacle("wall", (0.1, 1, 1), (2.0, 0, 0.5)),), ground=True, clearance=0.2)
    place = IDENTITY.copy()
    place[2, 3] = 0.51  # 1 cm above the ground
    assert not CollisionChecker(body, world).collides(place.reshape(1, 12))

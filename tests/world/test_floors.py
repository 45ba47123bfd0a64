"""What a mesh has at or below the ground is support; what is above it stays an obstacle."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

import kinolab
from kinolab.dynamics import WORLD, Body, Box, Force, System, length, move
from kinolab.errors import EndpointError
from kinolab.problem import PlanningTask
from kinolab.verification.between_samples.clearance_margin import state_clearance
from kinolab.world.meshes.mesh_components import components
from tests.support import problem_of

YARD = """\
schema = 1
title = "A car in a hall"
[system]
name = "car"
[world]
bounds = {{ x = [-30, 30], y = [-30, 30] }}
{ground}
[[world.obstacle]]
mesh = "hall.ply"
[start]
[goal]
x = 5.0
tolerance = 0.2
[integration]
step = 0.1
"""
GROUND = 'ground = "plane"'


def hall(folder: Path, depth: float, *, room: bool = False) -> None:
    """A floor, open or a room of 50 m around, so far below z = 0, and a post of 1 m at (8, 0)."""
    post = trimesh.creation.box((1, 1, 2)).apply_translation((8.0, 0.0, 1.0))
    if room:
        floor = trimesh.creation.box((50, 50, 10)).apply_translation((0, 0, 5.0 - depth))
        floor.invert()
    else:
        corners = np.array([[-25, -25, 0], [25, -25, 0], [25, 25, 0], [-25, 25, 0.0]])
        floor = trimesh.Trimesh(corners - [0, 0, depth], [[0, 1, 2], [0, 2, 3]])
    parts = [floor] if room else [floor, post]
    trimesh.util.concatenate(parts).export(folder / "hall.ply")


def car(folder: Path, ground: str = GROUND) -> PlanningTask:
    return problem_of(folder, YARD.format(ground=ground))


@pytest.mark.parametrize("depth", [0.0, 0.0045])
@pytest.mark.parametrize("room", [False, True])
def test_wheels_rest_on_a_floor(depth: float, room: bool, tmp_path: Path) -> None:
    hall(tmp_path, depth, room=room)
    problem = car(tmp_path)
    problem.check_endpoints()
    (floor,) = problem.world.floors
    assert len(floor.faces) == 2
    place = "at z = 0" if depth == 0 else "down to 4.5 mm below z = 0"
    assert problem.world.notes[-1].startswith(f"hall floor: 2 triangles {place}")


def test_a_floor_leaves_the_room_that_walls_leave(tmp_path: Path) -> None:
    """The post is 3 m away and more; 4.5 mm below the wheels there is nothing to meet."""
    hall(tmp_path, 0.0045)
    problem = car(tmp_path)
    clearance = state_clearance(
        problem, problem.start, problem.checker().inflated(0.0, ground=False)
    )
    assert clearance.clearance > 3.0
    x = problem.start.copy()
    x[list(problem.model.state_names).index("x")] = 7.0
    assert problem.checker().collides(*problem.placement(x))


def test_a_kerb_above_the_ground_is_no_floor(tmp_path: Path) -> None:
    hall(tmp_path, -0.003)
    problem = car(tmp_path)
    assert problem.world.floors == ()
    with pytest.raises(EndpointError, match="touches hall"):
        problem.check_endpoints()


def test_without_ground_the_way_out_is_named(tmp_path: Path) -> None:
    hall(tmp_path, 0.0)
    with pytest.raises(EndpointError, match='If that is its floor, write ground = "plane"'):
        car(tmp_path, "").check_endpoints()


def test_a_solid_that_reaches_up_keeps_its_bottom(tmp_path: Path) -> None:
    """Otherwise nothing would tell its inside from its outside."""
    hall(tmp_path, 0.1)
    (rest,) = car(tmp_path).world.obstacles
    assert rest.solid
    assert len(rest.faces) == 12
    assert components(rest.vertices, rest.faces).volume == pytest.approx([2.0])
    assert rest.parts is not None
    assert rest.parts.volume == pytest.approx([2.0])


def test_a_mesh_that_is_all_floor_stays_in_the_picture(tmp_path: Path) -> None:
    hall(tmp_path, 0.0)
    floor = trimesh.load(tmp_path / "hall.ply", process=False)
    floor.update_faces(np.arange(len(floor.faces)) < 2)
    floor.export(tmp_path / "hall.ply")
    problem = car(tmp_path)
    assert problem.world.obstacles == ()
    assert [len(floor.faces) for floor in problem.world.floors] == [2]


def test_no_floor_is_supposed_where_two_bodies_touch() -> None:
    """One stands on the ground; it is the other body that it touches, which is no floor."""
    x, y = length("x", speed=1.0), length("y", speed=1.0)
    cart = Body("cart", move(x, 0, 0.5), mass=1.0, shape=Box(1, 1, 1), touches_ground=True)
    cage = Body("cage", move(y, 0, 0.6), mass=1.0, shape=Box(1, 1, 1))
    pushes = [Force(f"push_{one.name}", on=one, along=WORLD.x, limit=1.0) for one in (cart, cage)]
    machine = System("carts", bodies=[cart, cage], inputs=pushes, collisions=[("cart", "cage")])
    limits = {"x": [-3, 3], "y": [-3, 3]}
    problem = kinolab.load({"system": machine, "bounds": limits, "goal": {"x": 2.0}})
    with pytest.raises(EndpointError, match="touches") as caught:
        problem.check_endpoints()
    assert "floor" not in str(caught.value)

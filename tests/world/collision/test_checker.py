"""Every verdict is compared with a placement whose gap is known, or with projections onto sets."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.errors import UnknownNameError
from kinolab.world import (
    BodyGeometry,
    CollisionChecker,
    Contact,
    Obstacle,
    World,
    box_obstacle,
    cylinder_obstacle,
    mesh_obstacle,
    sphere_obstacle,
)

Array = NDArray[np.float64]
MM = 1e-3  # [m]

# Shape, and its half sizes along x, y, z as a ruler gives them, in [m].
BODIES: dict[str, tuple[Shape, tuple[float, float, float]]] = {
    "box": (Box(0.6, 0.4, 0.2), (0.3, 0.2, 0.1)),
    "sphere": (Sphere(0.3), (0.3, 0.3, 0.3)),
    "cylinder": (Cylinder(0.2, 0.5, axis="x"), (0.25, 0.2, 0.2)),
    "capsule": (Capsule(0.15, 0.5, axis="y"), (0.15, 0.4, 0.15)),
    "disk": (Disk(0.25, 0.05, axis="y"), (0.25, 0.025, 0.25)),
}
OBSTACLES = {
    "box": (0.5, 0.35, 0.15),
    "sphere": (0.5, 0.5, 0.5),
    "cylinder": (0.4, 0.4, 0.6),
    "mesh": (0.5, 0.35, 0.15),
}
PAIRS = [(body, obstacle) for body in BODIES for obstacle in OBSTACLES]


def make_obstacle(
    name: str, folder: Path, factor: float = 1.0, rpy: object = (0, 0, 0)
) -> Obstacle:
    x, y, z = (2 * factor * half for half in OBSTACLES[name])
    if name == "box":
        return box_obstacle(name, (x, y, z), rpy=rpy)  # type: ignore[arg-type]
    if name == "sphere":
        return sphere_obstacle(name, x / 2)
    if name == "cylinder":
        return cylinder_obstacle(name, x / 2, z, rpy=rpy)  # type: ignore[arg-type]
    trimesh.creation.box((x, y, z)).export(folder / "box.stl")
    # STL stores single precision: the edges are exact to 1e-7 relative, so we scale a unit box.
    trimesh.creation.box((2, 2, 2)).export(folder / "unit.stl")
    scale = (x / 2, y / 2, z / 2)
    return mesh_obstacle(name, "unit.stl", folder, rpy=rpy, scale=scale)  # type: ignore[arg-type]


def checker_for(shape: Shape, *obstacles: Obstacle, **options: float) -> CollisionChecker:
    return CollisionChecker([BodyGeometry("body", (shape,))], World(obstacles), **options)  # type: ignore[arg-type]


def pose(position: object, R: Array | None = None) -> Array:
    table = np.column_stack([np.eye(3) if R is None else R, np.asarray(position, dtype=float)])
    return table.reshape(1, 12)


def turned(rpy: object) -> Array:
    """Turn by rpy through quaternion-free trimesh, not through our own rotation."""
    matrix: Array = trimesh.transformations.euler_matrix(*rpy, axes="sxyz")[:3, :3]  # type: ignore[misc]
    return matrix


@pytest.mark.parametrize(("body", "obstacle"), PAIRS)
@pytest.mark.parametrize("rpy", [(0.0, 0.0, 0.0), (0.3, -0.7, 1.9)])
def test_a_known_gap_along_every_axis_is_judged_to_the_millimetre(
    body: str, obstacle: str, rpy: tuple[float, float, float], tmp_path: Path
) -> None:
    """Both centres lie on a common axis of symmetry, where the gap is the difference of sizes."""
    shape, half = BODIES[body]
    checker = checker_for(shape, make_obstacle(obstacle, tmp_path, rpy=rpy))
    R = turned(rpy)
    if obstacle == "sphere":
        R = np.eye(3)  # the obstacle has no turn to share
    for axis in range(3):
        reach = half[axis] + OBSTACLES[obstacle][axis]
        for sign in (-1.0, 1.0):
            where = {gap: pose(sign * (reach + gap) * R[:, axis], R) for gap in (MM, 0.0, -MM)}
            assert not checker.collides(where[MM])
            assert checker.clearance(where[MM]) == pytest.approx(MM, abs=1e-8)  # [m], as promised
            assert checker.contacts(where[MM]) == []
            for gap in (0.0, -MM):
                assert checker.collides(where[gap]), (axis, sign, gap)
                assert checker.contacts(where[gap]) == [Contact("body", obstacle, "touches")]
                assert checker.clearance(where[gap]) == 0.0


@pytest.mark.parametrize(("body", "obstacle"), PAIRS)
@pytest.mark.parametrize("at", [(0.0, 0.0, 0.0), (0.31, -0.17, 0.09)])
def test_a_body_wholly_inside_a_solid_collides(
    body: str, obstacle: str, at: tuple[float, float, float], tmp_path: Path
) -> None:
    """The obstacle is ten times larger; above its centre runs an edge of the mesh."""
    checker = checker_for(BODIES[body][0], make_obstacle(obstacle, tmp_path, factor=10.0))
    kind: Literal["inside", "touches"] = "inside" if obstacle == "mesh" else "touches"
    assert checker.collides(pose(at))
    assert checker.contacts(pose(at)) == [Contact("body", obstacle, kind)]
    assert checker.clearance(pose(at)) == 0.0


@pytest.mark.parametrize(("body", "obstacle"), PAIRS)
def test_an_obstacle_wholly_inside_a_body_collides(
    body: str, obstacle: str, tmp_path: Path
) -> None:
    checker = checker_for(BODIES[body][0], make_obstacle(obstacle, tmp_path, factor=0.01))
    assert checker.collides(pose((0.003, 0.002, 0.001)))


def project(half: Array, kind: str, points: Array) -> Array:
    """Project points (n, 3) onto a convex set centred at the origin, in closed form."""
    if kind == "box":
        return np.clip(points, -half, half)
    core = np.zeros_like(points)
    if kind in ("capsule", "cylinder"):
        core[:, 2] = np.clip(points[:, 2], -half[2], half[2])
    offset = points - core if kind != "cylinder" else points * [1.0, 1.0, 0.0]
    length = np.maximum(np.linalg.norm(offset, axis=1, keepdims=True), 1e-300)
    return np.asarray(core + offset * np.minimum(1.0, half[0] / length))


def support(half: Array, kind: str, n: Array) -> Array:
    """Give the reach of a set along unit vectors (n, 3), in closed form."""
    across, along = np.linalg.norm(n[:, :2], axis=1), np.abs(n[:, 2])
    reach = {
        "box": np.abs(n) @ half,
        "sphere": half[0] + 0.0 * along,
        "capsule": half[0] + half[2] * along,
        "cylinder": half[0] * across + half[2] * along,
    }
    return np.asarray(reach[kind])


def gap_bounds(
    body: tuple[str, Array], R: Array, p: Array, obstacle: tuple[str, Array]
) -> tuple[Array, Array, Array]:
    """Enclose the distance by von Neumann's alternating projections onto two convex sets.

    The projections give points of both sets (an upper bound), the planes across their line a
    lower one; the last value is the direction from the obstacle to the body.

    Source: Bauschke, Borwein, SIAM Review 38(3), 1996.
    """
    b = np.zeros_like(p)
    for _ in range(600):
        local = project(body[1], body[0], np.einsum("nji,nj->ni", R, b - p))
        a = np.einsum("nij,nj->ni", R, local) + p
        b = project(obstacle[1], obstacle[0], a)
    upper = np.linalg.norm(a - b, axis=1)
    n = (a - b) / np.maximum(upper, 1e-300)[:, None]
    lower = np.einsum("ni,ni->n", n, p) - support(obstacle[1], obstacle[0], n)
    return lower - support(body[1], body[0], np.einsum("nji,nj->ni", R, n)), upper, n


ORACLE_BODIES: dict[str, tuple[Shape, str, Array]] = {
    "box": (Box(0.6, 0.4, 0.2), "box", np.array([0.3, 0.2, 0.1])),
    "sphere": (Sphere(0.3), "sphere", np.array([0.3, 0.3, 0.3])),
    "cylinder": (Cylinder(0.2, 0.5), "cylinder", np.array([0.2, 0.2, 0.25])),
    "capsule": (Capsule(0.15, 0.5), "capsule", np.array([0.15, 0.15, 0.25])),
    "disk": (Disk(0.25, 0.05), "cylinder", np.array([0.25, 0.25, 0.025])),
}


@pytest.mark.parametrize(("body", "obstacle"), PAIRS)
def test_random_poses_agree_with_alternating_projections(
    body: str, obstacle: str, tmp_path: Path
) -> None:
    shape, kind, half = ORACLE_BODIES[body]
    rng = np.random.default_rng(PAIRS.index((body, obstacle)))
    R = np.array(
        [trimesh.transformations.random_rotation_matrix(rng.random(3)) for _ in range(300)]
    )
    R, p = R[:, :3, :3], rng.uniform(-1.0, 1.0, (300, 3))
    fixed = ("box" if obstacle == "mesh" else obstacle, np.array(OBSTACLES[obstacle]))
    lower, upper, _ = gap_bounds((kind, half), R, p, fixed)
    checker = checker_for(shape, make_obstacle(obstacle, tmp_path))
    decided = 0
    for k in range(300):
        table = pose(p[k], R[k])
        if upper[k] < 1e-8:  # [m], far below the 1e-5 m by which bodies are inflated
            assert checker.collides(table)
            decided += 1
        elif lower[k] > 3e-5:  # [m]; the inflation moves the corners of a box by 1.7e-5
            assert not checker.collides(table), (lower[k], upper[k])
            assert lower[k] - 1e-8 <= checker.clearance(table) <= upper[k] + 1e-12
            decided += 1
        assert bool(checker.contacts(table)) == checker.collides(table)
    assert decided > 270  # the others are grazing poses, where projections converge slowly


@pytest.mark.parametrize(("body", "obstacle"), PAIRS)
def test_bodies_moved_until_they_just_touch_collide(
    body: str, obstacle: str, tmp_path: Path
) -> None:
    """Moving by the distance along the line of nearest points closes the gap to nothing.

    This is where FCL's tolerance shows, which the inflation of the bodies has to cover.
    """
    shape, kind, half = ORACLE_BODIES[body]
    rng = np.random.default_rng(100 + PAIRS.index((body, obstacle)))
    R = np.array(
        [trimesh.transformations.random_rotation_matrix(rng.random(3)) for _ in range(300)]
    )
    R, p = R[:, :3, :3], rng.normal(size=(300, 3))
    p *= 1.2 / np.linalg.norm(p, axis=1, keepdims=True)
    fixed = ("box" if obstacle == "mesh" else obstacle, np.array(OBSTACLES[obstacle]))
    lower, upper, n = gap_bounds((kind, half), R, p, fixed)
    checker = checker_for(shape, make_obstacle(obstacle, tmp_path))
    sharp = np.flatnonzero(upper - lower < 1e-8)  # [m], where the projections have converged
    assert len(sharp) > 270
    for k in sharp:
        assert checker.collides(pose(p[k] - upper[k] * n[k], R[k]))
        assert not checker.collides(pose(p[k] - (upper[k] - 3e-5) * n[k], R[k]))


def room_and_pillar(folder: Path) -> Obstacle:
    room = trimesh.creation.box((10, 10, 10))
    room.invert()
    pillar = trimesh.creation.box((1, 1, 4))
    trimesh.util.concatenate([room, pillar]).export(folder / "room.ply")
    return mesh_obstacle("room", "room.ply", folder)


def test_a_room_is_free_inside_and_its_pillar_is_solid(tmp_path: Path) -> None:
    checker = checker_for(Sphere(0.1), room_and_pillar(tmp_path))
    assert not checker.collides(pose((3.0, 2.0, 1.0)))
    assert checker.clearance(pose((3.0, 2.0, 1.0))) == pytest.approx(1.9, abs=1e-8)  # wall at x = 5
    assert checker.contacts(pose((0.0, 0.0, 0.3))) == [Contact("body", "room", "inside")]
    assert checker.contacts(pose((4.95, 0.0, 0.0))) == [Contact("body", "room", "touches")]
    assert not checker.collides(pose((7.0, 0.0, 0.0)))  # behind the wall there is nothing


def test_a_cavity_in_a_solid_is_free(tmp_path: Path) -> None:
    outer, cavity = trimesh.creation.box((4, 4, 4)), trimesh.creation.box((2, 2, 2))
    cavity.invert()
    trimesh.util.concatenate([outer, cavity]).export(tmp_path / "rock.off")
    checker = checker_for(Sphere(0.1), mesh_obstacle("rock", "rock.off", tmp_path))
    assert not checker.collides(pose((0.2, 0.1, 0.0)))
    assert checker.collides(pose((1.5, 0.1, 0.0)))
    filled = mesh_obstacle("rock", "rock.off", tmp_path, solid=True)
    assert checker_for(Sphere(0.1), filled).collides(pose((0.2, 0.1, 0.0)))
    hollow = mesh_obstacle("rock", "rock.off", tmp_path, solid=False)
    assert not checker_for(Sphere(0.1), hollow).collides(pose((1.5, 0.1, 0.0)))


@pytest.mark.parametrize("seed", range(3))
def test_inside_of_a_turned_mesh_agrees_with_its_closed_form(seed: int, tmp_path: Path) -> None:
    """Points of a lattice that hits edges and corners of an axis-aligned subdivided box."""
    rng = np.random.default_rng(seed)
    box = trimesh.creation.box((2, 2, 2)).subdivide().subdivide()
    box.export(tmp_path / "box.obj")
    rpy = (0.0, 0.0, 0.0) if seed == 0 else rng.uniform(-3, 3, 3)
    checker = checker_for(Sphere(1e-5), mesh_obstacle("b", "box.obj", tmp_path, rpy=rpy))  # type: ignore[arg-type]
    lattice = np.stack(np.meshgrid(*3 * [np.arange(-1.375, 1.5, 0.125)]), axis=-1).reshape(-1, 3)
    depth = 1.0 - np.abs(lattice).max(axis=1)
    for point, inside in zip(lattice[depth != 0], depth[depth != 0] > 0, strict=True):
        assert checker.collides(pose(turned(rpy) @ point)) == inside, point


def test_boxes_that_share_an_edge_are_solid(tmp_path: Path) -> None:
    """Four faces meet at the shared edge, as in mazes made of blocks."""
    blocks = [trimesh.creation.box((1, 1, 1)), trimesh.creation.box((1, 1, 1))]
    blocks[1].apply_translation((1, 1, 0))
    trimesh.util.concatenate(blocks).export(tmp_path / "blocks.stl")
    obstacle = mesh_obstacle("blocks", "blocks.stl", tmp_path)
    checker = checker_for(Sphere(0.1), obstacle)
    assert obstacle.warnings == ()
    assert checker.collides(pose((0.1, 0.05, 0.0)))
    assert checker.collides(pose((1.1, 0.95, 0.0)))
    assert not checker.collides(pose((1.2, 0.0, 0.0)))


def test_deep_overlap_of_boxes_does_not_hang() -> None:
    """FCL's distance was seen to hang here; clearance must not ask for it."""
    checker = checker_for(Box(1, 1, 1), box_obstacle("box", (1, 1, 1)))
    for shift in (0.0, 1e-9, 0.5):
        assert checker.clearance(pose((shift, 0.0, 0.0))) == 0.0


def test_margin_inflates_the_body() -> None:
    wall = box_obstacle("wall", (1, 1, 1))
    near = pose((0.7, 0.0, 0.0))  # 0.1 m from the wall
    assert not checker_for(Sphere(0.1), wall, margin=0.09).collides(near)
    assert checker_for(Sphere(0.1), wall, margin=0.11).collides(near)
    free = checker_for(Sphere(0.1), wall, margin=0.04)
    assert free.clearance(near) == pytest.approx(0.06, abs=1e-8)  # [m]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("entry", [0, 3, 11])
def test_a_pose_that_is_not_finite_collides(bad: float, entry: int) -> None:
    checker = checker_for(Sphere(0.1), box_obstacle("wall", (1, 1, 1)))
    table = pose((5.0, 0.0, 0.0))
    table[0, entry] = bad
    assert checker.collides(table)
    assert checker.contacts(table) == [Contact("body", "", "error")]
    assert checker.clearance(table) == 0.0


@pytest.mark.parametrize("far", [1e6, 1e200, 1.7e308])
def test_a_body_far_away_is_free(far: float, tmp_path: Path) -> None:
    checker = checker_for(Sphere(0.1), make_obstacle("mesh", tmp_path))
    assert not checker.collides(pose((far, -far, 0.0)))


def test_an_error_inside_fcl_counts_as_collision(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> bool:
        raise RuntimeError("FCL gave up")

    checker = checker_for(Sphere(0.1), box_obstacle("wall", (1, 1, 1)))
    monkeypatch.setattr(checker._narrowphase, "any_touch", fail)
    corner = pose((0.59, 0.59, 0.0))  # the boxes overlap, the bodies do not
    assert checker.collides(corner)
    assert checker.contacts(corner) == [Contact("body", "wall", "error")]


def test_ground_stops_bodies_and_carries_wheels() -> None:
    bodies = [
        BodyGeometry("trunk", (Box(0.2, 0.2, 0.2),)),
        BodyGeometry("wheel", (Disk(0.25, 0.05, axis="y"),), touches_ground=True),
    ]
    checker = CollisionChecker(bodies, World(ground=True))

    def at(trunk: float, wheel: float) -> Array:
        return np.concatenate([pose((0, 0, trunk)), pose((0, 0, wheel))])

    assert checker.contacts(at(0.101, 0.25)) == []
    assert checker.clearance(at(0.101, 0.25)) == pytest.approx(1e-3, abs=1e-6)  # [m]; trunk only
    assert checker.contacts(at(0.1, 0.25)) == [Contact("trunk", "ground", "touches")]
    assert checker.collides(at(0.1, 0.25))
    assert checker.contacts(at(1.0, 0.25 - 2e-6)) == [Contact("wheel", "ground", "sinks")]
    assert checker.collides(at(1.0, 0.25 - 2e-6))
    assert not checker.collides(at(1.0, 0.25 - 0.9e-6))
    assert not CollisionChecker(bodies, World()).collides(at(-5.0, -5.0))


def test_a_margin_lifts_bodies_but_not_wheels() -> None:
    bodies = [
        BodyGeometry("trunk", (Sphere(0.1),)),
        BodyGeometry("wheel", (Sphere(0.1),), touches_ground=True),
    ]
    checker = CollisionChecker(bodies, World(ground=True), margin=0.05)
    wheel = pose((0, 0, 0.1))
    assert not checker.collides(np.concatenate([pose((0, 0, 0.151)), wheel]))
    assert checker.collides(np.concatenate([pose((0, 0, 0.149)), wheel]))


def test_only_declared_pairs_collide_with_each_other() -> None:
    bodies = [BodyGeometry(name, (Sphere(0.5),)) for name in ("a", "b", "c")]
    table = np.concatenate([pose((x, 0, 0)) for x in (0.0, 0.9, 1.8)])
    checker = CollisionChecker(bodies, World(), self_pairs=[("a", "b"), ("a", "c")])
    assert not CollisionChecker(bodies, World()).collides(table)
    assert checker.collides(table)
    assert checker.contacts(table) == [Contact("a", "b", "touches")]
    table[1, 3] = 5.0
    assert not checker.collides(table)
    # a and c are 0.8 m apart and may both move.
    assert checker.clearance(table) == pytest.approx(0.4, abs=1e-8)  # [m]


def test_self_pairs_of_unknown_bodies_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'wheel'"):
        CollisionChecker([BodyGeometry("wheel", ())], World(), self_pairs=[("wheel", "weel")])


def test_every_shape_of_a_body_counts() -> None:
    """A dumbbell: the far sphere hits, named after its body."""
    body = BodyGeometry("bell", (Sphere(0.1), Sphere(0.1, at=(1.0, 0.0, 0.0))))
    checker = CollisionChecker([body], World((box_obstacle("wall", (0.2, 4, 4), (1.1, 0, 0)),)))
    assert checker.contacts(pose((0, 0, 0))) == [Contact("bell", "wall", "touches")]
    assert not checker.collides(pose((-0.2, 0, 0)))


@pytest.mark.parametrize("gap", [0.0, 0.3, 2.0])  # [m]
@pytest.mark.parametrize("clearance", [0.0, 0.2])  # [m] that the world asks for
def test_clearance_is_told_up_to_what_is_of_interest(gap: float, clearance: float) -> None:
    world = World((box_obstacle("box", (1.0, 1.0, 1.0), (2.5 + gap, 0.0, 0.0)),), True)
    checker = CollisionChecker(
        [BodyGeometry("body", (Sphere(1.0),))], replace(world, clearance=clearance)
    )
    for height in (1.1, 5.0):
        whole = checker.clearance(pose([1.0, 0.0, height]))
        for most in (0.01, 0.1, 1.0, 100.0):
            assert checker.clearance(pose([1.0, 0.0, height]), most=most) == min(whole, most)


def test_an_empty_world_has_all_the_room() -> None:
    checker = checker_for(Sphere(0.1))
    assert not checker.collides(pose((0, 0, 0)))
    assert checker.clearance(pose((0, 0, 0))) == math.inf


@pytest.mark.parametrize(
    "change",
    [lambda t: t.reshape(1, 3, 4), lambda t: t.astype(np.float32), np.asfortranarray],
)
def test_pose_tables_of_every_layout_are_understood(change: Callable[[Array], Array]) -> None:
    checker = checker_for(Sphere(0.1), box_obstacle("wall", (1, 1, 1)))
    assert checker.collides(change(pose((0.5, 0, 0))))
    assert not checker.collides(change(pose((0.7, 0, 0))))


def test_a_large_mesh_is_screened_and_judged(tmp_path: Path) -> None:
    """A ball of 20 480 triangles, whose corners lie on the sphere: the sagitta is below 1 mm."""
    trimesh.creation.icosphere(subdivisions=5, radius=1.0).export(tmp_path / "ball.glb")
    checker = checker_for(Sphere(0.1), mesh_obstacle("ball", "ball.glb", tmp_path))
    rng = np.random.default_rng(3)
    for direction in rng.normal(size=(200, 3)):
        n = direction / np.linalg.norm(direction)
        assert not checker.collides(pose(1.101 * n))
        assert checker.collides(pose(1.098 * n))
        assert checker.collides(pose(rng.uniform(0.0, 0.8) * n))
        assert 0.4 <= checker.clearance(pose(1.5 * n)) <= 0.401  # [m]


def test_the_first_of_many_poses_that_collides_is_found(tmp_path: Path) -> None:
    """A ball on its way to a mesh whose corner it passes, and on to a ball, as a ruler says."""
    mesh = make_obstacle("mesh", tmp_path)  # half sizes 0.5, 0.35, 0.15
    ball = sphere_obstacle("ball", 0.5, position=(3.0, 0.0, 0.0))
    checker = checker_for(Sphere(0.1), mesh, ball)
    way = np.linspace(-2.0, 4.0, 6001)
    beside = np.array([pose((x, 0.46, 0.0)) for x in way])  # 0.01 m above the mesh's side
    touching = 3.0 - math.sqrt(0.6**2 - 0.46**2)
    assert checker.first_collision(beside) == int(np.searchsorted(way, touching))
    assert checker.first_collision(beside[: int(1000 * (touching + 2.0)) - 1]) is None
    straight = np.array([pose((x, 0.0, 0.0)) for x in way])
    assert checker.first_collision(straight) == int(np.searchsorted(way, -0.6))
    assert checker.first_collision(straight[:0]) is None


def test_a_pose_among_many_that_is_no_number_collides(tmp_path: Path) -> None:
    table = np.array([pose((x, 0.0, 0.0)) for x in (5.0, 6.0, math.nan)])
    assert checker_for(Sphere(0.1), make_obstacle("mesh", tmp_path)).first_collision(table) == 2

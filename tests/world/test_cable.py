"""Cables against obstacles: every verdict is held against distances found another way.

The distance from a segment to a convex set is a convex function of the place along the segment, so
that a ternary search over exact distances of points finds it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from kinolab.dynamics.language.shapes import Sphere
from kinolab.errors import InputError, UnknownNameError
from kinolab.world import (
    BodyGeometry,
    CableGeometry,
    CollisionChecker,
    Contact,
    Obstacle,
    World,
    box_obstacle,
    mesh_obstacle,
)

Array = NDArray[np.float64]

RADIUS = 0.01  # [m]
ROPE = CableGeometry("rope", RADIUS)
HALF = np.array([0.5, 0.35, 0.15])  # [m] half edges of the box
NOBODY = np.zeros((0, 12))


def checker_for(
    *obstacles: Obstacle, cable: CableGeometry = ROPE, margin: float = 0.0
) -> CollisionChecker:
    return CollisionChecker([], World(obstacles), cables=[cable], margin=margin)


def nearest(ends: Array, project: Callable[[Array], Array]) -> tuple[Array, Array, Array]:
    """Return distances, points of segments, and points of a convex set for each.

    Args:
        ends: Of the segments, shape (n, 2, 3).
        project: Moves a point of each segment, shape (n, 3), to the nearest of the segment's set.
    """
    low, high = np.zeros(len(ends)), np.ones(len(ends))

    def at(s: Array) -> Array:
        return np.asarray(ends[:, 0] + s[:, None] * (ends[:, 1] - ends[:, 0]))

    def far(s: Array) -> Array:
        return np.asarray(np.linalg.norm(at(s) - project(at(s)), axis=1))

    for _ in range(100):  # (2/3)^100 of the length is below rounding
        a, b = low + (high - low) / 3, high - (high - low) / 3
        left = far(a) <= far(b)
        low, high = np.where(left, low, a), np.where(left, b, high)
    points = at((low + high) / 2)
    return far((low + high) / 2), points, project(points)


def to_box(points: Array) -> Array:
    return np.asarray(np.clip(points, -HALF, HALF))


def random_ends(rng: np.random.Generator, lengths: tuple[float, float]) -> Array:
    """Return both ends of a line that passes somewhere near the origin, shape (2, 3)."""
    way = rng.normal(size=3)
    way *= rng.uniform(*lengths) / np.linalg.norm(way)
    share = rng.uniform(0.0, 1.0)
    middle = rng.uniform(-0.6, 0.6, 3)
    return np.array([middle - share * way, middle + (1 - share) * way])


def box_of(kind: str, folder: Path) -> Obstacle:
    if kind == "box":
        return box_obstacle("thing", 2 * HALF)  # type: ignore[arg-type]
    trimesh.creation.box((2, 2, 2)).subdivide().export(folder / "unit.stl")
    return mesh_obstacle("thing", "unit.stl", folder, scale=tuple(HALF))  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["box", "mesh"])
@pytest.mark.parametrize("lengths", [(0.0, 0.1), (0.5, 3.0), (10.0, 60.0)])
@pytest.mark.parametrize("margin", [0.0, 0.07])
def test_random_cables_get_the_verdict_of_the_distance_to_a_box(
    kind: str, lengths: tuple[float, float], margin: float, tmp_path: Path
) -> None:
    rng, checker = np.random.default_rng(1), checker_for(box_of(kind, tmp_path), margin=margin)
    cables, hits = np.array([random_ends(rng, lengths) for _ in range(250)]), []
    for ends, gap in zip(cables, nearest(cables, to_box)[0] - RADIUS - margin, strict=True):
        if abs(gap - 1.5e-5) > 1.5e-5:  # [m]; cables are inflated by 1e-5
            hits.append(checker.collides(NOBODY, ends))
            assert hits[-1] == (gap < 0), gap
            assert bool(checker.contacts(NOBODY, ends)) == hits[-1]
            short = max(gap, 0.0) - checker.clearance(NOBODY, ends)
            assert -1e-9 <= short <= 1e-8 * max(lengths[1], 1.0)  # [m], as promised
    assert 20 < sum(hits) < 230


@pytest.mark.parametrize("kind", ["box", "mesh"])
@pytest.mark.parametrize("lengths", [(0.0, 0.1), (0.5, 3.0), (10.0, 60.0)])
def test_cables_moved_until_they_just_touch_collide(
    kind: str, lengths: tuple[float, float], tmp_path: Path
) -> None:
    """Moving by the distance along the line of nearest points closes the gap to nothing.

    Long and thin is where FCL's tolerance would show.
    """
    rng, checker = np.random.default_rng(2), checker_for(box_of(kind, tmp_path))
    cables = np.array([random_ends(rng, lengths) for _ in range(600)])
    gaps, on_rope, on_box = nearest(cables, to_box)
    apart = np.flatnonzero(gaps > 1e-3)[:200]
    assert len(apart) == 200
    for k in apart:
        way = (on_box[k] - on_rope[k]) / gaps[k]
        assert checker.collides(NOBODY, cables[k] + (gaps[k] - RADIUS) * way)
        assert not checker.collides(NOBODY, cables[k] + (gaps[k] - RADIUS - 3e-5) * way)


def test_random_cables_get_the_verdict_of_the_distance_to_triangles(tmp_path: Path) -> None:
    """Eighty loose triangles, and trimesh's projection of points onto each of them."""
    rng = np.random.default_rng(3)
    corners = rng.uniform(-1, 1, (80, 1, 3)) + rng.uniform(-0.3, 0.3, (80, 3, 3))
    soup = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(240).reshape(-1, 3), process=False)
    soup.export(tmp_path / "soup.ply")
    obstacle = mesh_obstacle("soup", "soup.ply", tmp_path)
    stored = obstacle.vertices[obstacle.faces]  # in single precision, as the file has it
    checker, hits = checker_for(obstacle), []
    cables = np.array([random_ends(rng, (0.2, 2.0)) for _ in range(150)])
    each = np.tile(stored, (len(cables), 1, 1))  # of a cable all triangles, then of the next

    def project(points: Array) -> Array:
        return np.asarray(trimesh.triangles.closest_point(each, points))

    far = nearest(np.repeat(cables, len(stored), axis=0), project)[0]
    for ends, gap in zip(cables, far.reshape(len(cables), -1).min(axis=1) - RADIUS, strict=True):
        if abs(gap - 1.5e-5) > 1.5e-5:  # [m]
            hits.append(checker.collides(NOBODY, ends))
            assert hits[-1] == (gap < 0), gap
            assert checker.clearance(NOBODY, ends) == pytest.approx(
                max(gap, 0.0), abs=2e-8
            )  # of 2 m
    assert 20 < sum(hits) < 130


def test_a_cable_is_inside_a_solid_mesh_or_leads_out_of_it(tmp_path: Path) -> None:
    checker = checker_for(box_of("mesh", tmp_path))
    inside, outside = [0.1, 0.1, 0.05], [0.3, 2.0, 0.05]
    within = np.array([inside, [-0.2, 0.0, -0.05]])
    leading_out = np.array([inside, outside])
    assert checker.contacts(NOBODY, within) == [Contact("rope", "thing", "inside")]
    for ends in (leading_out, leading_out[::-1]):
        assert checker.collides(NOBODY, ends)
        assert checker.contacts(NOBODY, ends) == [Contact("rope", "thing", "touches")]
    assert checker.collides(NOBODY, within)


def test_hoisting_takes_the_rope_out_of_the_way() -> None:
    """The rope hangs from z = 4 and ends where it was let down to; the beam's top is at z = 1."""
    checker = checker_for(box_obstacle("beam", (1, 1, 2)))
    for low in (1.5, 0.5, 1.02, 1.005, 3.9, -2.0, 1.0101):
        hanging = np.array([[0.1, 0.2, 4.0], [0.1, 0.2, low]])
        assert checker.collides(NOBODY, hanging) == (low - RADIUS <= 1.0), low
        free = max(low - RADIUS - 1.0, 0.0)
        assert checker.clearance(NOBODY, hanging) == pytest.approx(free, abs=1e-8)


def test_ends_that_coincide_make_a_ball() -> None:
    checker = checker_for(box_obstacle("wall", (1, 1, 1)))
    for gap in (1e-3, -1e-3):
        point = np.tile([0.5 + RADIUS + gap, 0.1, 0.2], (2, 1))
        assert checker.collides(NOBODY, point) == (gap < 0)


@pytest.mark.parametrize("way", [*np.eye(3), *-np.eye(3), [0, 1e-9, -1], [1e-160, 0, 0]])
def test_cables_along_every_axis_reach_as_far_as_they_are_long(way: list[float]) -> None:
    """One end touches a ball of radius 1 at the origin, or is 0.1 mm short of it."""
    n = np.array(way) / max(np.abs(way))
    n /= np.linalg.norm(n)
    ball = Obstacle("ball", np.eye(3), np.array([[0, 1, 2]]), (Sphere(1.0), np.eye(3, 4)))
    checker = checker_for(ball)
    for gap in (1e-4, -1e-4):
        near = (1.0 + RADIUS + gap) * n
        for ends in (np.array([near, near + 3 * n]), np.array([near + 0.1 * n, near])):
            assert checker.collides(NOBODY, ends) == (gap < 0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("entry", [0, 5])
def test_an_end_that_is_not_finite_collides(bad: float, entry: int) -> None:
    checker = checker_for(box_obstacle("wall", (1, 1, 1)))
    ends = np.array([[5.0, 0, 0, 6.0, 0, 0]])
    assert not checker.collides(NOBODY, ends)
    ends[0, entry] = bad
    assert checker.collides(NOBODY, ends)
    assert checker.contacts(NOBODY, ends) == [Contact("rope", "", "error")]
    assert checker.clearance(NOBODY, ends) == 0.0


@pytest.mark.parametrize("far", [1e6, 1e200, 1.7e308])
def test_a_cable_far_away_is_free(far: float) -> None:
    checker = checker_for(box_obstacle("wall", (1, 1, 1)))
    assert not checker.collides(NOBODY, np.array([[far, -far, 0.0], [far, far, far]]))


def test_the_ground_lets_a_cable_lie_on_it_and_pass() -> None:
    checker = CollisionChecker([], World(ground=True), cables=[ROPE], margin=0.1)
    for z in (0.0, -1.0):
        assert not checker.collides(NOBODY, np.array([[0, 0, 1.0], [1, 0, z]]))
    assert checker.clearance(NOBODY, np.array([[0, 0, 1.0], [1, 0, 0]])) == math.inf


def pose(*at: float) -> Array:
    return np.column_stack([np.eye(3), np.array(at, dtype=float)]).reshape(1, 12)


def test_only_declared_pairs_of_cables_and_bodies_collide() -> None:
    load, other = BodyGeometry("load", (Sphere(0.2),)), CableGeometry("other", 0.02)
    ends = np.array([[0, -1, 0, 0, 1, 0], [-1, 0, 0.02, 1, 0, 0.02]], dtype=float)

    def checker(*pairs: tuple[str, str]) -> CollisionChecker:
        return CollisionChecker([load], World(), cables=[ROPE, other], self_pairs=pairs)

    assert not checker().collides(pose(0, 0, 0), ends)
    assert checker(("load", "rope")).contacts(pose(0, 0, 0.1), ends) == [
        Contact("load", "rope", "touches")
    ]
    assert not checker(("load", "rope")).collides(pose(0, 0, 0.22), ends)
    crossing = checker(("rope", "other"))  # lines 0.02 m apart, radii 0.03 m together
    assert crossing.contacts(pose(0, 0, 0), ends) == [Contact("rope", "other", "touches")]
    ends[1, [2, 5]] = 0.04
    assert not crossing.collides(pose(0, 0, 0), ends)
    assert crossing.clearance(pose(0, 0, 0), ends) == pytest.approx(0.005, abs=1e-8)  # half of it
    with pytest.raises(UnknownNameError, match="Did you mean 'rope'"):
        checker(("load", "roep"))


def test_a_cable_that_is_only_drawn_keeps_its_row_and_collides_with_nothing() -> None:
    drawn = CableGeometry("drawn", 0.5, collides=False)
    wall = box_obstacle("wall", (1, 1, 1))
    checker = CollisionChecker([], World((wall,)), cables=[drawn, ROPE])
    through, beside = [-2, 0, 0, 2, 0, 0], [-2, 0, 3, 2, 0, 3]
    assert not checker.collides(NOBODY, np.array([through, beside], dtype=float))
    assert checker.contacts(NOBODY, np.array([beside, through], dtype=float)) == [
        Contact("rope", "wall", "touches")
    ]


def test_forgetting_the_ends_is_an_error_and_never_free() -> None:
    checker = checker_for(box_obstacle("wall", (1, 1, 1)))
    for judge in (checker.collides, checker.contacts, checker.clearance):
        with pytest.raises(InputError, match="the ends of 1 cables are needed, not 0 numbers"):
            judge(NOBODY)
    with pytest.raises(InputError, match="1 cables are needed in each of 2 poses, not 0 numbers"):
        checker.first_collision(np.zeros((2, 0, 12)))


def test_the_first_of_many_places_of_a_cable_that_collides_is_found() -> None:
    checker = checker_for(box_obstacle("wall", (1, 1, 1)))
    heights = (2.0, 0.6 + ROPE.radius, 0.5, 0.0)
    ends = np.array([[[-2, 0, z, 2, 0, z]] for z in heights])
    assert checker.first_collision(np.zeros((4, 0, 12)), ends) == 2
    assert checker.first_collision(np.zeros((2, 0, 12)), ends[:2]) is None

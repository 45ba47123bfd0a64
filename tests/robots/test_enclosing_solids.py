"""Solids around a mesh contain all of it, and follow its shape where that is worth it."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import trimesh

from kinolab.dynamics.language.shapes import Box
from kinolab.numerics.arrays import Array
from kinolab.robots.solids.enclosing_solids import enclosing_solids
from kinolab.robots.solids.interior_points import interior_points
from kinolab.robots.solids.overhang import overhang
from kinolab.robots.tree.kinematic_tree import PlacedShape
from tests.robots.test_enclosing import outside


def corners_of(*parts: trimesh.Trimesh) -> Array:
    """Return the triangles (n, 3, 3) of meshes."""
    return np.concatenate([np.asarray(part.triangles) for part in parts])


def bar(*edges: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> trimesh.Trimesh:
    mesh = trimesh.creation.box(edges)
    mesh.apply_translation(at)
    return mesh


ELL = corners_of(bar(4.0, 1.0, 1.0, at=(2.0, 0.5, 0.5)), bar(1.0, 3.0, 1.0, at=(0.5, 2.5, 0.5)))
RING = corners_of(trimesh.creation.torus(5.0, 0.5))
WORM = corners_of(
    *(
        trimesh.creation.capsule(height=3.0, radius=0.4, count=[12, 12]).apply_transform(
            trimesh.transformations.compose_matrix(
                angles=(0.4 * k, math.pi / 2, 0.9 * k), translate=(2.0 * k, math.sin(k), 0.0)
            )
        )
        for k in range(6)
    )
)
MESHES = {"ell": ELL, "ring": RING, "worm": WORM}


def solids_of(triangles: Array) -> list[PlacedShape]:
    return enclosing_solids(triangles, interior_points(triangles), padding=0.1)


@cache
def solids_around(name: str) -> list[PlacedShape]:
    return solids_of(MESHES[name])


def points_on(triangles: Array, count: int = 4000) -> Array:
    """Return points at random on triangles."""
    random = np.random.default_rng(0)
    weights = random.dirichlet([1.0, 1.0, 1.0], count)
    return np.einsum("ni,nij->nj", weights, triangles[random.integers(len(triangles), size=count)])


@pytest.mark.parametrize("name", MESHES)
def test_every_point_of_a_mesh_is_in_a_solid(name: str) -> None:
    solids, points = solids_around(name), points_on(MESHES[name])
    assert 1 < len(solids) <= 24
    worst = [min(outside(solid, point[None].copy()) for solid in solids) for point in points]
    assert max(worst) < 1e-9


def test_an_angle_is_enclosed_exactly_by_two_boxes() -> None:
    """Its volume is 4 + 3 = 7."""
    solids = solids_around("ell")
    assert len(solids) == 2
    boxes = [solid.shape for solid in solids]
    volumes = [float(b.x) * float(b.y) * float(b.z) for b in boxes if isinstance(b, Box)]
    assert sum(volumes) == pytest.approx(7.0)
    assert overhang(ELL, interior_points(ELL), solids) < 0.1


def test_a_box_is_not_hollowed_out() -> None:
    block = corners_of(bar(5.0, 3.0, 2.0))
    (solid,) = solids_of(block)
    assert isinstance(solid.shape, Box)
    assert sorted(float(e) for e in (solid.shape.x, solid.shape.y, solid.shape.z)) == [
        2.0,
        3.0,
        5.0,
    ]


def test_a_ring_stays_open() -> None:
    """A point in its middle is in no solid; no single cut would save anything."""
    solids = solids_around("ring")
    assert min(outside(solid, np.zeros((1, 3))) for solid in solids) > 2.0


def test_few_solids_are_enough_where_few_are_wanted() -> None:
    assert len(enclosing_solids(WORM, interior_points(WORM), padding=0.1, most=3)) <= 3


@pytest.mark.parametrize("flat", [0, 1, 2])
def test_a_flat_mesh_is_enclosed(flat: int) -> None:
    sheet = ELL.copy()
    sheet[..., flat] = 0.0
    for solid in solids_of(sheet):
        assert outside(solid, solid.pose[None, :3, 3].copy()) < 0.0


def test_overhang_of_a_ball_in_a_box() -> None:
    """The corner of a cube is sqrt(3) - 1 radii away from the ball in it."""
    ball = corners_of(trimesh.creation.icosphere(subdivisions=4))
    cube = PlacedShape(Box(2.0, 2.0, 2.0), np.eye(4))
    reach = overhang(ball, interior_points(ball), [cube])
    assert reach == pytest.approx(math.sqrt(3.0) - 1.0, abs=0.03)


def test_points_inside_are_inside() -> None:
    """Of a cube they are all; of a ball as many as its share of the cube's volume, pi / 6."""
    cube, ball = corners_of(bar(2.0, 2.0, 2.0)), corners_of(trimesh.creation.icosphere(4))
    found = interior_points(ball)
    assert np.linalg.norm(found, axis=1).max() < 1.0
    assert len(found) / len(interior_points(cube)) == pytest.approx(math.pi / 6, rel=0.02)
    assert len(interior_points(cube)) == 16**3


def test_an_open_box_has_no_inside() -> None:
    lid = [k for k, n in enumerate(bar(2.0, 2.0, 2.0).face_normals) if n[2] > 0.5]
    open_box = np.delete(corners_of(bar(2.0, 2.0, 2.0)), lid, axis=0)
    assert len(interior_points(open_box)) == 0

"""Meshes with fewer triangles, and a proved bound on how far the old ones are from the new ones.

Quadric simplification says nothing about its error. Here every triangle that was there is covered
by points whose distances to the new surface are exact; these change no faster than points move.

Source: Garland, Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.shapes import Sphere
from kinolab.errors import printable
from kinolab.files import LOG
from kinolab.numerics.arrays import Array
from kinolab.store import Kind, pack_arrays, unpack_arrays
from kinolab.world.collision.checker import CollisionChecker
from kinolab.world.distances.distance_field import digest
from kinolab.world.meshes.mesh import merge_duplicates
from kinolab.world.meshes.mesh_components import components
from kinolab.world.meshes.mesh_reading import refusal
from kinolab.world.obstacles.obstacle import Obstacle
from kinolab.world.obstacles.world import World
from kinolab.world.shapes.shape_surfaces import Faces

BEAD = 1e-7  # [m] radius of the ball whose gap stands for a point's distance
BATCH = 100_000  # points at once

Simplified: TypeAlias = tuple[Array, Faces, float]  # vertices, faces, and the bound


def simplified(obstacle: Obstacle, count: int) -> Obstacle:
    """Return a mesh obstacle of about ``count`` triangles, with ``error`` as it is proved.

    Colours are lost. An obstacle that has no more triangles is returned as it is.

    Raises:
        InputError: If fast-simplification is absent, or a closed part does not stay closed.
    """
    if obstacle.primitive is not None or len(obstacle.faces) <= count:
        return obstacle
    where = obstacle.source.name if obstacle.source else obstacle.name
    vertices, faces, error = SIMPLIFIED.get(
        [digest([obstacle]), str(count)], lambda: _made(obstacle, where, count)
    )
    parts = components(vertices, faces)
    before = 0 if obstacle.parts is None else int((obstacle.parts.volume > 0).sum())
    if obstacle.solid and int((parts.volume > 0).sum()) != before:
        remedy = "Take more, or write solid = false: then only the surface collides."
        raise refusal(where, f"does not stay closed with {count} triangles.", remedy)
    if not obstacle.solid:
        parts = parts._replace(volume=np.minimum(parts.volume, 0.0))
    told = (
        f"{where}: simplified from {len(obstacle.faces)} to {len(faces)} triangles. None of it is "
        f"farther than {1000.0 * error:.3g} mm from these, which plans keep in addition."
    )
    return replace(
        obstacle,
        vertices=vertices,
        faces=faces,
        parts=parts,
        colors=None,
        warnings=(*obstacle.warnings, told),
        error=error,
    )


def largest_distance(vertices: Array, faces: Faces, surface: Obstacle) -> float:
    """Bound from above the distance in [m] of every point of triangles to a surface.

    Args:
        vertices, faces: Of the triangles, shapes (n, 3) in [m] and (m, 3).
        surface: A mesh, of which the triangles count and no inside.
    """
    at_vertices = _distances(vertices, surface)
    corners, far = vertices[faces], at_vertices[faces]
    seen, done = float(far.max()), 0.0
    for _ in range(6):  # rounds of triangles that are divided into four
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        # No point of a triangle is farther than this from the nearest of its corners.
        bound = far.max(axis=1) + edges / math.sqrt(3.0)
        # times the largest distance that was seen, at which a bound is good enough
        loose = bound > 1.2 * seen
        done = max(done, float(bound[~loose].max(initial=0.0)))
        if not loose.any():
            return done
        corners, far, inner = _divided(corners[loose], far[loose], surface)
        seen = max(seen, inner)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return max(done, float((far.max(axis=1) + edges / math.sqrt(3.0)).max(initial=0.0)))


def _divided(corners: Array, far: Array, surface: Obstacle) -> tuple[Array, Array, float]:
    """Divide triangles (m, 3, 3) into four; return them, their corners' distances, the largest."""
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))  # of the edges ab, bc, ca
    inner = _distances(middles.reshape(-1, 3), surface).reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = np.moveaxis(corners, 1, 0), np.moveaxis(middles, 1, 0)
    (da, db, dc), (dab, dbc, dca) = far.T, inner.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    known = [(da, dab, dca), (dab, db, dbc), (dca, dbc, dc), (dab, dbc, dca)]
    return (
        np.concatenate([np.stack(part, axis=1) for part in parts]),
        np.concatenate([np.stack(part, axis=1) for part in known]),
        float(inner.max(initial=0.0)),
    )


def _distances(points: Array, surface: Obstacle) -> Array:
    """Return upper bounds on the distances in [m] of points (n, 3) to the triangles of a mesh."""
    alone = replace(surface, solid=False, parts=None)
    checker = CollisionChecker([BodyGeometry("bead", (Sphere(BEAD),))], World((alone,)))
    found = np.empty(len(points))
    for first in range(0, len(points), BATCH):
        some = points[first : first + BATCH]
        poses = np.zeros((len(some), 1, 3, 4))
        poses[..., :3] = np.eye(3)
        poses[:, 0, :, 3] = some
        found[first : first + BATCH] = checker.clearances(poses)
    # Where the bead touches, or FCL thinks so, the point is within its margin.
    # [m] by which that gap may be too small
    return np.where(found > 0.0, found + BEAD + 2e-8, 1e-4)


def _unpack(content: memoryview) -> Simplified:
    vertices, faces, error = unpack_arrays(content, np.float64, np.int64, np.float64)
    return vertices, faces, float(error)


SIMPLIFIED: Kind[Simplified] = Kind(
    "simplified", pack_arrays, _unpack, (Path(__file__).parent,), most=2**28
)


def _made(obstacle: Obstacle, where: str, count: int) -> Simplified:
    if len(obstacle.faces) > 500_000:  # triangles that are simplified in 20 s
        many = len(obstacle.faces)
        told = "%s: simplifying %d triangles, once; it may take minutes."
        LOG.warning(told, printable(where), many)
    vertices, faces = fewer_triangles(where, obstacle.vertices, obstacle.faces, count)
    rough = replace(obstacle, vertices=vertices, faces=faces, parts=None, colors=None)
    return vertices, faces, largest_distance(obstacle.vertices, obstacle.faces, rough)


def fewer_triangles(where: str, vertices: Array, faces: Faces, count: int) -> tuple[Array, Faces]:
    """Return vertices and faces of about ``count`` triangles instead of many, at no known error.

    Args:
        where: What mistakes are reported for.
        vertices, faces: Shapes (n, 3) in [m] and (m, 3).
        count: Triangles that are left.

    Raises:
        InputError: If fast-simplification is absent, or nothing is left.
    """
    try:
        from fast_simplification import simplify  # late, and only where it is asked for
    except ImportError as error:
        what = "simplify needs fast-simplification, which is absent."
        remedy = "Install it by pip install 'kinolab[simplify]'."
        raise refusal(where, what, remedy) from error
    points = np.ascontiguousarray(vertices)
    made = simplify(points, np.ascontiguousarray(faces), target_count=count)
    vertices, faces, _ = merge_duplicates(
        np.asarray(made[0], dtype=np.float64), np.asarray(made[1], dtype=np.int64)
    )
    if not len(faces):
        raise refusal(where, f"has nothing left with {count} triangles.", "Take more.")
    return vertices, np.ascontiguousarray(faces)

"""Rotors: discs that spin too fast for a film, drawn as blades that turn slowly in a ring."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, join, weld
from kinolab.world.shapes.shape_surfaces import box_surface, cylinder_surface

if TYPE_CHECKING:
    from kinolab.dynamics.language.shapes import Shape

SEGMENTS = 48
RIM, CHORD, HUB = 0.975, 0.075, 0.06  # of the radius: the ring's inside, a blade's width, the hub's


def rotor(disk: Shape, color: Array) -> SurfaceMesh:
    """Two blades, a hub and a ring, coloured (r, g, b), for the disc about z that they sweep."""
    r, _, half = disk.lowered()[1][:3]
    parts = [
        weld(*box_surface(np.array([r, 0.5 * CHORD * r, half])), color),
        weld(*cylinder_surface(HUB * r, 1.5 * half, 16), color),
        _ring(RIM * r, r, half),
    ]
    mesh = join(parts)
    return mesh.moved(np.column_stack([np.eye(3), np.asarray(disk.at, dtype=np.float64)]))


def whirled(poses: Array, speeds: Sequence[float], delay: float) -> Array:
    """Turn bodies about their z axes from frame to frame.

    Args:
        poses: Of each frame, shape (nf, nb, 12).
        speeds: Of each body, in [rad/s] of film.
        delay: From one frame to the next, in [s] of film.
    """
    moved = poses.reshape(len(poses), -1, 3, 4).copy()
    for k, speed in enumerate(speeds):
        if speed:
            angle = speed * delay * np.arange(len(poses))
            c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
            x, y = moved[:, k, :, 0].copy(), moved[:, k, :, 1].copy()
            moved[:, k, :, 0], moved[:, k, :, 1] = c * x + s * y, c * y - s * x
    return moved.reshape(poses.shape)


def _ring(inner: float, outer: float, thickness: float) -> SurfaceMesh:
    angle = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    half, circle = 0.5 * thickness, np.stack([np.cos(angle), np.sin(angle)], axis=1)
    loops = [(outer, -half), (outer, half), (inner, half), (inner, -half)]  # turned about z
    points = [np.column_stack([r * circle, np.full(SEGMENTS, z)]) for r, z in loops]
    a = np.arange(SEGMENTS)
    b = (a + 1) % SEGMENTS
    faces = []
    for k in range(4):
        low, high = k * SEGMENTS, (k + 1) % 4 * SEGMENTS
        faces += [np.stack([a + low, b + low, b + high], axis=1)]
        faces += [np.stack([a + low, b + high, a + high], axis=1)]
    # The ring, which marks the blade tips, is pale.
    return weld(np.concatenate(points), np.concatenate(faces), np.array([0.86, 0.88, 0.90]))

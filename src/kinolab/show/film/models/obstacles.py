"""Obstacles as coloured surfaces: pieces in turn, a piece of rock in layers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.ball import Color
from kinolab.show.film.models.surface_mesh import SurfaceMesh, joined, weld

LAYERS = 2  # times that the colours of a single piece come, from its foot to its top
WAVES = 0.35  # of a layer's thickness: how far its border goes up and down
LEVEL = 0.72  # z of the normal of what is a floor and not a wall: it has the first colour


def painted(vertices: Array, faces: ArrayLike, colors: Sequence[Color]) -> SurfaceMesh:
    """An obstacle with its colours: one for all, or several.

    Of several colours the pieces of an obstacle take one each, in turn; an obstacle in one piece
    shows them as layers, one above the other.

    Args:
        vertices: Of the obstacle, shape (n, 3), in [m].
        faces: Three vertices each, shape (m, 3).
        colors: RGB in 0..1, at least one.
    """
    mesh = weld(vertices, faces, colors[0])
    if len(colors) == 1 or not len(mesh.faces):
        return mesh
    pieces = joined(len(mesh.faces), mesh.sides)
    if pieces.max() == 0:
        return mesh.painted(_layers(mesh, np.array(colors)))
    return mesh.painted(np.array(colors)[pieces % len(colors)])


def _layers(mesh: SurfaceMesh, colors: Array) -> Array:
    """Colours of the faces by height, with wavy borders; of what is level the first one."""
    corners = mesh.vertices[mesh.faces]
    middle = 0.5 * (corners.min(axis=1) + corners.max(axis=1))  # the two halves of a quad agree
    low, high = mesh.vertices[:, 2].min(), mesh.vertices[:, 2].max()
    thickness = max(float(high - low), 1e-9) / (LAYERS * len(colors))
    wave = np.sin(0.9 * middle[:, 0] / thickness) + np.sin(0.7 * middle[:, 1] / thickness + 1.0)
    height = (middle[:, 2] - low) / thickness + 0.5 * WAVES * wave
    layer = np.clip(np.floor(height), 0, None).astype(int) % len(colors)
    layer[mesh.normals[:, 2] > LEVEL] = 0
    return np.asarray(colors[layer])

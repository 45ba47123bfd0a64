"""Lighting: brightness of faces, and their shadows on the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.scene.camera import Camera

AMBIENT, FULL = 0.66, 1.06  # brightness of a face turned away from the lamp, and toward it
LIGHT_SAMPLES = 6  # one lamp, jittered: their shadows overlap to a soft edge
LIGHT_JITTER = 0.04  # [rad], half the apparent width of the lamp
SHADOW = np.array([0.74, 0.76, 0.80])  # of the ground's colour in full shadow


def main_light(camera: Camera, up: Array) -> Array:
    """The direction (3,) toward the light: above, to the viewer's left and to the front."""
    right = camera.axes[0]
    direction = up - 0.45 * right + 0.40 * np.cross(right, up)
    return np.asarray(direction / np.linalg.norm(direction))


def light_samples(light: Array) -> Array:
    """Directions toward the corners of a small lamp, shape (LIGHT_SAMPLES, 3)."""
    a = np.cross(light, (0.3, 0.5, 0.8))
    a /= np.linalg.norm(a)
    b = np.cross(light, a)
    turn = 2.0 * np.pi * (np.arange(LIGHT_SAMPLES)[:, None] + 0.5) / LIGHT_SAMPLES
    return np.asarray(light + LIGHT_JITTER * (np.cos(turn) * a + np.sin(turn) * b))


def shade(
    colors: Array, normals: Array, light: Array, ambient: float = AMBIENT
) -> NDArray[np.uint8]:
    """Lambert's law with ambient light, RGB in 0..255, shape (..., m, 3).

    The colours, RGB in 0..1, are of shape (m, 3), the normals to the viewer of shape (..., m, 3).
    """
    brightness = ambient + (FULL - ambient) * np.clip(normals @ light, 0.0, None)
    return np.clip(255.0 * colors * brightness[..., None] + 0.5, 0.0, 255.0).astype(np.uint8)


def shadow_points(points: Array, toward: Array) -> Array:
    """Project points, shape (..., 3), along rays from a lamp onto the ground z = 0.

    Points below the ground are projected vertically. The directions toward lamps are of shape (3,),
    or of one that fits the points' by NumPy's rules.
    """
    height = np.clip(points[..., 2:], 0.0, None)
    fallen = points - height / toward[..., 2:] * toward
    fallen[..., 2] = 0.0
    return fallen

"""Solids that enclose the points of a mesh: the smallest box or capsule along its principal axes.

A robot's mesh has thousands of triangles; a solid around it is never too small, and its distance
to obstacles is known in closed form.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from kinolab.dynamics.language.shapes import Box, Capsule, ShapeKind
from kinolab.numerics.arrays import Array
from kinolab.robots.tree.constant_frames import onto_z
from kinolab.robots.tree.kinematic_tree import PlacedShape, pose_of

LEAST_EDGE = 1e-4  # [m] of a box around a flat mesh


def enclosing_shape(points: Array) -> PlacedShape:
    """Return the smaller one of a box and a capsule around points (n, 3) in [m]."""
    own = np.eye(3)
    for turn in (principal_axes(points), np.eye(3)):
        if _box_volume(points @ turn) <= 0.98 * _box_volume(points @ own):
            own = turn
    box = _box(points, own)
    long = own[:, int(np.ptp(points @ own, axis=0).argmax())]
    capsule = _capsule(points, onto_z(long))
    found = min(box, capsule, key=volume)
    return replace(found, enclosed=(points - found.pose[:3, 3]) @ found.pose[:3, :3])


def principal_axes(points: Array) -> Array:
    """Return the principal axes of points (n, 3) as columns of a rotation matrix (3, 3)."""
    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2].T
    return axes if np.linalg.det(axes) > 0 else axes * [1.0, 1.0, -1.0]


def _box_volume(points: Array) -> float:
    return float(np.maximum(np.ptp(points, axis=0), LEAST_EDGE).prod())


def _box(points: Array, turn: Array) -> PlacedShape:
    own = points @ turn
    low, high = own.min(axis=0), own.max(axis=0)
    sizes = np.maximum(high - low, LEAST_EDGE).tolist()
    return PlacedShape(Box(*sizes), pose_of(turn @ (low + high) / 2, turn))


def _capsule(points: Array, turn: Array) -> PlacedShape:
    """Return a capsule along the z axis of a rotation (3, 3) around points (n, 3)."""
    own = points @ turn
    middle = (own.min(axis=0) + own.max(axis=0)) / 2
    off = own - middle
    around = np.hypot(off[:, 0], off[:, 1])
    radius = max(float(around.max()), LEAST_EDGE)
    caps = np.sqrt(np.maximum(radius**2 - around**2, 0.0))  # what a cap adds at that distance
    top, bottom = float((off[:, 2] - caps).max()), float((off[:, 2] + caps).min())
    long = max(top - bottom, 0.0)
    middle[2] += (top + bottom) / 2 if top > bottom else 0.0
    if not long:  # a ball: it must reach the farthest point
        radius = float(np.linalg.norm(own - middle, axis=1).max())
    return PlacedShape(Capsule(radius, max(long, LEAST_EDGE)), pose_of(turn @ middle, turn))


def volume(solid: PlacedShape) -> float:
    """Return the volume of a box or capsule in [m^3]."""
    kind, (x, y, z) = solid.shape.lowered()
    return 8.0 * x * y * z if kind is ShapeKind.BOX else math.pi * x**2 * (2.0 * z + 4 / 3 * x)

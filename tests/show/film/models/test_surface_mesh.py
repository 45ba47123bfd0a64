"""Edges that are drawn: those of the form, and not those of a scan's noise."""

from __future__ import annotations

import numpy as np
import trimesh

from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.surface_mesh import MANY, weld

GREY = (0.7, 0.7, 0.7)


def drawn(vertices: Array, faces: Array) -> Array:
    """Middles of the edges that are drawn, shape (n, 3)."""
    mesh = weld(vertices, faces, GREY)
    return mesh.vertices[mesh.ends[mesh.creases]].mean(axis=1)


def terrace(noise: float) -> tuple[Array, Array]:
    """A square of 10 m x 10 m, one half 2 m above the other, measured every 0.1 m."""
    side = np.linspace(0.0, 10.0, 101)
    x, y = np.meshgrid(side, side, indexing="ij")
    z = np.where(x > 5.05, 2.0, 0.0)
    z = z + noise * np.random.default_rng(0).standard_normal(x.shape)
    index = np.arange(101 * 101).reshape(101, 101)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return np.stack([x, y, z], -1).reshape(-1, 3), faces


def test_the_noise_of_a_scan_is_not_drawn_and_its_steps_are() -> None:
    found = drawn(*terrace(0.015))
    inside = found[(np.abs(found[:, :2] - 5.0) < 4.99).all(axis=1)]
    at_the_step = np.abs(inside[:, 0] - 5.05) < 0.1
    assert at_the_step.mean() > 0.95
    assert np.ptp(inside[at_the_step, 1]) > 9.0


def test_without_noise_the_same_edges_are_drawn() -> None:
    found = drawn(*terrace(0.0))
    inside = found[(np.abs(found[:, :2] - 5.0) < 4.99).all(axis=1)]
    assert len(inside) >= 2 * 98  # above and below the step
    assert (np.abs(inside[:, 0] - 5.05) < 0.1).all()


def test_a_form_of_many_faces_keeps_all_of_its_edges() -> None:
    box = trimesh.creation.box()
    for _ in range(4):
        box = box.subdivide()
    assert len(box.faces) > MANY
    found = np.abs(drawn(box.vertices, box.faces))
    assert len(found) == 12 * 16
    assert ((found > 0.4999).sum(axis=1) == 2).all()

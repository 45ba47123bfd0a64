"""A rotor as it is drawn: blades, a hub and a ring, all seen from outside."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from kinolab.dynamics import Disk
from kinolab.show.scene.models.rotor import CHORD, HUB, RIM, SEGMENTS, rotor

R, H = 2.0, 0.2  # [m]


def polygon(sides: int, radius: float) -> float:
    return sides / 2 * math.sin(2 * math.pi / sides) * radius**2


def test_a_rotor_is_made_of_closed_solids_whose_faces_look_outward() -> None:
    """The solids' volumes count as negative where they are seen from inside."""
    drawn = rotor(Disk(R, H, at=(1.0, 2.0, 3.0)), np.array([0.2, 0.3, 0.4]))
    whole = trimesh.Trimesh(drawn.vertices, drawn.faces, process=False)
    parts = whole.split(only_watertight=True, repair=False)
    expected = [
        polygon(16, HUB * R) * 1.5 * H,
        (polygon(SEGMENTS, R) - polygon(SEGMENTS, RIM * R)) * 0.5 * H,
        2 * R * CHORD * R * H,
    ]
    assert sorted(part.volume for part in parts) == pytest.approx(sorted(expected), rel=1e-6)
    np.testing.assert_allclose([part.bounds.mean(axis=0) for part in parts], [[1.0, 2.0, 3.0]] * 3)

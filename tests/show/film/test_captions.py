"""Words stand on what they name."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import trimesh

from kinolab.show.scene.captions import captions
from kinolab.show.scene.models.surface_mesh import weld
from kinolab.show.scene.picture import Ghost


def test_a_machine_s_word_stands_on_the_middle_of_its_upper_side() -> None:
    box = trimesh.creation.box(extents=(0.2, 0.4, 0.6))
    mesh = weld(np.asarray(box.vertices), np.asarray(box.faces), (0.5, 0.5, 0.5))
    pose = np.hstack([np.eye(3), [[3.0], [4.0], [5.0]]]).ravel()
    start = Ghost(pose[None])
    picture: Any = SimpleNamespace(
        start=start, goal=None, points=(), cones=(), up=(0, 0, 1), others=()
    )
    still: Any = SimpleNamespace(picture=picture, machine=[mesh], size=10.0)
    (word,) = captions(still)
    assert word.text == "start"
    assert word.place == pytest.approx((3.0, 4.0, 5.3))

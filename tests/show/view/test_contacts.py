"""What a driven machine touches: closed forms of distances from a box, in the page's JavaScript."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

from kinolab.show.page.bundle import bundle
from kinolab.world.obstacles.obstacle import box_obstacle

MODULES = files("kinolab.show.page").joinpath("drive")
BOX = box_obstacle("box", (2.0, 2.0, 2.0))  # from -1 to 1 along each axis
EYE = np.eye(3)
HALF = np.sqrt(0.5)
SLANTED = np.array([[HALF, -HALF, 0.0], [HALF, HALF, 0.0], [0.0, 0.0, 1.0]])  # 45 degrees about z

BALL = {"kind": "sphere", "axis": None, "size": {"radius": 0.5}, "at": [0, 0, 0]}
CUBE = {"kind": "box", "axis": None, "size": {"x": 1.0, "y": 1.0, "z": 1.0}, "at": [0, 0, 0]}
ROD = {"kind": "cylinder", "axis": "x", "size": {"radius": 0.2, "length": 2.0}, "at": [0, 0, 0]}
PILL = {"kind": "capsule", "axis": "z", "size": {"radius": 0.2, "length": 1.0}, "at": [0, 0, 0.5]}
TIPS = [[0.5, 0, 0], [-0.5, 0, 0], [0, 0.3, 0], [0, -0.3, 0], [0, 0, 0.2], [0, 0, -0.2]]
GEM = {"kind": "hull", "axis": "z", "size": {"corners": TIPS}, "at": [0.1, 0, 0]}

# Shape, its rotation, a direction from the box, and at which distance along it they part.
CASES = [
    ("a ball at a face", BALL, EYE, (1.0, 0.0, 0.0), 1.5),
    ("a ball at an edge", BALL, EYE, (HALF, HALF, 0.0), np.sqrt(2.0) + 0.5),
    ("a ball at a corner", BALL, EYE, (1 / np.sqrt(3),) * 3, np.sqrt(3.0) + 0.5),
    ("a cube at a face", CUBE, EYE, (0.0, 1.0, 0.0), 1.5),
    ("a cube that stands on its edge", CUBE, SLANTED, (1.0, 0.0, 0.0), 1.0 + HALF),
    ("a rod by its end", ROD, EYE, (1.0, 0.0, 0.0), 2.0),
    ("a rod by its side", ROD, EYE, (0.0, 0.0, 1.0), 1.2),
    ("a capsule that begins at its origin", PILL, EYE, (0.0, 0.0, 1.0), 1.2),
    ("a gem at its nearer tip", GEM, EYE, (1.0, 0.0, 0.0), 1.4),
    ("a gem at its farther tip", GEM, EYE, (-1.0, 0.0, 0.0), 1.6),
    ("a capsule from below", PILL, EYE, (0.0, 0.0, -1.0), 2.2),
]


@pytest.fixture(scope="module")
def engine() -> Iterator[Any]:
    MiniRacer = pytest.importorskip("py_mini_racer").MiniRacer
    sources = {
        entry.name.removesuffix(".js"): entry.read_text()
        for entry in MODULES.iterdir()
        if entry.name in ("contacts.js", "overlap.js")
    }
    context = MiniRacer()
    mesh = {"vertices": BOX.vertices.ravel().tolist(), "faces": BOX.faces.ravel().tolist()}
    context.eval(bundle(sources, "contacts"))
    obstacles = json.dumps([{"mesh": mesh}])
    context.eval(f"const contacts = module_contacts.buildContacts({obstacles}, (a) => a)")
    yield context
    context.close()


def touches(engine: Any, shape: dict[str, Any], turn: np.ndarray, place: np.ndarray) -> bool:
    pose = np.column_stack([turn, place]).ravel().tolist()
    asked = f"JSON.stringify(contacts.touching({json.dumps(pose)}, [[{json.dumps(shape)}]]))"
    found = json.loads(engine.eval(asked))
    assert found in ([], [[0, 0]])
    return bool(found)


@pytest.mark.parametrize("case", CASES, ids=[case[0] for case in CASES])
def test_things_touch_up_to_their_distance(engine: Any, case: Any) -> None:
    _, shape, turn, direction, distance = case
    away = np.asarray(direction)
    assert touches(engine, shape, turn, away * (distance - 1e-3))
    assert not touches(engine, shape, turn, away * (distance + 1e-3))


def test_far_away_nothing_touches_and_no_pair_is_told_twice(engine: Any) -> None:
    assert not touches(engine, BALL, EYE, np.array([30.0, -20.0, 5.0]))
    assert touches(engine, BALL, EYE, np.array([1.0, 1.0, 1.0]))  # three faces at once

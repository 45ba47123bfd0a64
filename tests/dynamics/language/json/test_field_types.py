"""Values from a file against the annotations of the records they are for."""

from typing import Any

import pytest
import sympy as sp

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Force,
    Gravity,
    Potential,
    Sphere,
    length,
    move,
)
from kinolab.dynamics.language.frames import Rotation
from kinolab.dynamics.language.json.field_types import check_fields

BODY = Body("b", move(length("x")), mass=1)

GOOD: list[tuple[type, dict[str, Any]]] = [
    (Sphere, {"radius": 1, "at": (0.0, 0, sp.pi)}),
    (Box, {"x": 0.1, "y": sp.Integer(2), "z": 1.0}),
    (Force, {"name": "F", "on": BODY, "along": WORLD.x, "limit": 2, "reacts_on": None}),
    (Force, {"limit": (-1.0, 2)}),
    (Rotation, {"axis": "y", "angle": sp.Integer(1)}),
    (Gravity, {"down": (0.0, 0.0, -1)}),
]
BAD: list[tuple[type, dict[str, Any]]] = [
    (Sphere, {"radius": "1"}),
    (Sphere, {"radius": True}),
    (Sphere, {"at": (0.0, 0.0)}),
    (Sphere, {"at": 0.0}),
    (Force, {"on": "b"}),
    (Force, {"on": None}),
    (Force, {"along": WORLD}),
    (Force, {"limit": (1.0, 2.0, 3.0)}),
    (Rotation, {"axis": "w"}),
    (Potential, {"energy": None}),
    (Gravity, {"down": ("0", "0", "-1")}),
]


@pytest.mark.parametrize(("kind", "values"), GOOD)
def test_what_was_declared_passes(kind: type, values: dict[str, Any]) -> None:
    check_fields(kind, values)


@pytest.mark.parametrize(("kind", "values"), BAD)
def test_anything_else_is_a_type_error_that_names_the_field(
    kind: type, values: dict[str, Any]
) -> None:
    (field,) = values
    with pytest.raises(TypeError, match=f"{field} of a {kind.__name__} is "):
        check_fields(kind, values)

"""Moments of inertia that no body has, because one is more than the sum of the others.

Files from CAD programs have them where numbers are rounded or masses were guessed. MuJoCo refuses
such a file, too, unless its ``balanceinertia`` gives every axis the mean of the three.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from kinolab.dynamics.language.validation import TRIANGLE_TOLERANCE
from kinolab.errors import printable
from kinolab.numerics.arrays import Array

OFF_DIAGONAL = ("ixy", "ixz", "iyz")
DIAGONAL = ("ixx", "iyy", "izz")


def breaks_triangle(inertia: Array) -> bool:
    """Whether a moment of an inertia (3, 3), of which none is negative, exceeds the other two."""
    a, b, c = np.linalg.eigvalsh(inertia).tolist()
    rounding = TRIANGLE_TOLERANCE * c
    return bool(a >= -rounding and a + b < c - rounding)


def moments(inertia: Array) -> str:
    """Return the principal moments of an inertia (3, 3) in words."""
    a, b, c = np.linalg.eigvalsh(inertia).tolist()
    return f"{a:.4g}, {b:.4g} and {c:.4g} kg m^2"


def balanced(document: Any) -> Iterator[str]:
    """Give all axes the mean moment where ``breaks_triangle``, and yield what was done, in words.

    Args:
        document: A URDF file of lxml, which is changed.
    """
    for link in document.iterchildren("link"):
        for entry in link.iterfind("inertial/inertia"):
            xx, yy, zz, xy, xz, yz = (
                float(entry.get(name, "0")) for name in (*DIAGONAL, *OFF_DIAGONAL)
            )
            inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            if not breaks_triangle(inertia):
                continue
            mean = (xx + yy + zz) / 3.0
            for name in DIAGONAL:
                entry.set(name, repr(mean))
            for name in OFF_DIAGONAL:
                entry.set(name, "0")
            name, given = printable(link.get("name", "")), moments(inertia)
            yield f"the inertia of {name} is balanced: {given} became {mean:.4g} about every axis."

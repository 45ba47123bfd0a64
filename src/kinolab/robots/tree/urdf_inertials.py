"""Inertias in the document of a URDF file: those that no body has, and those that are left out.

Where numbers are rounded or masses were guessed, as in files from CAD programs, a moment may be
more than the sum of the others. MuJoCo refuses such a file, too, unless its ``balanceinertia``
gives every axis the mean of the three.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from kinolab.dynamics.language.validation import TRIANGLE_TOLERANCE
from kinolab.errors import printable
from kinolab.numerics.arrays import Array
from kinolab.robots.tree.joint_inertia import six
from kinolab.robots.tree.kinematic_tree import Link

ENTRIES = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


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
            xx, yy, zz, xy, xz, yz = (float(entry.get(name, "0")) for name in ENTRIES)
            inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            if not breaks_triangle(inertia):
                continue
            mean = (xx + yy + zz) / 3.0
            for k, name in enumerate(ENTRIES):
                entry.set(name, repr(mean) if k < 3 else "0")
            name, given = printable(link.get("name", "")), moments(inertia)
            yield f"the inertia of {name} is balanced: {given} became {mean:.4g} about every axis."


def write_inertials(xml: Any, document: Any, links: Sequence[Link]) -> None:
    """Write the mass properties of links into a document of lxml, which is changed.

    Other engines, with which a robot is compared, read the document.

    Args:
        links: Those of its links that have others than it says.
    """
    elements = {element.get("name"): element for element in document.iterchildren("link")}
    for link in links:
        if link.inertial is None:
            continue
        element, own = elements[link.name], link.inertial
        for said in element.findall("inertial"):
            element.remove(said)
        inertial = xml.SubElement(element, "inertial")
        xml.SubElement(inertial, "origin", xyz=" ".join(map(repr, map(float, own.centre))))
        xml.SubElement(inertial, "mass", value=repr(own.mass))
        moments = zip(ENTRIES, map(repr, six(own.inertia)), strict=True)
        xml.SubElement(inertial, "inertia", dict(moments))

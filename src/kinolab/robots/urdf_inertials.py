"""Inertias of links that a URDF file says nothing of, written into its document.

Other engines, with which a robot is compared, read the document.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from kinolab.robots.joint_inertia import six
from kinolab.robots.kinematic_tree import Link

ENTRIES = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def write_inertials(xml: Any, document: Any, links: Sequence[Link]) -> None:
    """Write the mass properties of links into a document of lxml, which is changed.

    Args:
        xml: The library lxml.etree.
        document: The file.
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

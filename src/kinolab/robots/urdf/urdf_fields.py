"""What of a URDF file is read; a word that is nearly one of these is a mistake, others are told.

Source: the specification at wiki.ros.org/urdf/XML.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from typing import Any

from kinolab.errors import Mistake, printable


def _words_of(table: str) -> dict[str, tuple[frozenset[str], frozenset[str]]]:
    """Return attributes and children of elements, from lines ``element: attributes / children``."""
    found = {}
    for line in table.strip().splitlines():
        element, _, words = line.partition(":")
        attributes, _, children = words.partition("/")
        found[element.strip()] = frozenset(attributes.split()), frozenset(children.split())
    return found


READ: Mapping[str, tuple[frozenset[str], frozenset[str]]] = _words_of("""
    link: name / inertial visual collision
    inertial: / origin mass inertia
    origin: xyz rpy
    mass: value
    inertia: ixx ixy ixz iyy iyz izz
    visual: name / origin geometry material
    collision: name / origin geometry
    geometry: / box cylinder sphere mesh
    box: size
    cylinder: radius length
    sphere: radius
    mesh: filename scale
    material: name / color texture
    color: rgba
    texture: filename
    joint: name type / origin parent child axis calibration dynamics limit mimic safety_controller
    parent: link
    child: link
    axis: xyz
    calibration: rising falling reference_position
    dynamics: damping friction
    limit: lower upper effort velocity
    mimic: joint multiplier offset
    safety_controller: soft_lower_limit soft_upper_limit k_position k_velocity
""")
# What docs/tools.md says is left out: of controllers, sensors and simulators.
OF_OTHERS = {"transmission", "gazebo", "sensor", "material", "mujoco", "plugin"}


def unread_words(document: Any, where: str) -> tuple[list[Mistake], list[str]]:
    """Return the mistakes in a file's words, and what of it is left out, such as ``<a> of b``.

    Args:
        document: The file, as lxml reads it.
        where: What mistakes are reported for.
    """
    mistakes: list[Mistake] = []
    left_out: dict[str, list[str]] = {}
    for part in document.iterchildren("*"):
        name = printable(str(part.get("name", "")))
        if part.tag in ("link", "joint"):
            for words, known, there, element in _unknown(part):
                for word in words:
                    meant = difflib.get_close_matches(word, known - there, n=1)  # its own cutoff
                    place = f"<{element.tag}>" if element is not part else part.tag
                    shown = printable(word)
                    if meant:
                        what = f"{place} has {shown!r}, which is not a word of URDF."
                        at = f"{where} {part.tag} {name!r}"
                        mistakes.append(Mistake(at, what, f'Did you mean "{meant[0]}"?'))
                    else:
                        left_out.setdefault(f"{shown} of {place}", []).append(name)
        elif _is_plain(part.tag) and part.tag not in OF_OTHERS:
            left_out.setdefault(f"<{printable(part.tag)}>", []).append(name)
    return mistakes, [
        f"{what} ({names[0]}{f' and {len(names) - 1} more' if names[1:] else ''})"
        for what, names in left_out.items()
    ]


def _unknown(part: Any) -> Iterator[tuple[list[str], frozenset[str], set[str], Any]]:
    """Yield unknown attributes, and unknown children, of each element that is known.

    With them come the words that are known there, those of them that are there, and the element.
    Words with a namespace are other programs'.
    """
    for element in part.iter("*"):
        inside = element is part or element.getparent().tag in READ
        if element.tag not in READ or not inside:
            continue
        attributes, children = READ[element.tag]
        given = [word for word in element.attrib if _is_plain(word)]
        below = [child.tag for child in element.iterchildren("*") if _is_plain(child.tag)]
        for words, known in ((given, attributes), (below, children)):
            if strange := [word for word in dict.fromkeys(words) if word not in known]:
                yield strange, known, set(words), element


def _is_plain(word: Any) -> bool:
    return isinstance(word, str) and not word.startswith("{")

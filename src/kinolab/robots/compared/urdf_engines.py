"""Which engines read a URDF file, too: MuJoCo, and Pinocchio where it is installed.

Shapes are taken out of what they read, since meshes have no part in how a robot moves. MuJoCo
demands more of a file than kinolab does, such as moments of inertia of which none is larger than
the sum of the others; a file that it refuses is compared with Pinocchio's model alone, if at all.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import numpy as np

from kinolab.robots.compared.mujoco_engine import MujocoEngine, quiet
from kinolab.robots.compared.pinocchio_engine import PinocchioEngine
from kinolab.robots.compared.second_engine import AbstractSecondEngine

STDERR = 2
BASE = "base"  # the joint of a root that moves freely
# [kg] and [kg m^2] of what has none: the least that MuJoCo takes, which is none again afterwards
LEAST = 2e-15
READING = {
    "fusestatic": "false",
    "inertiafromgeom": "false",
    "boundmass": str(LEAST),
    "boundinertia": str(LEAST),
}


def urdf_engines(xml: Any, document: Any, *, floating: bool) -> Iterator[AbstractSecondEngine]:
    """Yield the engines that read a file.

    Args:
        document: The file, which is changed.
        floating: Whether the root moves freely.
    """
    kinds = {joint.get("type") for joint in document.iter("joint")}
    if "planar" in kinds:  # by which every reader means something else
        return
    for link in document.iter("link"):
        for shape in link.findall("visual") + link.findall("collision"):
            link.remove(shape)
    for part in list(document):
        if part.tag not in ("link", "joint"):
            document.remove(part)
    if in_pinocchio := _in_pinocchio(xml, document, floating=floating):
        yield in_pinocchio
    if "floating" in kinds:  # which MuJoCo knows in the world alone
        return
    if in_mujoco := _in_mujoco(xml, document, floating=floating):
        yield in_mujoco


def _library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        return None


def _in_pinocchio(xml: Any, document: Any, *, floating: bool) -> PinocchioEngine | None:
    """Return Pinocchio's model, None where it is not installed or refuses the file."""
    pinocchio = _library("pinocchio")
    if not hasattr(pinocchio, "buildModelFromXML"):  # a package of tests has the same name
        return None
    text = xml.tostring(document, encoding="unicode")
    with _unheard():
        try:
            return PinocchioEngine(pinocchio, text, BASE if floating else None)
        except Exception:  # of several kinds
            return None


@contextmanager
def _unheard() -> Iterator[None]:
    """Keep off stderr what native code says inside, such as urdfdom of a file that it refuses."""
    sys.stderr.flush()
    kept = os.dup(STDERR)
    try:
        with open(os.devnull, "wb") as nothing:
            os.dup2(nothing.fileno(), STDERR)
        yield
    finally:
        os.dup2(kept, STDERR)
        os.close(kept)


def _in_mujoco(xml: Any, document: Any, *, floating: bool) -> MujocoEngine | None:
    """Return MuJoCo's model, None where it is not installed or refuses the file."""
    mujoco = _library("mujoco")
    if mujoco is None:
        return None
    xml.SubElement(xml.SubElement(document, "mujoco"), "compiler", READING)
    if floating:
        children = {child.get("link") for child in document.iter("child")}
        root = next(one for one in document.iter("link") if one.get("name") not in children)
        joint = xml.SubElement(document, "joint", name=BASE, type="floating")
        xml.SubElement(document, "link", name="world")  # as MuJoCo calls it
        xml.SubElement(joint, "parent", link="world")
        xml.SubElement(joint, "child", link=root.get("name"))
    with quiet(mujoco):
        try:
            model = mujoco.MjModel.from_xml_string(xml.tostring(document, encoding="unicode"))
        except Exception:  # of its compiler, of several kinds
            return None
    joints = range(model.njnt)
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, k) for k in joints]
    least, massless = model.body_inertia <= LEAST, model.body_mass <= LEAST
    model.body_inertia[least], model.body_mass[massless] = 0.0, 0.0
    engine = MujocoEngine(mujoco, model, names)
    engine.neglected = LEAST * np.count_nonzero(least)  # such as a point's, or a mote's
    return engine

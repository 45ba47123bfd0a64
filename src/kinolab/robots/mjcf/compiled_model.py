"""A model as MuJoCo compiles it from a file, and what of it cannot be represented."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import ParseError, iterparse, parse

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.files import is_file
from kinolab.lazy import library_of
from kinolab.numerics.arrays import Array
from kinolab.robots.compared.mujoco_engine import MujocoEngine, quiet
from kinolab.robots.mjcf.mjcf_fields import apply_flags, disabled, not_finite
from kinolab.untrusted import refuse_large, refuse_many

WORLD_BODY = 0


class CompiledModel:
    """MuJoCo's model of a file, whose flags have been applied.

    Attributes:
        path: The file.
        mujoco: The library.
        model: Its model.
        bodies, joints, geoms: Their names; those without are numbered.
        left_out: What cannot be represented.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.left_out = path, list[Mistake]()
        self.mujoco: Any = library_of("robots", "mujoco", "MJCF files are read by MuJoCo")
        self.model: Any = _compiled(self.mujoco, path)
        self.bodies = self.names("BODY", self.model.nbody, "body")
        self.joints = self.names("JOINT", self.model.njnt, "joint")
        self.geoms = self.names("GEOM", self.model.ngeom, "geom")
        off = disabled(self.mujoco, self.model)
        self._original = copy(self.model) if off else self.model  # with its flags
        apply_flags(self.mujoco, self.model)
        if broken := [Mistake(path.name, what) for what in not_finite(self.mujoco, self.model)]:
            raise InputError(broken)

    def names(self, kind: str, count: int, word: str) -> list[str]:
        """Return the names of elements of a type such as ``"JOINT"``; others are numbered."""
        of_kind = getattr(self.mujoco.mjtObj, f"mjOBJ_{kind}")
        found = [self.mujoco.mj_id2name(self.model, of_kind, k) for k in range(count)]
        return [name or f"{word}_{k + 1}" for k, name in enumerate(found)]

    def cannot(self, what: str, remedy: str = "") -> None:
        """Keep in mind what cannot be represented, and what would work."""
        self.left_out.append(Mistake(self.path.name, what, remedy))

    def turn(self, quaternion: Array) -> Array:
        """Return the rotation matrix (3, 3) of a quaternion w, x, y, z."""
        turn = np.zeros(9)
        self.mujoco.mju_quat2Mat(turn, quaternion)
        return turn.reshape(3, 3)

    def powers(self, name: str, k: int) -> tuple[float, ...]:
        """Return a field of an element, with the coefficients of higher powers where it has those.

        It is empty where this MuJoCo does not have the field yet.
        """
        fields = (getattr(self.model, one, None) for one in (name, f"{name}poly"))
        return tuple(float(c) for rows in fields if rows is not None for c in np.ravel(rows[k]))

    def engines(self) -> Sequence[MujocoEngine]:
        """Return MuJoCo's own model of the file, once all of it is read and nothing left out."""
        if self.left_out:
            return ()
        return (MujocoEngine(self.mujoco, self._original, self.joints),)

    def content(self) -> bytes:
        """Return all of the file that MuJoCo compiled."""
        whole = np.empty(self.mujoco.mj_sizeModel(self._original), dtype=np.uint8)
        self.mujoco.mj_saveModel(self._original, None, whole)
        return whole.tobytes()


def _compiled(mujoco: Any, path: Path) -> Any:
    """Return MuJoCo's model of a file."""
    if not is_file(path):
        raise InputError([Mistake(str(path), "there is no such file.")])
    refuse_large(path.stat().st_size, "xml", path.name)
    if _first_element(path) == "robot":
        what = "it begins with <robot>, so that it is a URDF file."
        raise InputError([Mistake(path.name, what, "Give it a name that ends with .urdf.")])
    with quiet(mujoco):
        try:
            model = mujoco.MjModel.from_xml_path(str(path))
        except Exception as error:  # of its compiler, of several kinds
            raise InputError([Mistake(path.name, _why_not_read(path, error))]) from error
    refuse_many(model.nbody, "bodies", path.name)
    return model


def _why_not_read(path: Path, error: Exception) -> str:
    """Return why MuJoCo does not read a file; of one that is no XML, expat's words are plainer."""
    try:
        parse(path)
    except ParseError as broken:
        return f"it is not an XML file ({broken})."
    return f"MuJoCo does not read it ({' '.join(str(error).split())})."


def _first_element(path: Path) -> str:
    """Return the name of a file's first element; empty where it is no XML."""
    try:
        with path.open("rb") as file:
            return next(str(found.tag) for _, found in iterparse(file, events=["start"]))
    except (ParseError, StopIteration):
        return ""  # MuJoCo will say why

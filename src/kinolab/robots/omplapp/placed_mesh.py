"""Meshes where OMPL.app sees them: as assimp reads COLLADA, in its unit and with y up.

Other formats stay as they are. In OMPL.app, gravity acts along minus z all the same.

Source: assimp 5.4, code/AssetLib/Collada/ColladaLoader.cpp, InternReadFile; omplapp 1.7,
src/omplapp/geometry/RigidBodyGeometry.cpp.
"""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.robots.omplapp.vertex_mean import mean_in_collada, mean_of_triangles
from kinolab.untrusted import read
from kinolab.world.meshes.mesh import load_mesh
from kinolab.world.meshes.mesh_cache import Mesh
from kinolab.world.meshes.mesh_reading import AXES, refusal
from kinolab.world.obstacles.obstacle import UPRIGHT, rotation

COLLADA = ".dae"
# How assimp turns what stands upright, with z up, by the axis that is up in the file.
TURNED: dict[str, tuple[float, float, float]] = {
    "x": (-math.pi / 2, math.pi, 0.0),
    "y": (-math.pi / 2, 0.0, 0.0),
    "z": (-math.pi / 2, 0.0, 0.0),
}


class PlacedMesh:
    """A mesh file and where OMPL.app has it.

    Args:
        path: The file; a relative path is taken from ``root``.
        root: The folder that meshes may not leave.

    Raises:
        InputError: If it is not a sound mesh in that folder.
    """

    def __init__(self, path: str, root: Path) -> None:
        self._mesh: Mesh = load_mesh(path, root=root)
        self._path, self._root = path, root

    @property
    def count(self) -> int:
        """How many triangles it has."""
        return len(self._mesh.faces)

    @property
    def entry(self) -> dict[str, Any]:
        """The keys of an obstacle that is placed so."""
        home = self._root.resolve()
        inside = (home / self._path).resolve().relative_to(home)
        placed: dict[str, Any] = {"mesh": inside.as_posix()}
        if self._is_collada:
            up = self._up
            placed |= {"up": up, "rpy": list(TURNED[up])}
            if self._unit != 1.0:
                placed["scale"] = self._unit
        return placed

    @property
    def triangles(self) -> Array:
        """The corners of its triangles, shape (n, 3, 3), in [m]."""
        return (self._mesh.vertices @ self._linear.T)[self._mesh.faces]

    @cached_property
    def mean(self) -> Array:
        """The mean (3,) of its vertices in [m], which OMPL.app takes for a robot's centre.

        Raises:
            InputError: If they cannot be told apart.
        """
        if not self._is_collada:
            return mean_of_triangles(self.triangles)
        try:
            content = read(self._root / self._path, "mesh", self._path)
            mean: Array = self._linear @ mean_in_collada(content)
        except InputError:
            raise
        except Exception as error:  # pycollada raises whatever the bytes provoke
            what = f"has vertices that cannot be read ({type(error).__name__})."
            raise refusal(self._path, what, "Export it again.") from error
        if not np.isfinite(mean).all():
            raise refusal(self._path, "has a vertex that is not a finite number.")
        return mean

    @property
    def _is_collada(self) -> bool:
        return Path(self._path).suffix.lower() == COLLADA

    @property
    def _up(self) -> str:
        declared = int(self._mesh.declared[1])
        return AXES[declared] if declared >= 0 else "y"  # in COLLADA, of files that do not say

    @property
    def _unit(self) -> float:
        return float(self._mesh.declared[0]) or 1.0

    @property
    def _linear(self) -> Array:
        """What the file's coordinates are multiplied by, shape (3, 3)."""
        if not self._is_collada:
            return np.eye(3)
        up = self._up
        return np.asarray(self._unit * rotation(TURNED[up]) @ UPRIGHT[up])

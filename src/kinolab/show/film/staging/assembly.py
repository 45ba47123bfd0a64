"""The bodies of a machine as one mesh that is placed frame by frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, join


@dataclass(frozen=True, eq=False)
class Assembly:
    """A machine's bodies; what does not depend on their poses is joined once.

    Args:
        bodies: One mesh per body, in the body's frame.
        radii: Of its cables in [m], shape (nl,); no entries where they are not known.
    """

    bodies: Sequence[SurfaceMesh]
    radii: Array = field(default_factory=lambda: np.zeros(0))

    @cached_property
    def _joined(self) -> SurfaceMesh:
        return join(self.bodies)

    def placed(self, poses: Array) -> SurfaceMesh:
        """All bodies as one mesh, at poses [R | p] of shape (..., nb, 12)."""
        frames = np.moveaxis(poses.reshape(*poses.shape[:-1], 3, 4), -3, 0)
        moved = [
            body.vertices @ g[..., :3].swapaxes(-1, -2) + g[..., None, :, 3]
            for body, g in zip(self.bodies, frames, strict=True)
        ]
        nothing = np.zeros((*poses.shape[:-2], 0, 3))
        return replace(self._joined, vertices=np.concatenate([nothing, *moved], axis=-2))

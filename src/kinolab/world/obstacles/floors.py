"""The floor of a mesh: what the ground, z = 0, covers, so that it is support and no obstacle.

Nothing may sink into the ground. So nothing can meet what lies at or below it, but the wheels and
feet that rest on it: these would touch a floor at z = 0, and pass one a little below it all the way
with next to no room.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinolab.world.meshes.mesh_components import Components
from kinolab.world.obstacles.obstacle import Obstacle


def without_floor(obstacle: Obstacle) -> tuple[Obstacle | None, Obstacle | None]:
    """Divide an obstacle into what is met and the floor; None for a part that has nothing.

    A closed part keeps all of its faces where it reaches above the ground and something is filled:
    which side of them is solid would be lost.
    """
    if obstacle.primitive is not None or obstacle.parts is None:
        return obstacle, None
    label, volume = obstacle.parts
    # [m] above z = 0, as far as bodies that rest may sink in
    low = obstacle.vertices[obstacle.faces][:, :, 2].max(axis=1) <= 1e-6
    if not low.any():
        return obstacle, None
    above = np.bincount(label, weights=~low, minlength=len(volume)) > 0
    opened = volume <= 0.0 if not (volume > 0.0).any() else volume == 0.0
    floor = low & (opened | ~above)[label]
    if not floor.any():
        return obstacle, None
    name, told = f"{obstacle.name} floor", obstacle.warnings
    if floor.all():
        return None, _only(obstacle, floor, name, told)
    return _only(obstacle, ~floor, obstacle.name, told), _only(obstacle, floor, name)


def _only(
    obstacle: Obstacle, rows: NDArray[np.bool_], name: str, warnings: tuple[str, ...] = ()
) -> Obstacle:
    """Return an obstacle of some of the faces, and of the vertices that these use."""
    assert obstacle.parts is not None
    used, faces = np.unique(obstacle.faces[rows], return_inverse=True)
    kept, label = np.unique(obstacle.parts.label[rows], return_inverse=True)
    return replace(
        obstacle,
        name=name,
        warnings=warnings,
        vertices=obstacle.vertices[used],
        faces=faces.reshape(-1, 3).astype(np.int64),
        parts=Components(label.astype(np.int64), obstacle.parts.volume[kept]),
        colors=None if obstacle.colors is None else obstacle.colors[rows],
    )

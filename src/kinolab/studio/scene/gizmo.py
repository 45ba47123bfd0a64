"""A gizmo that moves and turns one thing at a time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from kinolab.numerics.arrays import Array
from kinolab.studio.scene.session import Session

Moved = Callable[[Array, Array, bool], Any]  # place (3,), turn w, x, y, z, and whether it is over
TURNS = math.radians(15.0)  # to which gizmos snap while places snap, too


class Gizmo:
    """A gizmo in the scene; it takes the place of one of the same name.

    Args:
        name: Of its node.
        moved: Called while it is dragged, and at the end.
    """

    def __init__(self, session: Session, name: str, moved: Moved, **options: Any) -> None:
        self._session, self._name, self._moved = session, name, moved
        self._options = options
        self._handle: Any = None
        self._dragged = False

    def show(self, place: Any, wxyz: Any = (1.0, 0.0, 0.0, 0.0), *, size: float = 1.0) -> None:
        """Show it at a place, unless somebody has it in the hand; ``size`` is in [m]."""
        if self._dragged:
            return
        if self._handle is None:
            scene = self._session.server.scene
            self._handle = handle = scene.add_transform_controls(
                self._name, size, depth_test=False, **self._options
            )
            handle.on_update(self._heard)
        self._handle.scale = size
        self._handle.position, self._handle.wxyz = np.asarray(place), np.asarray(wxyz)

    def hide(self) -> None:
        """Take it out of the scene."""
        if self._handle is not None:
            self._handle.remove()
            self._handle, self._dragged = None, False

    async def _heard(self, event: Any) -> None:
        """Pass a drag on; in the event loop, so that its steps come in their order."""
        self._dragged = event.phase != "end"
        place, turn = np.array(event.target.position), np.array(event.target.wxyz)
        self._session.attempt(lambda: self._moved(place, turn, event.phase == "end"))


def snapped(place: Array, snap: float) -> Array:
    """Return a place (3,) on a grid of a width in [m]; 0 for none."""
    return np.asarray(np.round(place / snap) * snap if snap else place)


def rpy_of(wxyz: Array, *, snap: bool = False) -> list[float]:
    """Return roll, pitch and yaw in [rad] of w, x, y, z, shape (4,), in steps if it snaps."""
    turn = Rotation.from_quat(np.roll(wxyz, -1))
    angles = turn.as_euler("xyz")
    angles = np.round(angles / TURNS) * TURNS if snap else angles
    return [float(angle) for angle in angles]


def size_in(session: Session, own: float) -> float:
    """Return how large the gizmo of a thing of a size is, in [m]."""
    # 1.2 times the size of what it moves, and not too small for the scene
    return max(1.2 * own, 0.12 * session.scene.size)

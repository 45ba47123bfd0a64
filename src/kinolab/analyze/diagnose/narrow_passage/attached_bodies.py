"""Thin bodies beside a larger one, such as wheels: how a machine becomes narrower over them.

A wheel of 4 cm cannot lose more than 2 cm on either side. A machine that is slimmer by more than
that is narrower only if its wheels come closer together as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.world.shapes.geometry import half_extents, placement
from kinolab.world.shapes.shrinking import MIN_THICKNESS


@dataclass(frozen=True)
class Attachment:
    """How a body lies beside a larger one along one of its axes, in every configuration.

    Attributes:
        body: Its index.
        axis: Of its frame: 0, 1 or 2.
        offset: Of the larger body's frame along that axis, in [m].
        half: Half of its own width along that axis, in [m].
    """

    body: int
    axis: int
    offset: float
    half: float

    def shift(self, by: float) -> float:
        """Return how far it moves along its axis where it is slimmer by ``by``, in [m]."""
        spare = self.half - MIN_THICKNESS / 2  # by which it can become slimmer where it is
        return float(np.sign(self.offset) * np.clip(by - spare, 0.0, abs(self.offset)))


def attachments(problem: PlanningTask) -> tuple[Attachment, ...]:
    """Find the bodies that lie beside a larger one whatever the configuration is."""
    generator = np.random.default_rng(0)
    # 12 random states, at which distances are compared
    states = [problem.start, *(problem.sample(generator) for _ in range(12))]
    count = len(problem.bodies)
    poses = np.array([problem.placement(x)[0] for x in states]).reshape(-1, count, 3, 4)
    widths = np.array([half_widths(body) for body in problem.bodies]).reshape(-1, 3)
    larger = np.argsort(-widths.prod(axis=1), kind="stable").tolist()
    return tuple(
        found
        for i in range(count)
        for axis in range(3)
        if (found := _beside(poses, widths, larger, i, axis)) is not None
    )


def _beside(
    poses: Array, widths: Array, larger: Sequence[int], i: int, axis: int
) -> Attachment | None:
    """Return how body i lies beside the largest body that keeps its place along an axis."""
    for k in larger:
        if k == i:
            return None  # the rest is smaller
        apart = poses[:, k, :, 3] - poses[:, i, :, 3]
        along = np.einsum("ni,ni->n", apart, poses[:, i, :, axis])
        # 1e-9 [m]: distances that differ by less are the same
        steady = np.ptp(along) < 1e-9 and np.ptp(np.linalg.norm(apart, axis=1)) < 1e-9
        if steady and abs(along[0]) > widths[i, axis]:
            return Attachment(i, axis, float(along[0]), float(widths[i, axis]))
    return None


def half_widths(body: BodyGeometry) -> list[float]:
    """Return half of the largest width of a body's shapes along the axes of its frame, in [m]."""
    found = np.zeros(3)
    for shape in body.shapes:
        turn = placement(shape)[:, :3]
        widths = half_extents(shape, turn) + half_extents(shape, -turn)
        found = np.maximum(found, widths / 2)
    return found.tolist()


def shifts(attached: tuple[Attachment, ...], by: float, count: int) -> Array:
    """Return how bodies move in their frames where all are slimmer by ``by``; (count, 3) [m]."""
    moved = np.zeros((count, 3))
    for entry in attached:
        moved[entry.body, entry.axis] = entry.shift(by)
    return moved

"""Where a plan must end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.quaternions import turn_between

Array: TypeAlias = NDArray[np.float64]
Norm: TypeAlias = Literal["max", "sum", "euclidean"]


@dataclass(frozen=True)
class PointTarget:
    """A point of a body that must come near a point of the world.

    Attributes:
        body: Index of the body.
        at: The point in the body's frame, in [m].
        position: Where it must come, in the world, in [m].
        tolerance: Largest distance in [m].
    """

    body: int
    at: tuple[float, float, float]
    position: tuple[float, float, float]
    tolerance: float

    def distance(self, frames: Array) -> float:
        """Return the distance in [m] between the point and its target at poses (bodies, 12)."""
        pose = frames[self.body].reshape(3, 4)
        reached = pose[:, :3] @ np.asarray(self.at) + pose[:, 3]
        return float(np.linalg.norm(reached - np.asarray(self.position)))


@dataclass(frozen=True)
class DirectionTarget:
    """An axis of a body that must point along a direction of the world.

    Attributes:
        body: Index of the body.
        axis: Unit vector in the body's frame.
        target: Unit vector in the world.
        tolerance: Largest angle in [rad].
    """

    body: int
    axis: tuple[float, float, float]
    target: tuple[float, float, float]
    tolerance: float

    def angle(self, frames: Array) -> float:
        """Return the angle in [rad] between the axis and the target at poses (bodies, 12)."""
        return angle_between(self.body, self.axis, self.target, frames)


@dataclass(frozen=True)
class KeepOutCone:
    """A cone about a direction of the world that an axis of a body must stay out of.

    Attributes:
        body: Index of the body.
        axis: Unit vector in the body's frame.
        direction: Unit vector in the world.
        half_angle: Of the cone that plans keep out of, in [rad].
        clearance: How much of it is a distance that is kept from the forbidden one, in [rad].
    """

    body: int
    axis: tuple[float, float, float]
    direction: tuple[float, float, float]
    half_angle: float
    clearance: float = 0.0

    @property
    def forbidden(self) -> KeepOutCone:
        """The cone without the distance that plans keep from it."""
        return replace(self, half_angle=self.half_angle - self.clearance, clearance=0.0)

    def angle(self, frames: Array) -> float:
        """Return the angle in [rad] between the axis and the direction at poses (bodies, 12)."""
        return angle_between(self.body, self.axis, self.direction, frames)


@dataclass(frozen=True)
class AttitudeTarget:
    """An attitude that a coordinate on SO(3) must come near.

    Attributes:
        name: Of the coordinate.
        index: Where its quaternion begins in the state.
        target: Unit quaternion x, y, z, w.
        tolerance: Largest turn away from it, in [rad].
    """

    name: str
    index: int
    target: tuple[float, float, float, float]
    tolerance: float

    @property
    def entries(self) -> slice:
        """Of the state that hold the quaternion."""
        return slice(self.index, self.index + 4)

    def turn(self, x: Array) -> float:
        """Return the angle in [rad] between a state's attitude and the target."""
        return turn_between(x[self.entries], self.target)


@dataclass(frozen=True, eq=False)
class Goal:
    """A region around target values of some states, and targets of points and axes.

    Attributes:
        indices: Entries of the state that have a target.
        targets: Their target values.
        tolerances: Largest deviation of each, in its own unit.
        circular: Whether each is an angle on the circle.
        points: Targets of points.
        directions: Targets of axes.
        attitudes: Targets of coordinates on SO(3).
        norm: What counts of all deviations as shares of their tolerances: the largest, their sum,
            or the root of the sum of their squares.
    """

    indices: tuple[int, ...]
    targets: Array
    tolerances: Array
    circular: NDArray[np.bool_]
    points: tuple[PointTarget, ...] = ()
    directions: tuple[DirectionTarget, ...] = ()
    attitudes: tuple[AttitudeTarget, ...] = ()
    norm: Norm = "max"

    @property
    def together(self) -> bool:
        """Whether all deviations count together, not the largest alone."""
        return self.norm != "max"

    @property
    def needs_frames(self) -> bool:
        """Whether poses of bodies matter."""
        return bool(self.points or self.directions)

    def deviations(self, x: Array) -> Array:
        """Return target minus state of each named entry, shape (len(indices),)."""
        difference = self.targets - np.asarray(x)[list(self.indices)]
        return np.where(self.circular, wrapped(difference), difference)

    def excess(self, x: Array, frames: Array | None = None) -> float:
        """Return how far outside the goal a state is, in tolerances: at most 1 inside.

        Each deviation is a share of its tolerance; ``norm`` says how they count.

        Args:
            x: State, shape (nx,).
            frames: Poses of the bodies, shape (bodies, 12); needed where ``needs_frames``.
        """
        shares = (np.abs(self.deviations(x)) / self.tolerances).tolist()
        shares += [attitude.turn(x) / attitude.tolerance for attitude in self.attitudes]
        if frames is not None:
            shares += [point.distance(frames) / point.tolerance for point in self.points]
            shares += [target.angle(frames) / target.tolerance for target in self.directions]
        if self.norm == "euclidean":
            return float(np.linalg.norm(shares))
        if self.norm == "sum":
            return float(np.sum(shares))
        return float(np.max(shares, initial=0.0))  # NaN stays NaN, which is outside

    def distance(self, x: Array, frames: Array | None = None) -> float:
        """Return the Euclidean norm of all deviations in SI units; 0 exactly at the goal."""
        errors = list(self.deviations(x))
        errors += [attitude.turn(x) for attitude in self.attitudes]
        if frames is not None:
            errors += [point.distance(frames) for point in self.points]
            errors += [direction.angle(frames) for direction in self.directions]
        return float(np.linalg.norm(errors))


def angle_between(
    body: int,
    axis: tuple[float, float, float],
    direction: tuple[float, float, float],
    frames: Array,
) -> float:
    """Return the angle in [rad] between an axis of a body and a direction of the world.

    Args:
        body: Its row.
        axis, direction: Unit vectors, the one in the body's frame, the other in the world's.
        frames: One row [R | p] per body, shape (bodies, 12).
    """
    turned = frames[body].reshape(3, 4)[:, :3] @ np.asarray(axis)
    wanted = np.asarray(direction)
    return float(np.arctan2(np.linalg.norm(np.cross(turned, wanted)), turned @ wanted))

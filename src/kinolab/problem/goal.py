"""Where a plan must end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.state_parts import UnitSphere
from kinolab.scenario.schema import TOLERANCE

Norm: TypeAlias = Literal["max", "sum", "euclidean"]

# of the goal's tolerance, which searches aim at; the rest allows for rounding
SEARCHED_FRACTION = 0.999


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

    def in_world(self, frames: Array) -> Array:
        """Return the point at poses (..., bodies, 12), shape (..., 3): linear in them."""
        return axis_in_world(self.body, self.at, frames) + frames[..., self.body, 3::4]

    def offset(self, frames: Array) -> Array:
        """Return where the point is from its target, in [m], shape (..., 3)."""
        offset: Array = self.in_world(frames) - np.asarray(self.position)
        return offset

    def error(self, frames: Array) -> float:
        """Return the distance in [m] between the point and its target at poses (bodies, 12)."""
        return float(np.linalg.norm(self.offset(frames)))


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

    def in_world(self, frames: Array) -> Array:
        """Return the axis at poses (..., bodies, 12), shape (..., 3): linear in them."""
        return axis_in_world(self.body, self.axis, frames)

    def offset(self, frames: Array) -> Array:
        """Return the chord from the target to the axis, shape (..., 3)."""
        chord: Array = self.in_world(frames) - np.asarray(self.target)
        return chord

    def error(self, frames: Array) -> float:
        """Return the angle in [rad] between the axis and the target at poses (bodies, 12)."""
        return float(angle_between(self.in_world(frames), np.asarray(self.target)))


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

    def in_world(self, frames: Array) -> Array:
        """Return the axis at poses (..., bodies, 12), shape (..., 3): linear in them."""
        return axis_in_world(self.body, self.axis, frames)

    def angle(self, frames: Array) -> Array:
        """Return the angle in [rad] from the direction to the axis at poses (..., bodies, 12)."""
        return angle_between(self.in_world(frames), np.asarray(self.direction))


@dataclass(frozen=True)
class PartTarget:
    """A unit vector that a part of the state must come near, such as an attitude.

    Attributes:
        part: Of the state, a coordinate.
        target: Its value there, such as a unit quaternion x, y, z, w.
        tolerance: Largest distance from it as the part counts it, in [rad].
    """

    part: UnitSphere
    target: tuple[float, ...]
    tolerance: float

    def error(self, x: Array) -> float:
        """Return the angle in [rad] between a state's value and the target."""
        return float(self.part.distance(x[self.part.own], self.target))

    def offset(self, x: Array) -> Array:
        """Return the angle from the target as a vector of 3, smooth near it."""
        return self.part.offset(self.target, x[self.part.own])


@dataclass(frozen=True, eq=False)
class Goal:
    """A region around target values of some states, and targets of points and axes.

    How far a state is from the goal is told by ``errors``, of which everything else is a norm, and
    by ``residual``, which is smooth, for solvers.

    Attributes:
        indices: Entries of the state that have a target.
        targets: Their target values.
        tolerances: Largest deviation of each, in its own unit.
        circular: Whether each is an angle on the circle.
        points: Targets of points.
        directions: Targets of axes.
        parts: Targets of coordinates that are unit vectors, such as attitudes.
        formulas: Targets of formulas, each the place along x of a frame without a body.
        norm: What counts of all deviations as shares of their tolerances: the largest, their sum,
            or the root of the sum of their squares.
        any_of: Further goals, of which a motion may end in any instead; who searches takes one.
        predicate: What else must hold of a state (nx,) inside.
    """

    indices: tuple[int, ...]
    targets: Array
    tolerances: Array
    circular: NDArray[np.bool_]
    points: tuple[PointTarget, ...] = ()
    directions: tuple[DirectionTarget, ...] = ()
    parts: tuple[PartTarget, ...] = ()
    formulas: tuple[PointTarget, ...] = ()
    norm: Norm = "max"
    any_of: tuple[Goal, ...] = ()
    predicate: Callable[[Array], bool] | None = None

    @property
    def each(self) -> tuple[Goal, ...]:
        """The goals of which a motion may end in any; itself where there is one."""
        return (replace(self, any_of=()), *self.any_of)

    def changed(self, change: Callable[[Goal], Goal]) -> Goal:
        """Return the goal with a change of each of those of which a motion may end in any."""
        first, *others = map(change, self.each)
        return replace(first, any_of=tuple(others))

    def at_rest(self, speeds: NDArray[np.int64]) -> Goal:
        """Return the same goal, in which the machine rests.

        Args:
            speeds: The entries of the state that are velocities.
        """
        left = [i for i in speeds.tolist() if i not in self.indices]
        still = np.zeros(len(left))
        return replace(
            self,
            indices=(*self.indices, *left),
            targets=np.append(self.targets, still),
            tolerances=np.append(self.tolerances, still + TOLERANCE),
            circular=np.append(self.circular, still > 0),
        )

    @property
    def together(self) -> bool:
        """Whether all deviations count together, not the largest alone."""
        return self.norm != "max"

    @property
    def needs_frames(self) -> bool:
        """Whether poses of bodies matter."""
        return bool(self.of_bodies)

    @property
    def asks_frames(self) -> bool:
        """Whether poses of bodies decide if a state is in any of the goals."""
        return any(one.needs_frames for one in self.each)

    @cached_property
    def entries(self) -> list[int]:
        """The entries of the state that have a target, by themselves or as part of a vector."""
        return [*self.indices, *(i for one in self.parts for i in one.part.entries)]

    def centre(self, x: Array) -> Array:
        """Return a state (nx,) with its entries at their targets; points and axes do not matter."""
        moved = np.array(x, dtype=float)
        moved[list(self.indices)] = self.targets
        for one in self.parts:
            moved[one.part.own] = one.target
        return moved

    def deviations(self, x: Array) -> Array:
        """Return target minus state of each named entry, shape (len(indices),)."""
        difference = self.targets - np.asarray(x)[list(self.indices)]
        return np.where(self.circular, wrapped(difference), difference)

    @property
    def of_bodies(self) -> tuple[PointTarget | DirectionTarget, ...]:
        """Targets of points, then of axes and of formulas."""
        return (*self.points, *self.directions, *self.formulas)

    @cached_property
    def error_tolerances(self) -> Array:
        """The largest size of each of ``errors`` inside the goal."""
        others = (*self.parts, *self.of_bodies)
        return np.append(self.tolerances, [target.tolerance for target in others])

    def errors(self, x: Array, frames: Array | None = None) -> Array:
        """Return how far a state is from every target, each in its SI unit, shape (errors,).

        In order: the deviations of named entries, turns of attitudes in [rad], distances of points
        in [m], angles of axes in [rad], and of formulas in their own units.

        Args:
            x: State, shape (nx,).
            frames: Poses of the bodies, shape (bodies, 12); needed where ``asks_frames``.
        """
        others = [one.error(x) for one in self.parts]
        if frames is not None:
            others += [target.error(frames) for target in self.of_bodies]
        return np.append(self.deviations(x), others)

    def residual(self, x: Array, frames: Array | None = None) -> Array:
        """Return ``errors`` in tolerances, those of attitudes and bodies as vectors of 3.

        It is smooth in x, and 0 in the goal's middle; arguments as for ``errors``.
        """
        parts = [self.deviations(x) / self.tolerances]
        parts += [one.offset(x) / one.tolerance for one in self.parts]
        if frames is not None:
            parts += [target.offset(frames) / target.tolerance for target in self.of_bodies]
        return np.concatenate(parts)

    def excess(self, x: Array, frames: Array | None = None) -> float:
        """Return how far outside the goal a state is, in tolerances: at most 1 inside.

        Each error is a fraction of its tolerance; ``norm`` says how they count. Where a predicate
        does not hold, it is a tolerance farther, and outside. Arguments as for ``errors``.
        """
        if self.any_of:
            return min(one.excess(x, frames) for one in self.each)
        far = self._share(x, frames)
        if self.predicate is None or self.predicate(x):
            return far
        return 1.0 + max(1.0, far)

    def _share(self, x: Array, frames: Array | None) -> float:
        """Return how large all errors are, as ``norm`` counts them."""
        fractions = np.abs(self.errors(x, frames)) / self.error_tolerances
        if self.norm == "euclidean":
            return float(np.linalg.norm(fractions))
        if self.norm == "sum":
            return float(np.sum(fractions))
        return float(np.max(fractions, initial=0.0))  # NaN stays NaN, which is outside

    def distance(self, x: Array, frames: Array | None = None) -> float:
        """Return the Euclidean norm of all errors in SI units; 0 exactly at the goal."""
        return float(np.linalg.norm(self.errors(x, frames)))


def axis_in_world(body: int, axis: tuple[float, float, float], frames: Array) -> Array:
    """Return an axis of a body at poses (..., bodies, 12), shape (..., 3)."""
    pose = frames[..., body, :].reshape(*frames.shape[:-2], 3, 4)
    turned: Array = pose[..., :3] @ np.asarray(axis)
    return turned


def angle_between(a: Array, b: Array) -> Array:
    """Return the angle in [rad] from a vector (3,) to others (..., 3), shape (...).

    It is sharp everywhere, as the cosine is not.
    """
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), a @ b))

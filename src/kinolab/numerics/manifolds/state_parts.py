"""The parts of a state space: lines, circles and unit spheres, each with its own laws.

A space of states is the product of its parts, as OMPL's ``CompoundStateSpace``. Values of a part
are its entries of a state, shape (..., size). What a consumer makes of a part, such as OMPL's space
or machine code, is a ``functools.singledispatch`` function that stands with the consumer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.manifolds.rotations import multiply, turn_between, unit, unit_rows


@dataclass(frozen=True)
class Part:
    """Entries of a state that stand beside each other and make a manifold.

    Attributes:
        name: Of the coordinate, empty where there is none.
        first: The first of its entries in a state.
        size: How many there are.
    """

    name: str
    first: int
    size: int = 1

    symbol: ClassVar[str] = "R"

    @property
    def entries(self) -> range:
        """Its entries of a state."""
        return range(self.first, self.first + self.size)

    @property
    def own(self) -> slice:
        """Its entries of a state, as a slice."""
        return slice(self.first, self.first + self.size)


class RealLine(Part):
    """Numbers of which every one counts: lengths, limited angles, rates."""


class Circle(Part):
    """An angle in [rad] that is the same after a whole turn."""

    symbol = "S^1"


class UnitSphere(Part):
    """Unit vectors; the last entry is 1 and the others are 0 at rest.

    Attributes:
        antipodal: Whether a vector and its opposite are the same value.
        word: What users call a value.
        example: How they write one.
    """

    antipodal: ClassVar[bool] = False
    word: ClassVar[str]
    example: ClassVar[str]

    @property
    def pole(self) -> int:
        """The entry of a state that is 1 at rest."""
        return self.first + self.size - 1

    @property
    def angles(self) -> int:
        """The distance in [rad] of two values that are an angle of 1 rad apart on the sphere."""
        return 1 + self.antipodal

    def distance(self, a: ArrayLike, b: ArrayLike) -> Array:
        """Return the angles in [rad] between values, shape (...), of attitudes 0 to pi as well."""
        p, q = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        apart, together = np.linalg.norm(p - q, axis=-1), np.linalg.norm(p + q, axis=-1)
        return np.asarray(2 * np.arctan2(apart, together))

    def offset(self, target: ArrayLike, value: Array) -> Array:
        """Return the angle from a target as a vector, smooth near 0, shape (3,)."""
        return np.asarray(value - np.asarray(target))

    def tangents(self, value: Array) -> Array:
        """Return the derivatives by unit velocities, a basis of the tangents, (size, size - 1)."""
        return np.asarray(np.linalg.svd(value[None])[2][1:].T)

    def near(self, value: Array, angles: float | Array, generator: np.random.Generator) -> Array:
        """Return values at most angles (...) in [rad] from one, all ways alike, (..., size)."""
        aside = np.cross(value, generator.normal(size=(*np.shape(angles), 3)))
        turn = np.asarray(generator.uniform(0, angles))[..., None]
        return np.asarray(np.cos(turn) * value + np.sin(turn) * _unit(aside))

    def random(self, generator: np.random.Generator, *count: int) -> Array:
        """Return values of the uniform distribution, shape (*count, size)."""
        return _unit(generator.normal(size=(*count, self.size)))

    def nearest(self, here: Array, there: Array) -> Array:
        """Return a value as it is written nearest to another one: with the other sign, perhaps."""
        if not self.antipodal:
            return there
        along = np.sum(here * there, axis=-1, keepdims=True)
        return np.where(along < 0, -there, there)


class Rotations(UnitSphere):
    """Attitudes, as unit quaternions x, y, z, w; q and -q are the same one.

    Their distance is the angle of the turn between them; tangents, offsets and turns are about the
    axes of the body that is turned.
    """

    symbol = "SO(3)"
    antipodal = True
    word = "rotation"
    example = "its quaternion [x, y, z, w]; [0, 0, 0, 1] is not turned"

    def distance(self, a: ArrayLike, b: ArrayLike) -> Array:
        """Return the angles in [rad] from attitudes to others, 0 to pi."""
        return turn_between(a, b)

    def offset(self, target: ArrayLike, value: Array) -> Array:
        """Return twice the vector part of the turn from a target."""
        # times a unit quaternion
        turn = multiply(np.array([-1.0, -1.0, -1.0, 1.0]) * np.asarray(target), value)
        vector: Array = 2 * np.copysign(1.0, turn[3]) * turn[:3]
        return vector

    def tangents(self, value: Array) -> Array:
        """Return q_dot = q w / 2 of the unit vectors w, as columns."""
        a, b, c, w = value
        return np.array([[w, -c, b], [c, w, -a], [-b, a, w], [-a, -b, -c]]) / 2

    def near(self, value: Array, angles: float | Array, generator: np.random.Generator) -> Array:
        """Return an attitude turned by at most given angles about random axes."""
        axes = _unit(generator.normal(size=(*np.shape(angles), 3)))
        halves = np.asarray(generator.uniform(0, angles))[..., None] / 2
        turns = np.concatenate([np.sin(halves) * axes, np.cos(halves)], axis=-1)
        return multiply(value, turns)


class Directions(UnitSphere):
    """Directions in space, as unit vectors x, y, z on the sphere S^2."""

    symbol = "S^2"
    word = "direction"
    example = "its unit vector [x, y, z]"


def completed(parts: Sequence[Part], nx: int) -> tuple[Part, ...]:
    """Return the parts of a state of nx entries, of which a configuration has given ones."""
    nq = sum(part.size for part in parts)
    return (*parts, RealLine("", nq, nx - nq))


def spheres_of(parts: Sequence[Part]) -> tuple[UnitSphere, ...]:
    """Return the parts that are unit vectors."""
    return tuple(part for part in parts if isinstance(part, UnitSphere))


def sphere_table(spheres: Sequence[UnitSphere]) -> Integers:
    """Return first entry, size and whether opposites are the same of unit vectors, (n, 3)."""
    rows = [(part.first, part.size, part.antipodal) for part in spheres]
    return np.array(rows, dtype=np.int64).reshape(-1, 3)


def _unit(vectors: Array) -> Array:
    alone = vectors.size == vectors.shape[-1]
    return unit(vectors) if alone else unit_rows(vectors)

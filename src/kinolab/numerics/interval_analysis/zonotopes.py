"""Zonotopes: sets c + P a + G b with all entries of a and b in [-1, 1].

The generators in P belong to unknowns that stay the same through time, such as a mass: they are
never mixed with others, so that what depends on the same unknown stays together.

Source: Girard, Reachability of uncertain linear systems using zonotopes, HSCC 2005; Althoff,
Stursberg, Buss, Reachability analysis of nonlinear systems with uncertain parameters using
conservative linearization, CDC 2008.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import SMALLEST, IntervalArray

# A sum of n products of doubles errs by less than n units of 2.2e-16 of the sum of their sizes
# (Higham, Accuracy and Stability of Numerical Algorithms, 2002, section 3.1): of 4000, by this.
SUMS = 1e-12


@dataclass(frozen=True, eq=False)
class Zonotope:
    """A set of points in n dimensions.

    Attributes:
        centre: Shape (n,).
        lasting: Generators of what stays the same, shape (n, parameters).
        free: All others, shape (n, count).
    """

    centre: Array
    lasting: Array
    free: Array

    @classmethod
    def box(cls, centre: Array, radius: Array, lasting: int) -> Zonotope:
        """Return a box about a centre (n,) whose half edges are (n,)."""
        return cls(centre, np.zeros((len(centre), lasting)), np.diag(radius))

    @property
    def generators(self) -> Array:
        """All of them, those that last first."""
        return np.hstack([self.lasting, self.free])

    @property
    def radius(self) -> Array:
        """Half edges of the smallest box about it, shape (n,)."""
        return np.asarray(np.abs(self.generators).sum(axis=1) * (1.0 + SUMS) + SMALLEST)

    @property
    def bounds(self) -> IntervalArray:
        """The smallest box about it, shape (n,)."""
        slack = SUMS * np.abs(self.centre)
        return IntervalArray(self.centre - self.radius - slack, self.centre + self.radius + slack)

    @property
    def magnitude(self) -> Array:
        """The largest magnitude of each entry, shape (n,)."""
        return np.asarray((np.abs(self.centre) + self.radius) * (1.0 + SUMS))

    def mapped(self, matrix: Array) -> Zonotope:
        """Return its image under a matrix (k, n); what rounding adds is a box of its own."""
        off = SUMS * (np.abs(matrix) @ self.magnitude) + SMALLEST
        free = np.hstack([matrix @ self.free, np.diag(off)])
        return Zonotope(matrix @ self.centre, matrix @ self.lasting, free)

    def plus(self, centre: Array, *free: Array, lasting: Array | None = None) -> Zonotope:
        """Return the sum with another one, that of a centre (n,) and generators (n, count)."""
        kept = self.lasting if lasting is None else self.lasting + lasting
        sizes = np.abs(self.centre) + np.abs(centre) + np.abs(kept).sum(axis=1)
        rounding = np.diag(SUMS * sizes)
        return Zonotope(self.centre + centre, kept, np.hstack([self.free, *free, rounding]))

    def reduced(self, most: int, scales: Array) -> Zonotope:
        """Return one that contains it, with at most so many generators that do not last.

        Those go into a box that are nearest to one already.

        Args:
            most: How many, at least n.
            scales: Sizes by which entries are compared, shape (n,).

        Source: Girard 2005, section 3.4; Combastel, A state bounding observer based on zonotopes,
        ECC 2003.
        """
        count, n = self.free.shape[1], len(self.centre)
        if count <= most or not np.isfinite(self.free).all():
            return self
        sizes = np.abs(self.free) / scales[:, None]
        order = np.argsort(sizes.sum(axis=0) - sizes.max(axis=0), kind="stable")
        boxed, kept = order[: count - most + n], order[count - most + n :]
        edges = np.abs(self.free[:, boxed]).sum(axis=1) * (1.0 + SUMS) + SMALLEST
        return Zonotope(self.centre, self.lasting, np.hstack([self.free[:, kept], np.diag(edges)]))

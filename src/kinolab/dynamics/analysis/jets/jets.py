"""Jets: truncated multivariate Taylor polynomials over floats or exact numbers.

Brackets of up to k fields at a point need only the fields' jets of order k - 1 there, so that no
bracket is ever formed as an expression.

Source: Griewank, Walther, Evaluating Derivatives, 2nd ed., 2008, chapter 13.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations_with_replacement
from math import comb
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Jet: TypeAlias = NDArray[Any]  # coefficients by monomial, lowest degree first; shape (..., size)
Index: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class JetSpace:
    """The space of jets in ``variables`` variables up to a degree; built by ``jet_space``.

    Attributes:
        variables: Number of variables.
        order: Highest degree kept.
        left, right: Pairs of monomials with product of degree <= order, sorted by product.
        starts: Offset of the first pair of each product.
        raised: For each variable and monomial of degree below ``order``, the monomial times the
            variable; shape (variables, size one order lower).
        powers: The power of that variable in it; same shape.
    """

    variables: int
    order: int
    left: Index
    right: Index
    starts: Index
    raised: Index
    powers: Index

    @property
    def size(self) -> int:
        """Number of monomials."""
        return size_of(self.variables, self.order)

    def product(self, a: Jet, b: Jet) -> Jet:
        """Multiply jets, truncated; shapes broadcast except for the last axis."""
        terms = a[..., self.left] * b[..., self.right]
        return np.asarray(np.add.reduceat(terms, self.starts, axis=-1))

    def gradient(self, a: Jet) -> Jet:
        """Differentiate by every variable: shape (..., size) to (..., variables, lower size)."""
        return np.asarray(a[..., self.raised] * self.powers)

    def lower(self, a: Jet, order: int) -> Jet:
        """Truncate to degree ``order``."""
        return a[..., : size_of(self.variables, order)]


def size_of(variables: int, order: int) -> int:
    """Return the number of monomials up to a degree."""
    return comb(variables + order, order)


def work_of(variables: int, order: int) -> int:
    """Return the number of multiplications of a product of two jets."""
    return comb(2 * variables + order, order)


@lru_cache(maxsize=32)
def jet_space(variables: int, order: int) -> JetSpace:
    """Return the space of jets of an order in some variables, cached."""
    # each as its variables in order: x0 x0 x2 is (0, 0, 2)
    monomials = [
        monomial
        for degree in range(order + 1)
        for monomial in combinations_with_replacement(range(variables), degree)
    ]
    place = {monomial: k for k, monomial in enumerate(monomials)}
    pairs = sorted(
        (place[_times(a, b)], i, j)
        for i, a in enumerate(monomials)
        for j, b in enumerate(monomials[: size_of(variables, order - len(a))])
    )
    table = np.array(pairs, dtype=np.int64).reshape(-1, 3)
    low = monomials[: size_of(variables, order - 1)] if order else []
    raised = [[place[_times(m, (j,))] for m in low] for j in range(variables)]
    powers = [[m.count(j) + 1 for m in low] for j in range(variables)]
    return JetSpace(
        variables=variables,
        order=order,
        left=table[:, 1],
        right=table[:, 2],
        starts=np.searchsorted(table[:, 0], np.arange(len(monomials))),
        raised=np.array(raised, dtype=np.int64).reshape(variables, len(low)),
        powers=np.array(powers, dtype=np.int64).reshape(variables, len(low)),
    )


def _times(a: tuple[int, ...], b: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(sorted(a + b))

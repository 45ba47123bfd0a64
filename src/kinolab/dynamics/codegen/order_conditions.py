"""The order of a method of integration, by its conditions on rooted trees.

With K = (1 - C) k, the stages of ``Method`` are those of Rosenbrock's form

    K_i = f(x + h sum_j alpha_ij K_j) + h J sum_j gamma_ij K_j,    x+ = x + h sum_i w_i K_i,

where alpha = A M, gamma = gamma M, w = b M and M = (1 - C)^-1. It is of order p where each rooted
tree of up to p nodes has sum_i w_i Phi_i = 1 / density: a node with one son adds the factor alpha +
gamma of the son, one with several sons that of alpha for each of them.

Source: Hairer, Wanner, Solving ODEs II, 2nd ed., section IV.7, theorem 7.4; without gamma these are
Butcher's conditions, Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.2.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array

HIGHEST = (
    14  # the highest order of a published table: Feagin, Neural Parallel Sci. Comput. 20, 2012
)


Rows = Sequence[Sequence[float]]


@dataclass(frozen=True)
class _RootedTree:
    """A rooted tree; arrays (2, stages) are exact, then with the sizes of all terms.

    Attributes:
        nodes: How many it has.
        density: The product of the numbers of nodes of it and of its subtrees.
        alone: Its factor where it is the only son.
        beside: Its factor where it is one of several.
    """

    nodes: int
    density: int
    alone: Array
    beside: Array


@np.errstate(all="ignore")  # what overflows is of no order
def order_of(b: Sequence[float], a: Rows, c: Rows, gamma: float, highest: int) -> int:
    """Return the order of a method, looked at up to the highest one that is asked for.

    Args:
        b, a, c, gamma: As in ``Method``.
        highest: At most ``HIGHEST``.
    """
    signs = [_matrices(b, a, c, gamma), _matrices(np.abs(b), _sizes(a), _sizes(c), gamma)]
    weights, alpha, beta = (np.array(pair) for pair in zip(*signs, strict=True))
    trees: list[_RootedTree] = []
    for nodes in range(1, highest + 1):
        found = []
        for sons in _forests(trees, nodes - 1, len(trees)):
            phi = np.ones((2, len(b)))
            for son in sons:
                phi = phi * (son.alone if len(sons) == 1 else son.beside)
            density = nodes * int(np.prod([son.density for son in sons], dtype=object))
            value, size = np.einsum("ki,ki->k", weights, phi)
            rounding = 2 * nodes * sys.float_info.epsilon * size  # of a product of fewer factors
            # 1e-9 of a condition: what is left where coefficients have nine digits
            if not abs(value - 1 / density) <= 1e-9 / density + rounding < math.inf:
                return nodes - 1
            alone, beside = (np.einsum("kij,kj->ki", table, phi) for table in (beta, alpha))
            found.append(_RootedTree(nodes, density, alone, beside))
        trees += found
    return highest


def _forests(
    trees: Sequence[_RootedTree], nodes: int, end: int
) -> Iterator[tuple[_RootedTree, ...]]:
    """Yield each choice of trees, also several times the same, with a number of nodes in all."""
    if nodes == 0:
        yield ()
    for k in range(end):
        if trees[k].nodes <= nodes:
            rest = _forests(trees, nodes - trees[k].nodes, k + 1)
            yield from ((trees[k], *others) for others in rest)


def _matrices(b: Sequence[float] | Array, a: Rows, c: Rows, gamma: float) -> tuple[Array, ...]:
    """Return the weights, alpha, and the sum of alpha and gamma, in Rosenbrock's form."""
    stages = len(b)
    A, C = np.zeros((stages, stages)), np.zeros((stages, stages))
    for table, rows in ((A, a), (C, c)):
        for i, row in enumerate(rows):
            table[i, : len(row)] = row
    M = np.linalg.inv(np.eye(stages) - C)
    return np.asarray(b) @ M, A @ M, A @ M + gamma * M


def _sizes(rows: Rows) -> Rows:
    return [np.abs(row).tolist() for row in rows]

"""Whether outputs are flat, by the dynamic extension algorithm on differentials.

Along a motion, dy, dy', …, dy^(k) are rows in dx, du, du', …, du^(k). Their rank modulo dx grows
with k by sigma_k, the rank of the decoupling matrix after k steps of the algorithm, which ends once
it is the number of inputs. Then the total relative degree of the extended machine is the number of
its states, and the outputs are flat, exactly if the rows span all of dx.

Sources: Descusse, Moog, Decoupling with dynamic compensation for strong invertible affine
non-linear systems, Int. J. Control 42(6), 1985; Aranda-Bricaire, Moog, Pomet, A linear algebraic
framework for dynamic feedback linearization, IEEE Trans. Automatic Control 40(1), 1995.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.analysis.jets.ranks import scales_of
from kinolab.numerics.arrays import Array

# A rank is clear where no singular value, relative to the largest, is between these two.
NONZERO, ZERO = 1e-9, 1e-12


@dataclass(frozen=True)
class ClearRank:
    """A rank with what separates it from others.

    Attributes:
        value: The rank.
        smallest: Smallest singular value that counts, relative to the largest; 1 of rank 0.
        largest_ignored: Largest one that does not.
    """

    value: int
    smallest: float
    largest_ignored: float

    @property
    def clear(self) -> bool:
        """Whether the rank is beyond doubt."""
        return self.smallest > NONZERO and self.largest_ignored < ZERO


def cleaned(rows: Array) -> Array:
    """Divide rows (…, n) by their largest entries, and make those 0 that are rounding.

    Args:
        rows: With all of their columns, which have comparable units.
    """
    size = np.abs(rows).max(axis=-1, keepdims=True, initial=0.0)
    rows = rows / np.where(size > 0, size, 1.0)
    # of the largest entry of a row, in units of scales; less is left of terms that cancelled
    return np.where(np.abs(rows) > 1e-11, rows, 0.0)


def clear_rank(rows: Array) -> ClearRank:
    """Return the rank of a matrix (m, n) of rows that were cleaned."""
    if not rows.any():
        return ClearRank(0, 1.0, 0.0)
    heights, widths = scales_of(np.abs(rows))
    values = np.linalg.svd(rows / heights / widths, compute_uv=False)
    shares = values / values[0]
    gap = np.sqrt(NONZERO * ZERO)
    counted, ignored = shares[shares > gap], shares[shares <= gap]
    return ClearRank(len(counted), float(counted[-1]), float(ignored.max(initial=0.0)))


@dataclass(frozen=True)
class Extension:
    """The state of the algorithm after k steps, for some outputs at one motion.

    Attributes:
        closed: Whether it has ended: the decoupling matrix is regular.
        determined: Dimension of the states that the outputs determine so far.
        dimension: Of the state space.
        clear: Whether all ranks are beyond doubt.
        margin: Smallest singular value that counted.
    """

    closed: bool
    determined: int
    dimension: int
    clear: bool
    margin: float


def extension(rows: Array, dimension: int) -> Extension:
    """Return how far the algorithm is after as many steps as there are derivatives.

    Args:
        rows: Derivatives of outputs and their rates by states and inputs, shape
            (nu, k + 1, dimension + nu * (k + 1)).
    """
    rows = cleaned(rows)
    count, orders, width = rows.shape
    before = clear_rank(rows[:, :-1, dimension : width - count].reshape(count * (orders - 1), -1))
    after = clear_rank(rows[:, :, dimension:].reshape(count * orders, -1))
    whole = clear_rank(rows.reshape(count * orders, -1))
    ranks = (before, after, whole)
    return Extension(
        closed=after.value - before.value == count,
        determined=whole.value - after.value,
        dimension=dimension,
        clear=all(rank.clear for rank in ranks),
        margin=min(rank.smallest for rank in ranks),
    )


def recovers(rows: Array, orders: tuple[int, ...], dimension: int, wanted: int) -> bool:
    """Return whether derivatives of outputs up to orders determine states and inputs.

    Args:
        rows: As those of ``extension``, shape (nu, k + 1, dimension + nu * (k + 1)).
        orders: Number of derivatives of each output.
        wanted: How many of its dimensions are to be determined.
    """
    rows = cleaned(rows)
    kept = np.concatenate([row[: order + 1] for row, order in zip(rows, orders, strict=True)])
    own, inputs = clear_rank(kept), clear_rank(kept[:, dimension + len(rows) :])
    return own.clear and inputs.clear and own.value - inputs.value == wanted + len(rows)


def least_orders(rows: Array, dimension: int, wanted: int) -> tuple[int, ...] | None:
    """Return how many derivatives of each output are needed; None if there are too few.

    Args:
        rows: As those of ``extension``, shape (nu, k + 1, dimension + nu * (k + 1)).
        wanted: How many of its dimensions are to be determined.
    """
    orders = (rows.shape[1] - 1,) * len(rows)
    if not recovers(rows, orders, dimension, wanted):
        return None
    for i in range(len(orders)):
        while orders[i]:
            fewer = (*orders[:i], orders[i] - 1, *orders[i + 1 :])
            if not recovers(rows, fewer, dimension, wanted):
                break
            orders = fewer
    return orders

"""How far every variable may change: the problem's limits within a trust region."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.linear_inequalities import LinearInequalities
from kinolab.trajopt.nlp.scaling import Scaling

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TrustRegion:
    """Least and largest changes, as shares of what counts as large.

    Attributes:
        x: Of the states, shape (2, N+1, nx); the first one is held.
        u: Of the inputs, shape (2, N, nu).
        h: Of the step length, shape (2,).
    """

    x: Array
    u: Array
    h: Array


def trust_region(knots: Knots, scaling: Scaling, radius: float) -> TrustRegion:
    """Return how far knots may change; what is beyond a limit may stay there.

    Args:
        knots: Where.
        scaling: With all limits.
        radius: Largest change of any variable, as a share of what counts as large.
    """
    x = _range(knots.x, scaling.x_bounds, scaling.x, radius)
    x[:, 0] = 0.0
    u = _range(knots.u, scaling.u_bounds, scaling.u, radius)
    limits = np.array([scaling.h_bounds])
    return TrustRegion(x, u, _range(np.array([knots.h]), limits, np.array([knots.h]), radius)[:, 0])


def inequalities_within(
    rows: LinearInequalities, scaling: Scaling, region: TrustRegion
) -> LinearInequalities:
    """Return the inequalities that some change within the box breaks: the others say nothing."""
    last_x, last_u = region.x.shape[1] - 1, region.u.shape[1] - 1
    after = np.minimum(rows.knot + 1, last_x)
    least = (
        rows.value
        + _least(rows.dx * scaling.x, region.x[:, rows.knot])
        + _least(rows.dx_next * scaling.x, region.x[:, after])
        + _least(rows.du * scaling.u, region.u[:, np.minimum(rows.knot, last_u)])
    )
    kept = np.flatnonzero(~(least >= 0))
    return replace(
        rows,
        knot=rows.knot[kept],
        value=rows.value[kept],
        dx=rows.dx[kept],
        dx_next=rows.dx_next[kept],
        du=rows.du[kept],
    )


def _range(values: Array, bounds: Array, large: Array, radius: float) -> Array:
    lower = np.maximum(-radius, np.minimum((bounds[:, 0] - values) / large, 0.0))
    upper = np.minimum(radius, np.maximum((bounds[:, 1] - values) / large, 0.0))
    return np.stack([lower, upper])


def _least(slope: Array, limits: Array) -> Array:
    """Return the least sum of slope * change, one per row."""
    return np.asarray(np.minimum(slope * limits[0], slope * limits[1]).sum(axis=-1))

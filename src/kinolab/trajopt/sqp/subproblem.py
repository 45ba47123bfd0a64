"""The convex subproblem of one SQP step: linearisation, weights and trust region."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.trajopt.nlp.decision import Knots, Scaling, Weights
from kinolab.trajopt.nlp.linearization import Linearization
from kinolab.trajopt.nlp.path_constraints import LinearInequalities


@dataclass(frozen=True, eq=False)
class Step:
    """A step and its predicted reduction of the merit function.

    ``length`` is the largest scaled change of any variable.
    """

    dx: Array
    du: Array
    dh: Array
    predicted: float
    length: float


@dataclass(frozen=True, eq=False)
class Subproblem:
    """The convex subproblem within a trust region.

    Attributes:
        linearization: Of the problem.
        scaling: Of the variables.
        weights: Of the merit function.
        region: Bounds of the step.
        rows: Inequalities that some step in the region violates.
        curvature: Of the cost of each step in scaled states and inputs, without negative
            eigenvalues, shape (N, nx + nu, nx + nu); None for a cost that is linear.
    """

    linearization: Linearization
    scaling: Scaling
    weights: Weights
    region: TrustRegion
    rows: LinearInequalities
    curvature: Array | None = None

    def step(self, x: Array, u: Array, h: Array, predicted: float) -> Step:
        """Return the step in physical units from scaled changes.

        Args:
            x: Scaled change of the states, shape (N+1, nx).
            u: Scaled change of the inputs, shape (N, nu).
            h: Relative change of the step length of each phase, shape (P,).
            predicted: Predicted reduction of the merit function.
        """
        scaling, dh = self.scaling, h * self.linearization.knots.lengths
        length = max(float(np.abs(part).max(initial=0.0)) for part in (x, u, h))
        return Step(x * scaling.x, u * scaling.u, dh, predicted, length)


def subproblem(
    linearization: Linearization,
    scaling: Scaling,
    weights: Weights,
    radius: float,
    curvature: Array | None = None,
) -> Subproblem:
    """Return the subproblem within a trust region.

    Args:
        scaling: With all limits.
        weights: Of the merit function.
        radius: Largest scaled change of any variable.
        curvature: As of ``Subproblem``, shape (N, nx + nu, nx + nu).
    """
    region = trust_region(linearization.knots, scaling, radius)
    rows = inequalities_within(linearization.rows, scaling, region)
    return Subproblem(linearization, scaling, weights, region, rows, curvature)


@dataclass(frozen=True, eq=False)
class TrustRegion:
    """Lower and upper bounds of the scaled step.

    Attributes:
        x: Of the states, shape (2, N+1, nx); the start is fixed.
        u: Of the inputs, shape (2, N, nu).
        h: Of the step lengths, shape (2, P).
    """

    x: Array
    u: Array
    h: Array


def trust_region(knots: Knots, scaling: Scaling, radius: float) -> TrustRegion:
    """Return the trust region about knots; variables beyond a limit may stay there.

    Args:
        knots: Centre of the region.
        scaling: With all limits.
        radius: Largest scaled change of any variable.
    """
    x = _range(knots.x, scaling.x_bounds, scaling.x, radius)
    x[:, 0] = 0.0
    u = _range(knots.u, scaling.u_bounds, scaling.u, radius)
    lengths = knots.lengths
    limits = np.column_stack([np.broadcast_to(b, len(lengths)) for b in scaling.h_bounds])
    return TrustRegion(x, u, _range(lengths, limits, lengths, radius))


def inequalities_within(
    rows: LinearInequalities, scaling: Scaling, region: TrustRegion
) -> LinearInequalities:
    """Return the inequalities that some step in the region violates: the others are redundant."""
    last_x, last_u = region.x.shape[1] - 1, region.u.shape[1] - 1
    after = np.minimum(rows.knot + 1, last_x)
    least = (
        rows.value
        + _least(rows.dx * scaling.x, region.x[:, rows.knot])
        + _least(rows.dx_next * scaling.x, region.x[:, after])
        + _least(rows.du * scaling.u, region.u[:, np.minimum(rows.knot, last_u)])
    )
    return rows.part(np.flatnonzero(~(least >= 0)))


def _range(values: Array, bounds: Array, large: Array, radius: float) -> Array:
    lower = np.maximum(-radius, np.minimum((bounds[:, 0] - values) / large, 0.0))
    upper = np.minimum(radius, np.maximum((bounds[:, 1] - values) / large, 0.0))
    return np.stack([lower, upper])


def _least(slope: Array, limits: Array) -> Array:
    """Return the minimum of slope @ change over box bounds, shape (m,)."""
    return np.asarray(np.minimum(slope * limits[0], slope * limits[1]).sum(axis=-1))

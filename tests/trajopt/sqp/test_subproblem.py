"""Inequalities are left out of a program exactly where no change within the box breaks them."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.trajopt.nlp.decision import Knots, Scaling
from kinolab.trajopt.nlp.path_constraints import LinearInequalities
from kinolab.trajopt.sqp.subproblem import inequalities_within, trust_region

STEPS, NX, NU, COUNT = 5, 3, 2, 60
SCALING = Scaling(
    x=np.array([1.0, 2.0, 0.5]),
    u=np.array([1.0, 3.0]),
    x_bounds=np.array([[-1.0, 1.0], [-np.inf, 0.3], [-np.inf, np.inf]]),
    u_bounds=np.array([[-1.0, 1.0], [0.0, 3.0]]),
    h_bounds=(0.1, 0.1),
)
KNOTS = Knots(np.full((STEPS + 1, NX), 0.2), np.full((STEPS, NU), 0.5), 0.1)


def rows_of(rng: np.random.Generator) -> LinearInequalities:
    """Return inequalities with numbers, told apart by their values."""
    return LinearInequalities(
        rng.integers(STEPS, size=COUNT),
        rng.uniform(-0.2, 2.0, COUNT),
        rng.normal(size=(COUNT, NX)),
        rng.normal(size=(COUNT, NX)),
        rng.normal(size=(COUNT, NU)),
    )


def worst(rows: LinearInequalities, row: int, radius: float) -> float:
    """Return the least margin over all corners of the box, one variable after the other."""
    limits = trust_region(KNOTS, SCALING, radius)
    k, total = rows.knot[row], float(rows.value[row])
    for slope, large, least, most in (
        (rows.dx[row], SCALING.x, *limits.x[:, k]),
        (rows.dx_next[row], SCALING.x, *limits.x[:, k + 1]),
        (rows.du[row], SCALING.u, *limits.u[:, k]),
    ):
        for one, scale, low, high in zip(slope, large, least, most, strict=True):
            total += min(one * scale * low, one * scale * high)
    return total


@pytest.mark.parametrize("radius", [0.05, 0.5])
def test_an_inequality_is_kept_exactly_where_a_corner_of_the_box_breaks_it(radius: float) -> None:
    rows = rows_of(np.random.default_rng(1))
    kept = inequalities_within(rows, SCALING, trust_region(KNOTS, SCALING, radius))
    broken = [rows.value[i] for i in range(COUNT) if worst(rows, i, radius) < 0]
    assert 0 < len(broken) < COUNT
    assert kept.value.tolist() == broken


def test_a_box_holds_the_start_and_keeps_limits_and_trust_region() -> None:
    limits = trust_region(KNOTS, SCALING, 0.5)
    assert not limits.x[:, 0].any()
    assert not limits.h.any()
    x = KNOTS.x + limits.x * SCALING.x
    lower, upper = SCALING.x_bounds.T
    assert (x >= lower).all()
    assert (x <= upper).all()
    assert np.abs(limits.x).max() <= 0.5
    assert np.allclose(x[1, -1, :2], [0.7, 0.3])  # the trust region's side, and the limit's

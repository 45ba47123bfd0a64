"""Equations of motion as data against the machine's compiled ones."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab import systems
from kinolab.dynamics import Model
from kinolab.dynamics.model.flow_formulas import FlowFormulas
from kinolab.numerics import intervals


@pytest.mark.parametrize("name", ["diff_drive", "slip_steered", "crane", "car"])
def test_both_sides_have_the_derivatives_of_the_rates(name: str) -> None:
    """Two wheels of the same inertia are taken by sum and difference, which must not show."""
    model = Model(systems.get(name))
    flow, rng = FlowFormulas.of(model), np.random.default_rng(1)
    x, u = rng.uniform(0.1, 0.4, model.nx), rng.uniform(-0.1, 0.1, model.nu)
    entries = np.concatenate([x, u, model.parameter_vector()])
    varied = np.arange(model.nx + model.nu)
    slopes, bends = flow.second_order(intervals.point(entries[:, None]), varied, bent=True)
    assert bends is not None
    step = 1e-6
    by_x, by_u = model.jacobian(x, u)
    scale = np.abs(by_x).max()
    assert slopes.centre[:, :, 0] == pytest.approx(np.hstack([by_x, by_u]), abs=1e-9 * scale)
    for k in range(model.nx):
        away = step * np.eye(model.nx)[k]
        ahead, back = model.jacobian(x + away, u), model.jacobian(x - away, u)
        change = (np.hstack(ahead) - np.hstack(back)) / (2.0 * step)
        assert bends.centre[:, k, :, 0] == pytest.approx(change, abs=1e-5 * scale)

"""The derivative of a step is that of the integrator's own map, on every kind of state space."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab import systems
from kinolab.simulation.sensitivities import StepSensitivities

MACHINES = (
    "pendulum",
    "unicycle2_v0",
    "quad2d_v0",
    "quad3d_v0",
    "submarine",
    "crane",
    "snakeboard",
)
NUDGE = 1e-5  # of every entry


@pytest.mark.parametrize("substeps", [1, 3])
@pytest.mark.parametrize("method", ["euler", "rk4", "rosenbrock"])
@pytest.mark.parametrize("name", MACHINES)
def test_derivatives_are_those_of_the_machines_own_step(
    name: str, method: str, substeps: int
) -> None:
    """Central differences of ``model.step``: rounding leaves about 1e-10, curvature 1e-10."""
    model = systems.get(name).model()
    generator = np.random.default_rng(1)
    x = model.rest() + 0.3 * generator.uniform(-1, 1, model.nx)
    x = model.project(x)
    u = np.clip(generator.uniform(-1, 1, model.nu), *model.control_bounds.T)
    h = 0.05

    def step(z: np.ndarray) -> np.ndarray:
        state, held, length = np.split(z, [model.nx, model.nx + model.nu])
        return model.step(state, held, float(length[0]), method=method, substeps=substeps)

    z = np.concatenate([x, u, [h]])
    expected = np.column_stack(
        [(step(z + d) - step(z - d)) / (2 * NUDGE) for d in NUDGE * np.eye(len(z))]
    )
    after, tangents = StepSensitivities(model, method, substeps).linearized(x[None], u[None], h)
    assert np.allclose(after[0], step(z), rtol=0, atol=1e-14)
    assert np.allclose(tangents[0], expected, rtol=1e-7, atol=1e-7)


def test_derivatives_in_fewer_substeps_leave_the_step_as_it_is() -> None:
    model = systems.get("pendulum").model()
    x, u = np.full((3, model.nx), 0.1), np.zeros((3, model.nu))
    fine, coarse = (StepSensitivities(model, "rk4", n).linearized(x, u, 0.2) for n in (8, 2))
    after, tangents = StepSensitivities(model, "rk4", 8, derived=2).linearized(x, u, 0.2)
    assert np.array_equal(after, fine[0])
    assert np.array_equal(tangents, coarse[1])
    assert not np.array_equal(coarse[0], fine[0])


def test_a_step_that_fails_says_so() -> None:
    model = systems.get("quad2d_v0").model()
    after = StepSensitivities(model, "rk4", 1).after(
        np.full((1, model.nx), np.nan), np.zeros((1, 2)), 0.1
    )
    assert np.isnan(after).all()

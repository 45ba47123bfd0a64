"""The derivative of a step is that of the integrator's own map, on every kind of state space."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from kinolab import systems
from kinolab.dynamics import (
    Body,
    Control,
    Potential,
    System,
    Viscous,
    Wrench,
    length,
    move,
    rate,
)
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.simulation.dop853_coefficients import DOP853
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


def spring() -> System:
    """Return a mass of 1 kg on a spring of 4 N/m with a damper of 0.2 N s/m, and a push."""
    x, push = length("x"), Control("push", limit=2.0, unit="N")
    mass = Body("mass", move(x, 0, 0), mass=1.0)
    pushed = Wrench(on=mass, force=(push.symbol, 0, 0))
    return System(
        "spring",
        bodies=[mass],
        inputs=[push],
        efforts=[pushed, Potential(2 * x**2), Viscous(rate(x), 0.2)],
    )


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
    after, tangents = StepSensitivities(model, METHODS[method], substeps).linearized(
        x[None], u[None], h
    )
    assert np.allclose(after[0], step(z), rtol=0, atol=1e-14)
    assert np.allclose(tangents[0], expected, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize(("substeps", "error"), [(1, 3e-5), (2, 1e-7), (4, 4e-10)])
def test_order_eight_is_as_accurate_as_it_should_be(substeps: int, error: float) -> None:
    """A mass on a spring is linear: a matrix exponential gives its steps and their derivatives."""
    model = spring().model()
    A, b = np.array([[0.0, 1.0], [-4.0, -0.2]]), np.array([[0.0], [1.0]])
    x, u, h = np.array([[0.3, -0.5]]), np.array([[0.7]]), 1.0
    flow = scipy.linalg.expm(h * np.block([[A, b], [np.zeros((1, 3))]]))[:2]
    ends = flow @ np.array([0.3, -0.5, 0.7])
    slope = A @ ends + b[:, 0] * 0.7
    after, tangents = StepSensitivities(model, DOP853, substeps).linearized(x, u, h)
    assert np.abs(after[0] - ends).max() < error
    assert np.abs(tangents[0] - np.column_stack([flow, slope])).max() < 20 * error


@pytest.mark.parametrize("name", ["submarine", "crane", "snakeboard"])
def test_derivatives_of_order_eight_are_those_of_its_own_steps(name: str) -> None:
    model = systems.get(name).model()
    generator = np.random.default_rng(1)
    x = model.project(model.rest() + 0.3 * generator.uniform(-1, 1, model.nx))
    u = np.clip(generator.uniform(-1, 1, model.nu), *model.control_bounds.T)
    step, h = StepSensitivities(model, DOP853, 2), 0.05
    z = np.concatenate([x, u, [h]])

    def after(z: np.ndarray) -> np.ndarray:
        state, held, length = np.split(z, [model.nx, model.nx + model.nu])
        return step.after(state[None], held[None], float(length[0]))[0]

    expected = np.column_stack(
        [(after(z + d) - after(z - d)) / (2 * NUDGE) for d in NUDGE * np.eye(len(z))]
    )
    ends, tangents = step.linearized(x[None], u[None], h)
    assert np.allclose(ends[0], model.step(x, u, h, substeps=64), rtol=0, atol=1e-9)
    assert np.allclose(tangents[0], expected, rtol=1e-7, atol=1e-7)


def test_derivatives_in_fewer_substeps_leave_the_step_as_it_is() -> None:
    model = systems.get("pendulum").model()
    x, u = np.full((3, model.nx), 0.1), np.zeros((3, model.nu))
    fine, coarse = (
        StepSensitivities(model, METHODS["rk4"], n).linearized(x, u, 0.2) for n in (8, 2)
    )
    after, tangents = StepSensitivities(model, METHODS["rk4"], 8, derived=2).linearized(x, u, 0.2)
    assert np.array_equal(after, fine[0])
    assert np.array_equal(tangents, coarse[1])
    assert not np.array_equal(coarse[0], fine[0])


def test_a_step_that_fails_says_so() -> None:
    model = systems.get("quad2d_v0").model()
    after = StepSensitivities(model, METHODS["rk4"], 1).after(
        np.full((1, model.nx), np.nan), np.zeros((1, 2)), 0.1
    )
    assert np.isnan(after).all()

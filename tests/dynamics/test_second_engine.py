"""Derived machines against a rigid-body engine that was written by others."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinolab import systems
from kinolab.dynamics import Model
from tests import machines
from tests.oracles import second_engine

Array = NDArray[np.float64]
State = tuple[Array, Array, Array]  # q, all velocities v, and u

# Shares of the largest entry. Both sides are exact but for rounding, 1e-16 per operation.
SUMMED = 1e-14  # a hundred sums and products
SOLVED = 1e-11  # the same times the condition of the mass matrix, at most 1300 (the wheeled hull)
DIFFERENCED = 1e-10  # the engine's q_dot is a difference, good to 2e-11
# A machine with multipliers is softened by 1e-13 of the trace of A M^-1 A^T. Here the trace is at
# most 33 times the smallest eigenvalue that is not zero, and what the loop adds to the
# accelerations at most 9 times what is left of them: 3e-11 in all.
SOFTENED = 1e-10

STATES = 50
TREES = {
    "double_pendulum_3d": second_engine.double_pendulum_3d,
    "arm": second_engine.arm,
    "wheeled_hull": second_engine.wheeled_hull,
}
TELESCOPES = {"satellite": (0, 1, 2), "satellite_two_wheels": (0, 1)}
LOOPS = ("four_bar", "four_bar_by_multipliers")


@cache
def model_of(name: str) -> Model:
    make = machines.MACHINES.get(name)
    return (systems.get(name) if make is None else make()).model()


def close(actual: Array, expected: Array, tolerance: float) -> None:
    """Hold the largest error below a share of the largest entry."""
    atol = tolerance * float(np.abs(expected).max())
    np.testing.assert_allclose(actual, expected, rtol=0, atol=atol)


def states(name: str) -> list[State]:
    """Return states all over the circles and SO(3), speeds up to 3 rad/s, inputs up to 5 N m."""
    model, rng = model_of(name), np.random.default_rng(11)
    made = []
    for _ in range(STATES):
        q = rng.uniform(-np.pi, np.pi, model.nq)
        if "R_w" in model.coordinate_names:
            first = model.coordinate_names.index("R_x")
            q[first : first + 4] = Rotation.from_quat(rng.normal(size=4)).as_quat()  # x, y, z, w
        made.append((q, rng.uniform(-3, 3, model.nt), rng.uniform(-5, 5, model.nu)))
    return made


def loop_states() -> list[State]:
    """Return states of the four-bar loop, on both of its branches."""
    rng, made = np.random.default_rng(12), []
    for k in range(STATES):
        state = second_engine.four_bar_state(
            rng.uniform(-np.pi, np.pi), rng.uniform(-3, 3), 1 - 2 * (k % 2)
        )
        made.append((*state, rng.uniform(-5, 5, 1)))
    return made


@pytest.mark.parametrize("name", TREES)
def test_the_mass_matrix_is_that_of_another_engine(name: str) -> None:
    model, engine = model_of(name), TREES[name]()
    for q, _, _ in states(name):
        close(model.mass_matrix(q), engine.mass_matrix(q), SUMMED)


@pytest.mark.parametrize("name", TREES)
def test_bias_forces_are_those_of_another_engine(name: str) -> None:
    """Gravity, Coriolis and gyroscopic forces: what M v_dot balances without inputs."""
    model, engine = model_of(name), TREES[name]()
    for q, v, _ in states(name):
        v_dot = model.f(np.concatenate([q, v]))[model.nq :]
        close(-engine.mass_matrix(q) @ v_dot, engine.bias(q, v), SOLVED)


@pytest.mark.parametrize("name", TREES)
def test_motion_is_that_of_another_engine(name: str) -> None:
    model, engine = model_of(name), TREES[name]()
    for q, v, u in states(name):
        q_dot, v_dot = np.split(model.f(np.concatenate([q, v]), u), [model.nq])
        close(q_dot, engine.change(q, v), DIFFERENCED)
        close(v_dot, engine.accelerations(q, v, u), SOLVED)


FLYERS = {
    "floating_satellite": second_engine.floating_satellite,
    "helicopter": second_engine.helicopter,
}


@pytest.mark.parametrize("name", FLYERS)
def test_a_free_flyer_is_that_of_another_engine(name: str) -> None:
    """The engine's linear velocity w is in the body's axes: x_dot = R w, so w_dot turns too."""
    model, engine = model_of(name), FLYERS[name]()
    for q, v, u in states(name):
        u = np.abs(u) if name == "helicopter" else u  # noqa: PLW2901  # rotors do not pull
        R = Rotation.from_quat(q[3:]).as_matrix()
        seen = np.eye(6)
        seen[:3, :3] = R.T  # from kinolab's velocities to the engine's
        close(model.mass_matrix(q), seen.T @ engine.mass_matrix(q) @ seen, SUMMED)
        moved = seen @ v
        q_dot, v_dot = np.split(model.f(np.concatenate([q, v]), u), [model.nq])
        close(q_dot, engine.change(q, moved), DIFFERENCED)
        expected = engine.accelerations(q, moved, u)
        expected[:3] = R @ (expected[:3] + np.cross(v[3:], moved[:3]))
        close(v_dot, expected, SOLVED)


@pytest.mark.parametrize(("name", "axes"), TELESCOPES.items())
def test_a_satellite_turns_as_one_that_flies_in_another_engine(
    name: str, axes: tuple[int, ...]
) -> None:
    """Where it flies does not matter, so that the engine's first three velocities stay apart."""
    model, engine = model_of(name), second_engine.space_telescope(axes)
    for q, v, u in states(name):
        whole, moving = np.append(np.ones(3), q), np.append(np.zeros(3), v)
        M = engine.mass_matrix(whole)
        np.testing.assert_allclose(M[:3, 3:], 0.0, rtol=0, atol=1e-13)
        close(model.mass_matrix(q), M[3:, 3:], SUMMED)
        v_dot = model.f(np.concatenate([q, v]))[model.nq :]
        close(-M[3:, 3:] @ v_dot, engine.bias(whole, moving)[3:], SOLVED)
        q_dot, v_dot = np.split(model.f(np.concatenate([q, v]), u), [model.nq])
        close(q_dot, engine.change(whole, moving)[3:], DIFFERENCED)
        close(v_dot, engine.accelerations(whole, moving, u)[3:], SOLVED)


@pytest.mark.parametrize("name", LOOPS)
def test_the_mass_matrix_of_a_loop_is_that_of_its_open_tree(name: str) -> None:
    model, engine = model_of(name), second_engine.four_bar()
    for q, _, _ in loop_states():
        close(model.mass_matrix(q), engine.mass_matrix(q), SUMMED)


def test_a_loop_moves_as_in_another_engine() -> None:
    model, engine = model_of("four_bar"), second_engine.four_bar()
    for q, v, u in loop_states():
        x = np.array([*q, v[0]])
        v_dot, force = engine.loop_dynamics(q, v, u)
        close(model.velocity(x), v, SOLVED)
        f = model.f(x, u)
        close(f[:3], v, SOLVED)
        close(f[3:], v_dot[:1], SOLVED)
        close(model.constraint_forces(x, u), force[:2], SOLVED)


def test_a_loop_with_a_repeated_constraint_moves_as_in_another_engine() -> None:
    """The third constraint is twice the first, so their shares of the force are not unique."""
    model, engine = model_of("four_bar_by_multipliers"), second_engine.four_bar()
    for q, v, u in loop_states():
        x = np.concatenate([q, v])
        v_dot, force = engine.loop_dynamics(q, v, u)
        close(model.f(x, u)[3:], v_dot, SOFTENED)
        along_x, along_y, along_x_twice = model.constraint_forces(x, u)
        close(np.array([along_x + 2 * along_x_twice, along_y]), force[:2], SOFTENED)

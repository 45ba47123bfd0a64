"""A direction, a coordinate on the sphere S^2: a spherical pendulum moves past both poles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import kstest

import kinolab
from kinolab.analyze.describe.topology import space_of
from kinolab.dynamics import (
    WORLD,
    Body,
    Force,
    Model,
    Sphere,
    System,
    direction,
    linear_controllability,
    move,
    parameter,
    toward,
)
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.dynamics.model.second_derivation import SecondDerivation
from kinolab.errors import InputError
from kinolab.numerics.manifolds.state_parts import Directions
from kinolab.numerics.rng import generator, unit_vector
from kinolab.problem.goal import Goal, PartTarget
from kinolab.problem.goal_kernel import goal_arrays, state_violation
from kinolab.show.film.animation import animate
from kinolab.verification import verify
from tests.javascript_engine import Engine
from tests.support import needs

Array = NDArray[np.float64]

LENGTH, GRAVITY, MASS = 0.7, 9.81, 1.3  # [m], [m/s^2], [kg]
ROUNDING = 1e-13


def spherical_pendulum() -> System:
    """A point mass on a massless rod that may point anywhere, pushed along three axes.

    Source: Lee, Leok, McClamroch, Global Formulations of Lagrangian and Hamiltonian Dynamics on
    Manifolds, 2018, section 5.5.
    """
    x, y, z = direction("d", speed=20.0)
    m, rod = parameter("m", MASS, "kg"), parameter("l", LENGTH, "m")
    bob = Body("bob", move(rod * x, rod * y, rod * z), mass=m, shape=Sphere(0.05))
    axes = {"x": WORLD.x, "y": WORLD.y, "z": WORLD.z}
    pushes = [Force(f"f_{name}", on=bob, along=axis, limit=8.0) for name, axis in axes.items()]
    return System("spherical", bodies=[bob], inputs=pushes, gravity=toward("-z", GRAVITY))


@pytest.fixture(scope="module")
def model() -> Model:
    return spherical_pendulum().model()


def states(count: int, seed: int = 0) -> Array:
    """Directions of all kinds, both poles among them, that turn at about 4 rad/s."""
    random = np.random.default_rng(seed)
    d = random.normal(size=(count, 3))
    d[:2] = [[0, 0, 1], [0, 0, -1]]
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return np.hstack([d, np.cross(random.normal(size=(count, 3)) * 3, d)])


def by_hand(x: Array, u: Array) -> Array:
    """d'' = -|d'|^2 d + (1 - d d^T)(g + u / m) / l, as in the book."""
    d, v = np.split(x, 2, axis=-1)
    pull = np.array([0, 0, -GRAVITY]) + u / MASS
    aside = pull - np.sum(d * pull, axis=-1, keepdims=True) * d
    bend = -np.sum(v * v, axis=-1, keepdims=True) * d
    return np.hstack([v, bend + aside / LENGTH])


def test_it_moves_as_the_book_says(model: Model) -> None:
    x, u = states(50), np.random.default_rng(1).uniform(-8, 8, (50, 3))
    np.testing.assert_allclose(model.f(x, u), by_hand(x, u), rtol=1e-12, atol=1e-12)


def test_both_derivations_agree(model: Model) -> None:
    x, u = states(50), np.random.default_rng(1).uniform(-8, 8, (50, 3))
    found = SecondDerivation(model).derivative(x, u)
    np.testing.assert_allclose(found, by_hand(x, u), rtol=1e-9, atol=1e-9)


def test_an_unforced_swing_keeps_its_energy_and_its_spin(model: Model) -> None:
    """About the vertical, too; half a step errs by a sixteenth of it and less (order 4)."""

    def drift(steps: int) -> tuple[float, float, float]:
        x = states(3)[2]
        energy = sum(model.energy(x))
        spin = np.cross(x[:3], x[3:])[2]
        for _ in range(steps):
            x = model.step(x, np.zeros(3), 4.0 / steps)
        apart = np.cross(x[:3], x[3:])[2] - spin
        return abs(sum(model.energy(x)) - energy), abs(apart), abs(np.linalg.norm(x[:3]) - 1)

    coarse, fine = drift(400), drift(800)
    assert fine[0] < min(coarse[0] / 8, 1e-4)  # [J] of about 10
    assert fine[1] < 1e-4
    assert max(coarse[2], fine[2]) < ROUNDING


def test_a_step_is_of_fourth_order(model: Model) -> None:
    x, u = states(3)[2], np.array([3.0, -2.0, 1.0])

    def error(h: float) -> float:
        return float(np.abs(model.step(x, u, h) - model.step(x, u, h, substeps=64)).max())

    assert error(0.04) / error(0.02) == pytest.approx(32.0, rel=0.3)  # O(h^5) in a step


def test_eulers_step_follows_the_great_circle(model: Model) -> None:
    """cos(|v| h) d + sin(|v| h) v / |v|."""
    x, h = states(20), 0.05
    after = np.array([model.step(row, np.zeros(3), h, method="euler") for row in x])
    d, v = np.split(x, 2, axis=1)
    speed = np.linalg.norm(v, axis=1, keepdims=True)
    expected = np.cos(h * speed) * d + np.sin(h * speed) * v / speed
    np.testing.assert_allclose(after[:, :3], expected, rtol=0, atol=ROUNDING)


def test_differences_are_chords_and_lead_back(model: Model) -> None:
    space, x, y = model.space, states(50), states(50, 1)
    chord = space.difference(x, y)[:, :3]
    np.testing.assert_array_equal(chord, y[:, :3] - x[:, :3])  # d and -d are two directions
    np.testing.assert_allclose(space.retract(x, space.difference(x, y)), y, atol=ROUNDING)
    angles = np.arccos(np.clip(np.sum(x[:, :3] * y[:, :3], axis=1), -1, 1))
    (part,) = space.spheres
    np.testing.assert_allclose(part.distance(x[:, :3], y[:, :3]), angles, atol=1e-7)
    np.testing.assert_allclose(2 * np.sin(angles / 2), np.linalg.norm(chord, axis=1), atol=1e-7)
    np.testing.assert_array_equal(space.nearest(x, y), y)


def test_draws_are_uniform_and_as_near_as_asked_for() -> None:
    """On the sphere every coordinate is uniform (Archimedes)."""
    part, random = Directions("d", 0, 3), np.random.default_rng(0)
    for heights in part.random(random, 2000).T:
        assert kstest(heights, "uniform", args=(-1.0, 2.0)).pvalue > 0.01
    value = part.random(random)
    near = part.near(value, np.full(2000, 0.4), random)
    np.testing.assert_allclose(np.linalg.norm(near, axis=1), 1.0, atol=ROUNDING)
    assert kstest(np.arccos(near @ value), "uniform", args=(0.0, 0.4)).pvalue > 0.01
    basis = part.tangents(value)
    np.testing.assert_allclose(basis.T @ basis, np.eye(2), atol=ROUNDING)
    np.testing.assert_allclose(value @ basis, 0.0, atol=ROUNDING)


def test_compiled_loops_draw_it_and_measure_it() -> None:
    state, drawn = generator(0), np.empty((2000, 3))
    for row in drawn:
        unit_vector(state, row)
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1.0, atol=ROUNDING)
    for heights in drawn.T:
        assert kstest(heights, "uniform", args=(-1.0, 2.0)).pvalue > 0.01
    target, tolerance = (0.6, 0.0, -0.8), 0.1  # [rad]
    wanted = PartTarget(Directions("d", 0, 3), target, tolerance)
    goal = goal_arrays(Goal((), np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool), parts=(wanted,)))
    for d in drawn[:50]:
        angle = np.arccos(d @ target)
        assert state_violation(goal, d, np.inf) == pytest.approx(angle / tolerance, rel=1e-6)
        assert wanted.error(d) == pytest.approx(angle, rel=1e-6)


def test_it_is_described_and_written_as_a_sphere() -> None:
    system = spherical_pendulum()
    assert space_of(system) == "S^2"
    text = machine_to_json(system)
    assert machine_to_json(machine_from_json(text)) == text


def test_a_hanging_pendulum_is_pushed_along_all_of_its_sphere(model: Model) -> None:
    """Its four directions of motion; a push along the rod does nothing but rounding."""
    found = linear_controllability(model, [0, 0, -1, 0, 0, 0])
    assert (found.rank, found.dimension, found.controllable) == (4, 4, True)


def test_a_direction_needs_all_its_entries() -> None:
    x, _, z = direction("d")
    bob = Body("bob", move(x, 0, z), mass=1.0)
    with pytest.raises(InputError, match="one of its entries does not occur"):
        System("flat", bodies=[bob])


def test_the_page_makes_the_same_step(model: Model) -> None:
    x, u = states(3)[2], np.array([1.0, 2.0, -3.0])
    for method in ("rk4", "euler"):
        with Engine() as engine:
            step = f"{engine.machine(model)}.step(a, b, 0.02, undefined, '{method}', 2)"
            found = engine.run(f"return Array.from({step})", x.tolist(), u.tolist())
        expected = model.step(x, u, 0.02, method=method, substeps=2)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


@pytest.fixture(scope="module")
def problem() -> Any:
    """From before the lower pole to beyond the upper one, at a speed that leads past both."""
    return kinolab.load(
        {
            "system": spherical_pendulum(),
            "start": {"d_x": 0.28, "d_z": -0.96, "d_x_dot": -9.6, "d_z_dot": -2.8},
            "goal": {
                "d_x": 0.28,
                "d_z": 0.96,
                "at_rest": False,
                "tolerance": {"d_x": 0.25, "d_z": 0.25},
            },
            "planner": {"name": "rrt_fast", "improve": 0},
        }
    )


@needs("ompl")
def test_ompl_keeps_it_and_measures_chords(problem: Any) -> None:
    from kinolab.search.ompl.spaces import StateCodec

    codec, (x, y) = StateCodec(problem), states(4)[2:]
    here, there = (codec.space.allocState() for _ in range(2))
    codec.write(here, (2 * x).tolist())  # of which only the direction counts
    codec.write(there, [*y[:3], *(2 * x[3:])])
    np.testing.assert_allclose(codec.read(here), [*x[:3], *(2 * x[3:])], atol=ROUNDING)
    chord = float(np.linalg.norm(x[:3] - y[:3]))
    assert codec.space.distance(here, there) == pytest.approx(chord, rel=1e-12)


def test_a_plan_leads_past_both_poles_and_is_certified(problem: Any, tmp_path: Path) -> None:
    plan = problem.solve(seed=1, time_limit=60.0)
    assert plan.trajectory is not None
    certificate = verify(problem, plan.trajectory)
    assert certificate.passed, certificate
    d = plan.trajectory.x[:, :3]
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1.0, atol=1e-9)
    assert d[:, 2].min() < -0.97
    assert d[:, 2].max() > 0.9
    kinolab.save_page(problem, plan, tmp_path / "page.html")
    assert "bob" in (tmp_path / "page.html").read_text()
    assert animate(problem, plan.trajectory).startswith(b"GIF8")

"""Motions in flat outputs: they end where they must, within limits, and touch nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import kinolab
from kinolab import planners
from kinolab.dynamics import (
    Body,
    Capsule,
    Control,
    Sphere,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    length,
    move,
    rate,
    rot_z,
)
from kinolab.errors import InputError
from kinolab.search import Budget, Outcome, SearchResult
from tests.support import OPEN, coin_motion, problem_of

Array = NDArray[np.float64]

PUSH, SPEED, STEP = 0.2, 0.3, 0.1  # [m/s^2], [m/s], [s]
RODS = (0.6, 0.5)  # [m]
FINE = 1e-3  # [s] between looks


def point() -> System:
    """Return a point in the plane whose acceleration is given."""
    x, y = length("x", speed=SPEED), length("y", speed=SPEED)
    body = Body("point", move(x, y, 0.1), mass=1.0, inertia=(1e-3,) * 3, shape=Sphere(0.01))
    pushes = [Control(f"a{name}", limit=PUSH, unit="m/s^2") for name in "xy"]
    force = (pushes[0].symbol, pushes[1].symbol, 0)
    return System("point", bodies=[body], inputs=pushes, efforts=[Wrench(on=body, force=force)])


def arm() -> System:
    """Return two rods in the plane, each with a motor and friction at its joint."""
    a, b = angle("a", speed=3.0), angle("b", speed=3.0)
    first = rot_z(a) @ move(RODS[0] / 2, 0, 0)
    second = first @ move(RODS[0] / 2, 0, 0) @ rot_z(b) @ move(RODS[1] / 2, 0, 0)
    rods = [
        Body(name, frame, mass=m, inertia=(1e-3, 0.02, 0.02), shape=Capsule(0.02, size, axis="x"))
        for name, frame, m, size in (("one", first, 1.0, RODS[0]), ("two", second, 0.8, RODS[1]))
    ]
    motors = [
        Torque("shoulder", on=rods[0], about=first.z, limit=3.0),
        Torque("elbow", on=rods[1], about=second.z, limit=1.5, reacts_on=rods[0]),
    ]
    return System(
        "arm", bodies=rods, inputs=motors, efforts=[Viscous(rate(a), 0.1), Viscous(rate(b), 0.1)]
    )


def walls(*boxes: tuple[float, float, float, float]) -> list[dict[str, Any]]:
    """Return boxes by their places x, y and sizes in the plane."""
    return [{"box": [w, d, 1.0], "position": [x, y, 0.0]} for x, y, w, d in boxes]


@pytest.fixture(scope="module")
def gates() -> kinolab.Problem:
    """A point between two walls with gates at opposite ends."""
    return kinolab.load(
        {
            "schema": 1,
            "title": "A point",
            "world": {
                "bounds": {"x": [0.0, 3.0], "y": [0.0, 1.0]},
                "obstacle": walls((1.0, 0.4, 0.1, 0.8), (2.0, 0.6, 0.1, 0.8)),
            },
            "bounds": {"x": [0.0, 3.0], "y": [0.0, 1.0]},
            "start": {"x": 0.3, "y": 0.3},
            "goal": {"x": 2.7, "y": 0.7, "at_rest": True, "tolerance": 0.02},
            "integration": {"step": STEP},
            "system": point(),
        }
    )


def found_by(problem: Any, seed: int, **settings: int) -> SearchResult:
    searcher = planners.make("flat_connect", settings)
    found = searcher.solve(problem, seed, Budget(60.0, max_iterations=20_000))
    assert found.outcome is Outcome.SOLVED
    return found


@pytest.mark.parametrize("shortcuts", [0, 200])
@pytest.mark.parametrize("seed", range(3))
def test_a_point_keeps_its_limits_and_ends_in_the_goal(
    seed: int, shortcuts: int, gates: kinolab.Problem
) -> None:
    """Held accelerations have a closed form, and so has the way round a box."""
    u = found_by(gates, seed, shortcuts=shortcuts).u
    assert np.abs(u).max() <= PUSH * (1 + 1e-12)
    v = np.vstack([np.zeros(2), np.cumsum(u * STEP, axis=0)])
    assert np.abs(v).max() <= SPEED * (1 + 1e-9)
    t = np.arange(0.0, STEP, FINE)[:, None]
    ways = np.cumsum(v[:-1] * STEP + u * STEP**2 / 2, axis=0)
    knots = np.array([0.3, 0.3]) + np.vstack([np.zeros(2), ways])
    places = (knots[:-1, None] + v[:-1, None] * t + u[:, None] * t**2 / 2).reshape(-1, 2)
    assert np.abs(knots[-1] - [2.7, 0.7]).max() <= 0.02
    for x, y, w, d in ((1.0, 0.4, 0.1, 0.8), (2.0, 0.6, 0.1, 0.8)):
        beside = np.maximum(np.abs(places - [x, y]) - [w / 2, d / 2], 0.0)
        assert np.linalg.norm(beside, axis=1).min() > 0.01  # the ball's radius


def test_shortcuts_make_motions_shorter(gates: kinolab.Problem) -> None:
    for seed in range(5):
        plain, short = (len(found_by(gates, seed, shortcuts=n, rounds=1).u) for n in (0, 200))
        assert short < plain, f"seed {seed}"


def test_more_rounds_never_make_a_motion_longer(gates: kinolab.Problem) -> None:
    one, three = (len(found_by(gates, 1, rounds=rounds).u) for rounds in (1, 3))
    assert three <= one


@pytest.mark.parametrize("seed", range(3))
def test_a_coin_goes_round_a_wall(seed: int, tmp_path: Path) -> None:
    """Its motion is that of the closed form, at which FCL finds no contact every millisecond."""
    wall = "\n[[world.obstacle]]\nbox = [0.2, 3.0, 1.0]\nposition = [-0.5, 0.0, 0.5]\n"
    problem = problem_of(tmp_path, OPEN + wall, "start.x=-2", "goal.x=1", "goal.tolerance=0.1")
    found = found_by(problem, seed)
    steps = round(problem.step / FINE)
    times = np.arange(len(found.u) * steps + 1) * FINE
    motion = coin_motion(problem.start, times, np.repeat(found.u, steps, axis=0))
    assert np.hypot(*(motion.x[-1, :2] - [1.0, 0.0])) <= 0.1 * np.sqrt(2)
    checker = problem.checker()
    poses, _ = problem.placement(motion.x)
    assert checker.first_collision(poses, None) is None


def rates(t: float, x: Array, u: Array) -> Array:  # noqa: ARG001
    """Return the state's rate of the arm by Lagrange's equations (Murray, Li, Sastry, 1994, 4.3).

    With slender rods about their middles: moments of inertia 0.02, masses 1.0 and 0.8.
    """
    a, b = RODS
    alpha = 0.02 + 0.02 + 1.0 * (a / 2) ** 2 + 0.8 * (a**2 + (b / 2) ** 2)
    beta, delta = 0.8 * a * b / 2, 0.02 + 0.8 * (b / 2) ** 2
    c, s = np.cos(x[1]), np.sin(x[1])
    mass = np.array([[alpha + 2 * beta * c, delta + beta * c], [delta + beta * c, delta]])
    turn = np.array([[-beta * s * x[3], -beta * s * (x[2] + x[3])], [beta * s * x[2], 0.0]])
    return np.concatenate([x[2:], np.linalg.solve(mass, u - turn @ x[2:] - 0.1 * x[2:])])


def test_an_arm_whose_inertia_changes_ends_where_it_must() -> None:
    problem = kinolab.load(
        {
            "schema": 1,
            "title": "An arm",
            "world": {"obstacle": walls((0.9, 0.5, 0.1, 0.1))},
            "start": {"a": 0.0, "b": 0.0},
            "goal": {"a": 1.6, "b": 0.5, "at_rest": True, "tolerance": 0.05},
            "integration": {"step": 0.02},
            "system": arm(),
        }
    )
    found = found_by(problem, 1)
    assert (np.abs(found.u) <= [3.0, 1.5]).all()
    x = np.zeros(4)
    for held in found.u:
        x = solve_ivp(rates, (0.0, 0.02), x, args=(held,), rtol=1e-9, atol=1e-11).y[:, -1]
    off = x - [1.6, 0.5, 0.0, 0.0]
    off[:2] = np.angle(np.exp(1j * off[:2]))  # it may come from either side
    assert np.abs(off).max() <= 0.05


@pytest.mark.parametrize(
    ("scenario", "why"),
    [
        ("crane_factory", "3 inputs do not accelerate 5 independent velocities at will."),
        ("satellite_pointing", "it has attitudes or states beside coordinates and velocities."),
        ("biped_walk", "it has modes, closed loops, or obstacles that move."),
    ],
)
def test_other_machines_are_refused(scenario: str, why: str) -> None:
    problem = kinolab.load(scenario)
    with pytest.raises(InputError) as caught:
        planners.get("flat_connect")().solve(problem, 1, Budget(1.0))
    told = f"flat_connect does not plan for the machine {problem.machine.name!r}: {why}"
    assert str(caught.value) == f"[planner] name: {told} auto plans for every machine."


def test_a_start_at_speed_is_refused(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "start.phi_dot=1.0")
    with pytest.raises(InputError, match="it does not start at rest"):
        problem.solve(planner="flat_connect")


def test_a_goal_in_which_nothing_can_rest_is_told(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "goal.phi_dot=4.0", "goal.tolerance=0.5")
    found = planners.get("flat_connect")().solve(problem, 1, Budget(5.0, max_iterations=100))
    assert found.outcome is Outcome.NOT_FOUND
    (warning,) = found.warnings
    assert warning.endswith("auto also plans for goals that are passed at speed.")

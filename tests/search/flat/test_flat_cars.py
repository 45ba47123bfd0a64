"""Motions of cars in flat outputs: they steer within limits, end where they must, touch nothing."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import ompl.base
import pytest
import sympy
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import kinolab
from kinolab import planners
from kinolab.dynamics import (
    CURVATURE,
    Body,
    Box,
    Drive,
    PlaneCurves,
    Rate,
    System,
    angle,
    length,
    move,
    rate,
    rot_y,
    rot_z,
    velocity,
    zero,
)
from kinolab.numerics.arrays import allocate
from kinolab.numerics.struct import Record
from kinolab.search import Budget, Outcome, SearchResult
from kinolab.simulation.reference import resimulate
from kinolab.steering.arc_words import ArcWord, shortest_word
from kinolab.steering.reeds_shepp import Arc

Array = NDArray[np.float64]

BASE, WHEEL = 0.5, 0.1  # [m] between axles, and of the driven wheel
STEP, FINE = 0.1, 1e-3  # [s] of inputs, and between looks
MOST = np.array([0.6, 1.0])  # speed in [m/s], steering rate in [rad/s]
HARDEST = np.array([3.0, 2.0])  # accelerations of the wheel and of the steering in [rad/s^2]


def buggy(*, reverses: bool = True) -> System:
    """Return a bicycle whose speed and steering rate are given: nothing has a mass."""
    x, y, psi = length("x"), length("y"), angle("psi")
    delta = angle("delta", -0.7, 0.7)
    rear = move(x, y, 0.2) @ rot_z(psi)
    speed = Rate("v", on=velocity(rear).x, limit=MOST[0] if reverses else (0.0, MOST[0]))
    return System(
        "buggy",
        bodies=[Body("frame", rear @ move(BASE / 2), shape=Box(0.7, 0.3, 0.2))],
        constraints=[
            zero(velocity(rear).y, "no sideslip behind"),
            zero(velocity(rear @ move(BASE) @ rot_z(delta)).y, "no sideslip in front"),
        ],
        inputs=[speed, Rate("steer", on=delta, limit=MOST[1])],
        flat=PlaneCurves(x, y, psi, steered=((delta, sympy.atan(BASE * CURVATURE)),)),
    )


def tricycle() -> System:
    """Return a vehicle whose driven wheel and whose steering are accelerated as wanted."""
    x, y, psi = length("x"), length("y"), angle("psi")
    delta, phi = angle("delta", -0.6, 0.6, speed=MOST[1]), angle("phi", speed=MOST[0] / WHEEL)
    rear = move(x, y, 0.2) @ rot_z(psi)
    V, front = velocity(rear), rear @ move(BASE) @ rot_z(delta)
    return System(
        "tricycle",
        bodies=[
            Body("frame", rear @ move(BASE / 2), mass=8.0, inertia=0.5, shape=Box(0.7, 0.3, 0.2)),
            Body("axle", rear @ rot_y(phi), inertia=0.01),
            Body("fork", front, inertia=0.02),
        ],
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(velocity(front).y, "no sideslip in front"),
            zero(V.x - WHEEL * rate(phi), "rolling"),
        ],
        inputs=[
            Drive("drive", on=phi, limit=HARDEST[0]),
            Drive("steer", on=delta, limit=HARDEST[1]),
        ],
        velocities=[delta, phi],
        flat=PlaneCurves(x, y, psi, steered=((delta, sympy.atan(BASE * CURVATURE)),)),
    )


def problem_of(machine: System, **goal: float) -> kinolab.Problem:
    """Return a machine beside a wall, behind which the goal is."""
    return kinolab.load(
        {
            "schema": 1,
            "title": "Round a wall",
            "world": {
                "bounds": {"x": [-3.0, 3.0], "y": [-2.0, 2.0]},
                "obstacle": [{"box": [0.2, 2.4, 1.0], "position": [0.0, -0.8, 0.5]}],
            },
            "bounds": {"x": [-3.0, 3.0], "y": [-2.0, 2.0]},
            "start": {"x": -1.5, "y": -0.5},
            "goal": {"x": 1.5, "y": -0.5, "at_rest": True, "tolerance": 0.05, **goal},
            "integration": {"step": STEP},
            "system": machine,
        }
    )


def found_by(problem: Any, seed: int, **settings: int) -> SearchResult:
    searcher = planners.make("flat_connect", settings)
    found = searcher.solve(problem, seed, Budget(math.inf, max_iterations=20_000))
    assert found.outcome is Outcome.SOLVED
    return found


def end_of(x: Array, u: Array, *, first: bool) -> tuple[Array, Array]:
    """Return the last pose and steering, and speed and steering rate after each step.

    Args:
        x: Pose and steering at the beginning, at rest.
        u: Held speeds and steering rates, or accelerations of the wheel and of the steering.
        first: Which of them.
    """
    rates, speeds = np.zeros(2), []

    def slope(t: float, y: Array, held: Array, begin: Array) -> list[float]:
        v, w = held if first else (begin + held * t) * [WHEEL, 1.0]
        return [v * np.cos(y[2]), v * np.sin(y[2]), v * np.tan(y[3]) / BASE, w]

    for held in u:
        x = solve_ivp(slope, (0, STEP), x, args=(held, rates), rtol=1e-9, atol=1e-11).y[:, -1]
        rates = held if first else rates + held * STEP
        speeds.append(rates * (1.0 if first else [WHEEL, 1.0]))
    return x, np.array(speeds)


def touches(problem: kinolab.Problem, found: SearchResult) -> bool:
    """Say whether FCL finds a contact in the motion, looked at every millisecond."""
    steps = round(problem.step / FINE)
    times = np.arange(len(found.u) * steps + 1) * FINE
    motion = resimulate(problem, times, np.repeat(found.u, steps, axis=0))
    poses, cables = problem.placement(motion.x)
    return problem.checker().first_collision(poses, cables) is not None


def length_by_ompl(space: Any, begin: Array, end: Array) -> float:
    """Return how long OMPL's curve between two poses is, in [m]."""
    ends = [space.allocState(), space.allocState()]
    for state, pose in zip(ends, (begin, end), strict=True):
        state.setXY(*map(float, pose[:2]))
        state.setYaw(float(pose[2]))
    return float(space.distance(*ends))


@pytest.mark.parametrize("reverses", [True, False])
def test_words_are_as_short_as_those_of_ompl_and_lead_to_their_ends(reverses: bool) -> None:
    word, random, radius = allocate(ArcWord, {}), np.random.default_rng(1), 1.7
    kind = ompl.base.ReedsSheppStateSpace if reverses else ompl.base.DubinsStateSpace
    for k in range(300):
        begin = random.uniform([-8, -8, -4], [8, 8, 4])
        end = random.uniform([-8, -8, -4], [8, 8, 4])
        end = begin + random.normal(size=3) * 0.5 if k % 3 == 0 else end
        short = shortest_word(Record(word), begin, end, radius, reverses)
        pose = (float(begin[0]), float(begin[1]), float(begin[2]))
        assert short == pytest.approx(length_by_ompl(kind(radius), begin, end), abs=1e-6)
        for way, side in zip(word.length[: word.size[0]], word.side, strict=False):
            pose = Arc(float(way * radius), float(side / radius)).after(pose)
        off = np.array(pose) - end
        off[2] = np.angle(np.exp(1j * off[2]))
        assert np.abs(off).max() < 1e-9


@pytest.mark.parametrize("shortcuts", [0, 200])
@pytest.mark.parametrize(
    ("machine", "first", "slowest"),
    [(buggy(), True, -MOST[0]), (buggy(reverses=False), True, 0.0), (tricycle(), False, -MOST[0])],
)
def test_cars_keep_their_limits_and_end_in_the_goal(
    machine: System, first: bool, slowest: float, shortcuts: int
) -> None:
    """Integrated from the equations of a bicycle, which the code under test does not have."""
    problem = problem_of(machine)
    found = found_by(problem, 1, shortcuts=shortcuts)
    x, speeds = end_of(np.array([-1.5, -0.5, 0.0, 0.0]), found.u, first=first)
    assert np.abs(x[:2] - [1.5, -0.5]).max() <= 0.05
    assert (np.abs(speeds) <= MOST * (1 + 1e-9)).all()
    assert speeds[:, 0].min() >= slowest * (1 + 1e-9)
    assert (np.abs(found.u) <= (MOST if first else HARDEST) * (1 + 1e-12)).all()
    assert not touches(problem, found)


def test_shortcuts_make_drives_shorter_and_seeds_their_bits() -> None:
    problem = problem_of(tricycle(), psi=3.0)
    for seed in range(3):
        plain, short = (found_by(problem, seed, shortcuts=n).u for n in (0, 200))
        assert len(short) < len(plain), f"seed {seed}"
        np.testing.assert_array_equal(short, found_by(problem, seed, shortcuts=200).u)


def test_the_car_of_the_gallery_parks() -> None:
    problem = kinolab.load("vehicle_parking")
    found = found_by(problem, 1)
    motion = resimulate(problem, found.t, found.u)
    assert np.abs(motion.x[-1, :2] - [13.25, 12.15]).max() <= 0.2
    assert not touches(problem, found)

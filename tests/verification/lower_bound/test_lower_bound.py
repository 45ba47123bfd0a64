"""No plan is shorter than the bound, and the bound is what closed forms say."""

from __future__ import annotations

import csv
import math
import tomllib
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import kinolab
from kinolab.dynamics import (
    WORLD,
    Body,
    Force,
    Sphere,
    System,
    Torque,
    angle,
    length,
    move,
    rot_y,
    toward,
)
from kinolab.numerics.arrays import Array
from kinolab.verification.lower_bound import DurationBound, duration_bound
from kinolab.verification.lower_bound.shortest_path import arc_outside, shortest_path
from kinolab.verification.lower_bound.speed_limits import SpeedLimits
from tests.conftest import Solved

ROOT = Path(__file__).parents[3]
BEST_KNOWN = tomllib.loads((ROOT / "benchmarks/best_known.toml").read_text())
CLOSE = 1e-5  # relative: the bound leaves a millionth to the verifier's tolerances


def cart(speed: float = 100.0) -> System:
    """A mass of 2 kg on a line, pushed by at most 4 N: 2 m/s^2."""
    x = length("x", -10.0, 10.0, speed=speed)
    body = Body("cart", move(x), mass=2.0, shape=Sphere(0.1))
    push = Force("push", on=body, along=WORLD.x, limit=4.0)
    return System("cart", bodies=[body], inputs=[push])


def to_rest(system: System, way: float, **further: Any) -> kinolab.Problem:
    goal = {"x": way, "at_rest": True, "tolerance": {"x": 0.1, "x_dot": 0.05}}
    return kinolab.load({"title": "From rest to rest", "system": system, "goal": goal, **further})


def test_the_bound_of_a_double_integrator_is_its_least_time() -> None:
    """It speeds up to v and brakes to the 0.05 m/s that the goal allows: v^2 = a L + w^2 / 2."""
    a, w, way = 2.0, 0.05, 2.9
    v = math.sqrt(a * way + w**2 / 2)
    assert duration_bound(to_rest(cart(), 3.0)).seconds == pytest.approx((2 * v - w) / a, rel=CLOSE)


def test_a_limited_speed_is_kept_between_speeding_up_and_braking() -> None:
    a, v, w, way = 2.0, 1.0, 0.05, 2.9
    ramps = v**2 / (2 * a) + (v**2 - w**2) / (2 * a)
    least = v / a + (v - w) / a + (way - ramps) / v
    found = duration_bound(to_rest(cart(speed=1.0), 3.0))
    assert found.seconds == pytest.approx(least, rel=CLOSE)
    assert found.seconds < least
    assert found.reason == "x has 2.9 m to go"


@pytest.mark.parametrize("seed", range(20))
def test_no_speed_within_its_limits_covers_a_way_in_less(seed: int) -> None:
    """Random motions that speed up and brake as their limits of each level let them."""
    rng = np.random.default_rng(seed)
    levels = np.linspace(0.0, rng.uniform(0.5, 2.0), 9)
    limits = SpeedLimits(levels[-1], levels, *rng.uniform(0.1, 3.0, (2, 8)))
    speeds = np.clip(np.cumsum(rng.normal(0.0, 0.2, 40)) + rng.uniform(0.0, 1.0), 0, levels[-1])
    time = way = 0.0
    for before, after in pairwise(speeds):  # as fast from one speed to the next as can be
        rate = limits.gain if after > before else limits.loss
        cuts = np.unique(np.clip(levels, min(before, after), max(before, after)))
        for low, high in pairwise(np.unique([*cuts, before, after])):
            taken = (high - low) / rate[int(np.searchsorted(levels, 0.5 * (low + high))) - 1]
            time, way = time + taken, way + taken * 0.5 * (low + high)
    assert limits.least_time(way, speeds[0], speeds[-1]) <= time * (1 + 1e-12)


def swinging() -> System:
    """A pendulum of 1 kg and 1 m whose motor lifts it anywhere."""
    theta = angle("theta", speed=100.0)
    bob = move(0, 0, 0) @ rot_y(theta) @ move(0, 0, -1)
    body = Body("bob", bob, mass=1.0, shape=Sphere(0.05))
    motor = Torque("motor", on=body, about=WORLD.y, limit=30.0)
    return System("swinging", bodies=[body], gravity=toward("-z", 9.81), inputs=[motor])


def test_the_bound_of_a_pendulum_is_below_its_least_time() -> None:
    """Full torque, then full torque back, ends upright at rest: as many switches as are needed."""
    goal = {"theta": math.pi, "at_rest": True, "tolerance": {"theta": 0.01, "theta_dot": 0.01}}
    found = duration_bound(
        kinolab.load({"title": "Up", "system": swinging(), "goal": goal})
    ).seconds

    def after(time: float, torque: float, x: Array) -> Array:
        rates = solve_ivp(
            lambda _, x: [x[1], torque - 9.81 * math.sin(x[0])], (0, time), x, rtol=1e-9, atol=1e-9
        )
        return np.asarray(rates.y[:, -1])

    def at_rest(switch: float) -> float:
        """Return when it rests again, having switched."""
        x = after(switch, 30.0, np.zeros(2))
        return float(brentq(lambda t: after(t, -30.0, x)[1], 1e-6, 2.0))

    def short(switch: float) -> float:
        x = after(switch, 30.0, np.zeros(2))
        return float(after(at_rest(switch), -30.0, x)[0] - math.pi)

    switch = brentq(short, 0.1, 0.5)
    least = switch + at_rest(switch)
    assert 0.8 * least < found < least


def puck() -> System:
    x, y = (length(name, -9.0, 9.0, speed=1.0) for name in "xy")
    body = Body("puck", move(x, y, 0.2), mass=1.0, shape=Sphere(0.1))
    axes = {"push_x": WORLD.x, "push_y": WORLD.y}
    pushes = [Force(name, on=body, along=axis, limit=1e4) for name, axis in axes.items()]
    return System("puck", bodies=[body], inputs=pushes)


def test_the_way_round_a_wall_is_that_of_a_taut_string() -> None:
    """A ball of 0.1 m goes round both corners of a wall, along a diagonal at the fastest."""
    wall = {"name": "wall", "box": [0.2, 8.0, 1.0], "position": [2.0, 0.0, 0.5]}
    problem = kinolab.load(
        {
            "title": "A wall",
            "system": puck(),
            "world": {"obstacle": [wall]},
            "goal": {"x": 4.0, "y": 0.0, "tolerance": 0.001},
        }
    )
    r, corner = 0.1, math.hypot(1.9, 4.0)
    turn = math.pi / 2 + math.atan2(4.0, 1.9) - math.acos(r / corner)  # about each corner
    taut = 2 * (math.sqrt(corner**2 - r**2) + r * turn) + 0.2
    found = duration_bound(problem)
    assert 0.97 * taut / math.sqrt(2) < found.seconds < taut / math.sqrt(2)
    assert found.reason.startswith("puck has 9.")


def test_a_taut_string_round_squares() -> None:
    """Five squares in a row stand between two points: closed form."""
    blocked = np.zeros((9, 9), dtype=bool)
    blocked[4, 2:7] = True
    found = shortest_path(blocked, np.array([0.5, 4.5]), np.array([8.5, 4.5]))
    assert found == pytest.approx(2 * math.hypot(3.5, 2.5) + 1.0)


def test_no_way_leads_between_squares_that_touch() -> None:
    """Both points stand on a line of the grid, and so does the straight way between them."""
    blocked = np.zeros((7, 7), dtype=bool)
    blocked[2:4] = True
    for turned in (blocked, blocked.T):
        ends = np.array([[0.5, 3.0], [6.5, 3.0]])[:, :: 1 if turned is blocked else -1]
        round_the_end = math.hypot(1.5, 3.0) + 2.0 + math.hypot(2.5, 3.0)
        assert shortest_path(turned, *ends) == pytest.approx(round_the_end)


@pytest.mark.parametrize("half", [0.2, 0.5, 0.9])
def test_the_way_round_a_cap_is_the_least_of_all_that_touch_it(half: float) -> None:
    """Great circles to the cap and away from it, and its edge between: the least of all."""
    start, goal = np.array([1.0, 0, 0]), np.array([-0.6, 0.8, 0.0])
    centre = np.array([0.35, 0.9, 0.1])
    centre /= np.linalg.norm(centre)
    u = np.cross(centre, start)
    u /= np.linalg.norm(u)
    v = np.cross(centre, u)

    def edge(turn: Array) -> Array:
        around = np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * v
        return np.cos(half) * centre + np.sin(half) * around

    turns = np.linspace(-np.pi, np.pi, 1441)
    rim = edge(turns)

    def to(point: Array) -> Array:
        """Return the lengths of great circles to the edge, infinite through the cap."""
        arcs = np.arccos(np.clip(rim @ point, -1, 1))
        inner = np.linspace(0.02, 0.98, 49)[:, None, None]
        chord = (1 - inner) * point + inner * rim
        chord /= np.linalg.norm(chord, axis=2, keepdims=True)
        return np.where((chord @ centre > math.cos(half) + 1e-6).any(axis=0), np.inf, arcs)

    between = np.abs(turns[:, None] - turns)
    between = np.minimum(between, 2 * np.pi - between) * math.sin(half)
    least = float((to(start)[:, None] + to(goal) + between).min())
    assert arc_outside(start, goal, centre, half) == pytest.approx(least, abs=2e-3)


@pytest.mark.parametrize("name", sorted(BEST_KNOWN))
def test_no_plan_that_was_ever_found_is_shorter_than_the_bound(name: str) -> None:
    with (ROOT / f"docs/plans/{name}.csv").open() as rows:
        *_, last = csv.DictReader(rows)
    seconds = duration_bound(kinolab.load(ROOT / f"scenarios/{name}.toml")).seconds
    assert 0.0 <= seconds <= min(float(last["t"]), BEST_KNOWN[name] + 0.005)


def test_a_verified_plan_is_no_shorter_than_the_bound(short: Solved) -> None:
    assert short.plan.trajectory is not None
    assert 0.0 < duration_bound(short.problem).seconds <= short.plan.trajectory.duration


def test_steps_that_count_as_true_have_no_bound() -> None:
    problem = to_rest(cart(), 3.0, integration={"truth": "discrete", "method": "euler"})
    assert duration_bound(problem).seconds == 0.0


def test_a_bound_says_how_far_above_it_a_plan_is_and_whether_that_says_anything() -> None:
    bound = DurationBound(2.0, "x has 3 m to go")
    assert (
        bound.sentence(2.2) == "at most 11 % above the proved lower bound of 2 s (x has 3 m to go)"
    )
    assert bound.sentence(5.0).startswith("no plan takes less than 2 s")
    assert "says little" in bound.sentence(5.0)
    assert (
        DurationBound(0.0, "why").sentence(5.0) == "no lower bound on its duration was proved: why"
    )

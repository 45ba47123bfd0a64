"""Two trees park a train with off-axle hitches, which neither of them would reach alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

import kinolab
from benchmarks.exact_optima import reeds_shepp_cars
from kinolab.dynamics import Body, Rate, System, length, move
from kinolab.trajopt.multistart.two_trees import TwoTrees, luby, reversal
from tests.support import ROOT

BAY = ROOT / "benchmarks" / "trailers" / "baggage_bay.toml"
# The same with the tractor's axle as its place and all in plain formulas, as Altafini has them.
L, A, B, DRAWBAR = 1.4, 0.5, 0.6, 1.8


def rates(hitches: np.ndarray, delta: float, v: float) -> tuple[float, float, float]:
    """Return the turn rates of tractor, first and second cart in [rad/s], by hand.

    A cart whose drawbar of length d is pulled by a point that moves at (f, s) along and across it
    turns at s / d and follows at f. The hitch behind an axle moves across it by -a times the turn.
    """
    turn = v * math.tan(delta) / L
    found, along = [turn], v
    for hitch, behind, d in ((hitches[0], A, DRAWBAR), (hitches[1], B, DRAWBAR)):
        f, s = along, -behind * turn  # of the hitch, in the axes of what pulls
        across = -f * math.sin(hitch) + s * math.cos(hitch)
        along = f * math.cos(hitch) + s * math.sin(hitch)
        turn = across / d
        found.append(turn)
    return found[0], found[1], found[2]


@pytest.mark.parametrize("seed", range(5))
def test_the_carts_turn_as_by_hand(seed: int) -> None:
    """By the geometry of each hitch."""
    generator = np.random.default_rng(seed)
    first, second, delta = generator.uniform(-0.6, 0.6, 3)
    problem = kinolab.load(BAY)
    x = np.array([0.0, 0.0, generator.uniform(-3, 3), first, second, delta])
    slope = dict(zip(problem.model.state_names, problem.model.f(x, [1.2, 0.0]), strict=True))
    tractor, middle, last = rates(np.array([first, second]), delta, 1.2)
    assert slope["psi"] == pytest.approx(last, abs=1e-9)
    assert slope["first"] == pytest.approx(middle - tractor, abs=1e-9)
    assert slope["second"] == pytest.approx(last - middle, abs=1e-9)


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_a_train_is_parked(seed: int) -> None:
    """By few guesses, of which every other one is of two trees."""
    plan = kinolab.load(BAY).solve("shooting", seed, 600.0, max_iterations=6, improve=0.0)
    assert plan.status == "solved"
    assert plan.certificate is not None
    assert plan.certificate.passed


def test_guesses_begin_at_the_start_and_end_in_the_goal() -> None:
    problem = kinolab.load(BAY)
    signs = reversal(problem)
    assert signs is not None
    trees = TwoTrees(problem, signs, np.random.default_rng(11), lambda: False)
    end = problem.goal.centre(problem.start)
    guesses = list(trees.guesses(end, 80))
    assert guesses
    for knots, block in guesses:
        assert knots.h == pytest.approx(block * problem.step)
        assert knots.x[0] == pytest.approx(problem.start)
        assert problem.goal_excess(knots.x[-1]) < 1e-6


def test_trees_restart_as_luby_says() -> None:
    """The sequence as its authors print it."""
    printed = [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8, 1]
    assert [luby(k) for k in range(1, 17)] == printed


def test_inputs_that_run_a_motion_backward_keep_the_curvature() -> None:
    """A car backs along its own curve: the speed changes its sign, the steering does not."""
    car = kinolab.load(next(reeds_shepp_cars(11)).scenario)
    signs = reversal(car)
    assert signs is not None
    assert signs.tolist() == [-1.0, 1.0]


def test_what_only_creeps_backward_does_not_run_backward() -> None:
    x = length("x", -1.0, 1.0, speed=1.0)
    body = Body("cart", move(x), mass=1.0)
    onward = System("onward", bodies=[body], inputs=[Rate("v", on=x, limit=(-0.1, 1.0))])
    assert reversal(kinolab.load({"system": onward, "goal": {"x": 0.5, "tolerance": 0.1}})) is None

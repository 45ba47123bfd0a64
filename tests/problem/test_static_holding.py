"""Can the inputs hold a machine? Statics by hand tell."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import kinolab
from kinolab.dynamics import Body, Drive, Rope, System, length, move, toward
from kinolab.problem.goal_states import goal_states
from kinolab.problem.static_holding import (
    best_static_holding,
    holding_sentences,
    rest_warnings,
    start_holding,
    static_holding,
)
from tests.analyze.diagnose.scenarios import PENDULUM
from tests.support import OPEN, problem_of

LEVEL = "start.theta=1.5707963267948966"
m, l, g, strongest = 1.0, 1.0, 9.81, 5.0  # kg, m, m/s^2, N m  # noqa: E741


def test_a_motor_too_weak_to_hold_a_pendulum_level_is_told_what_it_takes(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM, LEVEL)
    held = static_holding(problem, problem.start)
    assert held is not None
    assert not held.holds
    assert abs(held.needed["torque"]) == pytest.approx(m * g * l)
    assert abs(held.inputs["torque"]) == pytest.approx(strongest)
    assert abs(held.drifts["theta_dot"]) == pytest.approx((m * g * l - strongest) / (m * l**2))


def test_it_can_only_pass_through_a_goal_at_rest(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM)
    goal = best_static_holding(problem, goal_states(problem).inside)
    sentences = list(holding_sentences(problem, static_holding(problem, problem.start), goal))
    assert sentences == [
        "The machine cannot stay at rest in the goal, only come to rest there for an instant: "
        "theta_dot changes by 4.81 per "
        "second; to hold it takes torque = 9.81 N m (its limit is 5)."
    ]


def test_a_goal_that_is_passed_through_need_not_hold(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM, "goal.at_rest=false")
    goal = best_static_holding(problem, goal_states(problem).inside)
    assert goal is not None
    assert not goal.holds
    assert list(holding_sentences(problem, None, goal)) == []


def test_a_machine_that_cannot_stop_is_told_its_lower_limit(tmp_path: Path) -> None:
    world = "bounds = { x = [0, 9], y = [0, 9] }"
    text = f'schema = 1\ntitle = "On"\nsystem.name = "unicycle1_v1"\n{world}\n'
    problem = problem_of(tmp_path, text, "start={ x = 1, y = 1 }", "goal.x=5")
    (sentence,) = holding_sentences(problem, static_holding(problem, problem.start), None)
    assert sentence.endswith("to hold it takes v = 0 m/s (its limit is 0.25).")


def test_a_machine_with_feedback_is_told_the_limit_of_its_reference() -> None:
    problem = kinolab.load("unicycle_slalom")
    (sentence,) = holding_sentences(problem, static_holding(problem, problem.start), None)
    assert sentence.endswith("to hold it takes speed = 0 m/s (its limit is 0.85).")


@pytest.mark.parametrize("angle", [0.0, 0.3, -0.5, math.pi])
def test_a_weight_within_the_motors_strength_is_held(angle: float, tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM, f"start.theta={angle}")
    held = static_holding(problem, problem.start)
    assert held is not None
    assert held.holds
    assert held.share == pytest.approx(abs(m * g * l * math.sin(angle)) / strongest, abs=1e-6)
    assert list(holding_sentences(problem, held, held)) == []


def test_a_crane_holds_its_load_by_its_weight() -> None:
    problem = kinolab.load("crane_factory")
    held = static_holding(problem, problem.start)
    assert held is not None
    assert held.holds
    load = problem.system.parameter_values["m"]
    assert held.inputs["hoist"] == pytest.approx(load * g)


def test_a_sway_that_no_input_holds_is_named() -> None:
    problem = kinolab.load("crane_factory", overrides=["start.theta_x=0.2"])
    held = static_holding(problem, problem.start)
    assert held is not None
    assert not held.holds
    assert held.needed == {}
    [sentence] = holding_sentences(problem, held, None)
    assert sentence.startswith("The machine cannot rest at the start: no inputs keep ")


def test_a_coin_rests_anywhere(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "start.psi=1", "start.phi_dot=3")
    held = static_holding(problem, problem.start)
    assert held is not None
    assert (held.holds, held.share) == (True, 0.0)


WEAK = ("system.parameters.m=1000", "bounds.torque=[-1e-9, 1e-9]")  # it lifts nothing


@pytest.mark.parametrize("theta", ["3.14159", "3.1", "pi"])
def test_a_goal_about_an_equilibrium_can_be_rested_in(theta: str, tmp_path: Path) -> None:
    """It stands upright, at pi, or it falls."""
    problem = problem_of(tmp_path, PENDULUM, *WEAK, f"goal.theta={theta}", "goal.tolerance=0.05")
    held = best_static_holding(problem, goal_states(problem).inside)
    assert held is not None
    assert held.holds
    assert list(holding_sentences(problem, None, held)) == []


def test_a_rope_of_which_the_goal_says_nothing_is_reeled_to_hold_the_goal() -> None:
    """A load hangs at rest wherever its rope is as long as that: at z, but for the stretch."""
    z, reel = length("z", speed=2.0), length("l", 1.0, 20.0, speed=1.0)
    deck = Body("deck", move(0, 0, z), mass=240.0)
    roof = move(0, 0, 20.0)
    rope = Rope(between=(roof, deck.frame), stiffness=1e5, length=reel, damping=3e3)
    winch = Drive("winch", on=reel, limit=0.5)
    lift = System("lift", bodies=[deck], gravity=toward("-z"), inputs=[winch], efforts=[rope])
    problem = kinolab.load(
        {
            "title": "A deck is lifted",
            "system": lift,
            "world": {"bounds": {"z": [0.0, 19.0]}},
            "start": {"z": 2.0, "l": 17.98},
            "goal": {"z": 9.0, "at_rest": True, "tolerance": 0.01},
        }
    )
    assert rest_warnings(problem) == ()


def test_a_goal_whose_equilibrium_is_outside_cannot_be_rested_in(tmp_path: Path) -> None:
    goal = ["goal.theta=3.0", "goal.tolerance=0.1"]  # pi is 0.1416 away
    problem = problem_of(tmp_path, PENDULUM, *WEAK, *goal)
    held = best_static_holding(problem, goal_states(problem).inside)
    [sentence] = holding_sentences(problem, None, held)
    assert sentence.startswith("The machine cannot stay at rest in the goal, ")


def test_an_equilibrium_that_a_limit_excludes_is_none(tmp_path: Path) -> None:
    goal = ["goal.theta=3.1", "goal.tolerance=0.1", "bounds.theta=[-1, 3.13]"]
    problem = problem_of(tmp_path, PENDULUM, *WEAK, *goal)
    held = best_static_holding(problem, goal_states(problem).inside)
    assert held is not None
    assert not held.holds


@pytest.mark.parametrize(("theta", "rests"), [("3.14159", True), ("3.1416", True), ("3.13", False)])
def test_a_start_rests_as_far_as_its_digits_go(theta: str, rests: bool, tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM, *WEAK, f"start.theta={theta}")
    held = start_holding(problem)
    assert held is not None
    assert held.holds is rests


def test_a_goal_at_rest_that_no_input_holds_is_warned_of_before_a_search(tmp_path: Path) -> None:
    """A motor of 5 N m holds no weight of 9.81 N at 1 m; one that hangs rests by itself."""
    (warning,) = rest_warnings(problem_of(tmp_path, PENDULUM))
    assert warning.startswith(
        "The machine cannot stay at rest in the goal, only come to rest there for an instant: "
    )
    assert "to hold it takes torque = 9.81 N m (its limit is 5)" in warning
    for harmless in ("goal.at_rest=false", "goal.theta=0.3", "system.parameters.g=0"):
        assert rest_warnings(problem_of(tmp_path, PENDULUM, harmless)) == ()


def test_an_equilibrium_anywhere_in_the_goal_spares_the_warning(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM, *WEAK, "goal.theta=3.1", "goal.tolerance=0.05")
    assert rest_warnings(problem) == ()


@pytest.mark.parametrize("name", ["snakeboard_park", "crane_factory", "submarine_corridor"])
def test_goals_that_are_rested_in_are_not_warned_of(name: str) -> None:
    """On level ground, under gravity, and neutrally buoyant."""
    problem = kinolab.load(name, overrides=["goal.at_rest=true"])
    assert rest_warnings(problem) == ()

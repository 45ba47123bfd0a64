"""The cost as a state: what it is along motions whose cost is known in closed form."""

import numpy as np
import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.problem.objective.costed import costed
from kinolab.show.scene.scenes import told
from kinolab.simulation.reference import costs_along, price, resimulate

STEPS = 40


def pendulum(**objective: object) -> kinolab.Problem:
    return kinolab.load("pendulum_swingup").replace(objective=objective)


def cost_of(problem: kinolab.Problem, torque: float, seconds: float = 2.0) -> float:
    t = np.linspace(0.0, seconds, STEPS + 1)
    motion = resimulate(problem, t, np.full((STEPS, 1), torque))
    found = price(problem, motion)
    assert found is not None
    return found


def test_effort_is_the_integral_of_the_squares() -> None:
    assert cost_of(pendulum(effort=2.0, max_time=9.0), 3.0) == pytest.approx(2.0 * 9.0 * 2.0)


def test_time_and_a_formula_add_up() -> None:
    problem = pendulum(time=0.5, expression="torque + 6 * m")
    assert cost_of(problem, 5.0) == pytest.approx(0.5 * 2.0 + (5.0 + 6.0) * 2.0)


def test_energy_is_what_the_motor_does_while_it_turns_one_way() -> None:
    """The work of a constant torque is torque times angle."""
    problem = pendulum(energy=1.0)
    t = np.linspace(0.0, 0.5, STEPS + 1)
    motion = resimulate(problem, t, np.full((STEPS, 1), 5.0))
    assert (motion.x[1:, 1] > 0).all()
    assert price(problem, motion) == pytest.approx(5.0 * np.ptp(motion.x[:, 0]), rel=1e-8)


def test_the_length_of_a_bob_s_path_is_its_angle_times_the_rod() -> None:
    problem = pendulum(length={"bob": 1.0})
    t = np.linspace(0.0, 0.5, STEPS + 1)
    motion = resimulate(problem, t, np.full((STEPS, 1), 5.0))
    # [m] what a body that begins at rest counts too much while it is slower than some 0.1 mm/s
    assert price(problem, motion) == pytest.approx(np.ptp(motion.x[:, 0]), abs=1e-7)


def test_without_an_objective_there_is_no_price() -> None:
    problem = kinolab.load("pendulum_swingup")
    t = np.linspace(0.0, 1.0, STEPS + 1)
    assert price(problem, resimulate(problem, t, np.zeros((STEPS, 1)))) is None
    assert costed(problem) is None


@pytest.mark.parametrize(
    ("objective", "told"),
    [
        ({}, "nothing costs anything"),
        ({"effort": 1.0}, "effort alone becomes less the longer a motion takes"),
        ({"expression": "sin(theta)"}, "what a second costs is below 0 at theta ="),
        ({"expression": "1 / theta"}, "what a second costs is no number everywhere"),
        ({"length": {"rod": 1.0}}, "no body is called 'rod'. Known: bob."),
        ({"time": -1.0}, "-1.0 is too small"),
        ({"speed": 1.0}, "speed"),
    ],
)
def test_objectives_that_cannot_be_are_refused(objective: dict[str, object], told: str) -> None:
    with pytest.raises(InputError) as refused:
        pendulum(**objective)
    assert told in str(refused.value)


def test_the_power_of_a_given_motion_is_not_known() -> None:
    with pytest.raises(InputError, match="is a given motion, whose power is not known"):
        kinolab.load("biped_walk").replace(objective={"energy": 1.0})


def test_a_machine_with_modes_and_one_with_a_law_have_costs() -> None:
    """The cost comes before the mode, which stays the last entry; a law keeps its states."""
    for name in ("biped_walk", "unicycle_slalom"):
        problem = kinolab.load(name)
        priced = costed(problem.replace(objective={"effort": 1.0, "max_time": 60.0}))
        assert priced is not None
        names = [one for one in priced.model.state_names if one != "cost"]
        assert names == list(problem.model.state_names)
        assert priced.goal_excess(priced.start) == pytest.approx(problem.goal_excess(problem.start))


def test_the_cost_so_far_is_plotted_first() -> None:
    problem = pendulum(effort=1.0, max_time=9.0)
    t = np.linspace(0.0, 1.0, STEPS + 1)
    motion = resimulate(problem, t, np.full((STEPS, 1), 2.0))
    assert costs_along(problem, t, motion.u) == pytest.approx(4.0 * t, abs=1e-9)
    cost = told(problem, motion)[0]
    assert (cost.title, cost.names) == ("Cost", ("cost so far",))
    assert cost.values[:, 0] == pytest.approx(4.0 * t, abs=1e-9)

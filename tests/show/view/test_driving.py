"""What a driver's page is told, and the parts of it that need no picture."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.analyze.simulate import simulate
from kinolab.dynamics import Model
from kinolab.problem import PlanningTask
from kinolab.show import page as page_package
from kinolab.show.page.bundle import bundle
from kinolab.show.scene.driving import driven_step, driving_of
from tests.javascript_engine import Engine
from tests.support import OPEN, problem_of

PARTS = ("simulator", "channels", "between", "solids")
SOURCES = Path(str(page_package.__file__)).parent / "drive"


class Parts(Engine):
    """Modules of the drive mode that touch neither document nor scene."""

    def __init__(self) -> None:
        super().__init__()
        for name in PARTS:
            source = (SOURCES / f"{name}.js").read_text(encoding="utf-8")
            self._context.eval(bundle({name: source}, name))

    def simulator(self, model: Model, start: np.ndarray, dt: float) -> None:
        """Make the global ``simulator`` of a machine; its inputs are those in ``hand``."""
        self._context.eval("var hand = null, simulator = null")
        self.run(
            f"""simulator = module_simulator.buildSimulator({self.machine(model)}, {{
                start: a, dt: b, method: "rk4", substeps: 1, inputsAt: () => hand }})""",
            start.tolist(),
            dt,
        )


@pytest.fixture(scope="module")
def parts() -> Iterator[Parts]:
    with Parts() as made:
        yield made


def channels(parts: Parts, closed: bool = False, **inputs: tuple[float, float]) -> Any:
    given = [
        {"name": name, "unit": "N", "lower": low, "upper": high}
        for name, (low, high) in inputs.items()
    ]
    return parts.run("return module_channels.channelsOf(a, b)", given, closed)


def test_a_rope_that_is_held_is_let_alone() -> None:
    """Without a key the crane's load hangs where it is: the hoist carries its weight."""
    problem = kinolab.load("crane_factory")
    facts = driving_of(problem, simulate(problem, 0.1)).facts
    idle = facts["closed"]["idle"]
    assert idle[problem.model.control_names.index("hoist")] > 1000.0  # [N]
    assert problem.model.f(problem.start, idle) == pytest.approx(
        np.zeros(problem.model.nx), abs=1e-6
    )


def test_keys_push_so_that_a_person_can_follow() -> None:
    """Steering of a light coin is far below its limit, and speeds take a second or more."""
    problem = kinolab.load("rolling_disk_maze")
    facts = driving_of(problem, simulate(problem, 0.1)).facts
    usual, model = np.array(facts["closed"]["usual"]), problem.model
    assert ((usual > 0) & (usual <= 1)).all()
    after = model.step(problem.start, usual * model.control_bounds[:, 1], 1.0)
    speeds = after[model.speeds] / problem.scales[model.speeds]
    assert 0.5 < np.abs(speeds).max() <= 1.0


def test_inputs_are_held_for_a_thirtieth_of_a_second_or_as_the_controller_wants(
    tmp_path: Path,
) -> None:
    slow = problem_of(tmp_path, OPEN + "\n[integration]\nstep = 0.2\n")
    assert driven_step(slow) == pytest.approx(0.2 / 6)
    assert driven_step(kinolab.load("falling_disk_slalom")) == pytest.approx(
        kinolab.load("falling_disk_slalom").step
    )


def test_arrows_drive_and_steer_whatever_the_order(parts: Parts) -> None:
    for order in (("steer", "thrust"), ("thrust", "steer")):
        first, second = channels(parts, **dict.fromkeys(order, (-1.0, 1.0)))
        assert (first["label"], first["keys"]) == ("thrust", ["ArrowUp", "ArrowDown"])
        assert (second["label"], second["keys"]) == ("steer", ["ArrowLeft", "ArrowRight"])


def test_two_wheels_are_driven_together_and_against_each_other(parts: Parts) -> None:
    both, turn = channels(parts, left=(-1.0, 1.0), right=(-1.0, 1.0))
    assert (both["weights"], turn["weights"]) == ([1, 1], [-1, 1])
    assert turn["keys"] == ["ArrowLeft", "ArrowRight"]


def test_a_speed_reference_stays_and_a_turn_rate_does_not(parts: Parts) -> None:
    speed, turn = channels(parts, True, speed=(-3.0, 3.0), turn=(-1.0, 1.0))
    assert (speed["sticky"], turn["sticky"]) == (True, False)
    moved = parts.run(
        """const chosen = module_channels.channelsOf(a, true);
        const inputs = module_channels.buildInputs(a, chosen, { idle: [0, 0], usual: [1, 1] }, 0.5);
        return [[1, 1], [1, 0], [0, 0], [-1, 0]].map(pushes => inputs.at(pushes, 1))""",
        [{"name": n, "unit": "", "lower": -v, "upper": v} for n, v in (("speed", 3), ("turn", 1))],
    )
    assert moved == [[0.75, 1], [1.5, 0], [1.5, 0], [0.75, 0]]


def test_a_push_goes_from_the_idle_input_toward_its_limits(parts: Parts) -> None:
    """Up reaches the upper limit at full strength, down the lower one, half strength the usual."""
    found = parts.run(
        """const inputs = module_channels.buildInputs(a, module_channels.channelsOf(a, false),
            { idle: [4], usual: [0.25] }, 0.1);
        return [[1, 1], [-1, 1], [0, 1], [1, 0.5]].flatMap(
            ([push, strength]) => inputs.at([push], strength))""",
        [{"name": "thrust", "unit": "N", "lower": 0, "upper": 10}],
    )
    assert found == [10, 0, 4, 5.5]


def test_the_same_inputs_at_the_same_steps_lead_to_the_same_states(parts: Parts) -> None:
    """Whatever the pictures' rate: seconds are owed until they make a whole step."""
    problem: PlanningTask = kinolab.load("rolling_disk_maze")
    parts.simulator(problem.model, problem.start, 0.02)
    ends = parts.run(
        """return [[0.1], [0.013, 0.007], [0.019, 0.0011]].map(rhythm => {
            simulator.reset();
            for (let k = 0; simulator.steps < 100; k++) {
                hand = simulator.steps < 40 ? [0.5, 0.1] : [0.1, -0.2];
                simulator.pass(Math.min(rhythm[k % rhythm.length], 0.02));
            }
            return Array.from(simulator.state);
        })"""
    )
    assert ends[0] == ends[1] == ends[2]
    x = problem.start
    for k in range(100):
        x = problem.model.step(x, [0.5, 0.1] if k < 40 else [0.1, -0.2], 0.02)
    np.testing.assert_allclose(ends[0], x, rtol=1e-12, atol=1e-12)


def test_a_parameter_acts_from_the_next_step_on(parts: Parts) -> None:
    """And the log keeps what acted before."""
    problem = kinolab.load("pendulum_swingup")
    parts.simulator(problem.model, problem.start, 0.02)
    index = problem.model.parameter_names.index("l")
    log, end = parts.run(
        """simulator.step([1]); simulator.setParameter(a, 2); simulator.step([1]);
        return [simulator.log.map(entry => entry.parameters[a]), Array.from(simulator.state)]""",
        index,
    )
    default = problem.system.parameter_values["l"]
    assert log == [default, 2]
    x = problem.model.step(problem.start, [1], 0.02)
    np.testing.assert_allclose(end, problem.model.step(x, [1], 0.02, l=2.0), rtol=1e-12, atol=1e-14)


def test_where_the_equations_have_no_solution_the_machine_stays_and_says_why(parts: Parts) -> None:
    problem = kinolab.load("pendulum_swingup")
    parts.simulator(problem.model, problem.start, 0.02)
    index = problem.model.parameter_names.index("m")
    made, failure, steps = parts.run(
        """simulator.setParameter(a, 0); const made = simulator.step([1]);
        return [made, simulator.failure, simulator.steps]""",
        index,
    )
    assert (made, steps) == (False, 0)
    assert "undetermined" in failure


def test_turns_between_two_steps_take_the_shorter_way(parts: Parts) -> None:
    """Half of a quarter turn is an eighth, whatever the sign of the quaternions."""
    from scipy.spatial.transform import Rotation

    for angle in (0.0, 1.0, 3.0, -2.5):
        poses = [
            np.column_stack([Rotation.from_rotvec([0, 0, a]).as_matrix(), [a, 0, 0]]).ravel()
            for a in (angle, angle + np.pi / 2)
        ]
        found = parts.run(
            "return module_between.poseBetween(a, b, 0, 0.5)", *(pose.tolist() for pose in poses)
        )
        turned = Rotation.from_quat(found["turn"]).inv() * Rotation.from_rotvec(
            [0, 0, angle + np.pi / 4]
        )
        assert turned.magnitude() < 1e-9
        assert found["place"] == pytest.approx([angle + np.pi / 4, 0, 0])

"""Driving in a browser: what keys did there is done again by the compiled model.

The page says which inputs were held in which step; nothing else is told to the compiled model.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import kinolab
from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult
from tests.conftest import Solved
from tests.show.view.browsing import Opener, needs_chromium, until
from tests.support import OPEN, WALL, problem_of

Array = NDArray[np.float64]

pytestmark = needs_chromium

LONG = 5.0  # [s] of driving
SAME = 1e-6  # of a state's entry, or of 1
SLALOM = OPEN.replace("rolling_disk", "falling_disk").replace("x = -1.0", "x = -1.0\nphi_dot = 3.0")


def page_of(problem: PlanningTask, plan: PlanResult | None, path: Path) -> Path:
    return kinolab.save_page(problem, plan, path / "scene.html")


@pytest.fixture(scope="module")
def coin(browse: Opener, short: Solved, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The page of a planned coin."""
    return browse(page_of(short.problem, short.plan, tmp_path_factory.mktemp("coin")))


@pytest.fixture
def driven(coin: Any) -> Any:
    """The same with a driver at the start of the motion, all keys up and the loop as it was."""
    coin.evaluate("() => { kinolab.drive.stop(); kinolab.seek(0); kinolab.drive.start(); }")
    return coin


def drive(page: Any, presses: Sequence[tuple[str, float]]) -> None:
    """Hold one key after another, each until a time in [s], then pause; twice as fast.

    However rarely pictures come, no more than half a second passes between two of them; each key is
    held for some of its time even if that has passed already.
    """
    page.evaluate("kinolab.speed = 2")
    for key, moment in presses:
        begun = page.evaluate("kinolab.drive.time")
        page.keyboard.down(key)
        until(page, f"kinolab.drive.time >= {max(moment, begun + 0.2)}")
        page.keyboard.up(key)
    page.keyboard.press("Space")
    assert page.evaluate("kinolab.drive.paused") is True


def later(page: Any, span: float) -> None:
    until(page, f"kinolab.drive.time >= {page.evaluate('kinolab.drive.time') + span}")


def done_again(problem: PlanningTask, page: Any) -> Array:
    """The state to which the compiled model comes under the logged inputs and parameters."""
    model, settings = problem.model, problem.scenario.integration
    x, dt = np.array(page.evaluate("kinolab.drive.begin")), page.evaluate("kinolab.drive.dt")
    for entry in page.evaluate("kinolab.drive.log"):
        acting = model if entry["closed"] else model.plant
        values = dict(zip(model.parameter_names, entry["parameters"], strict=True))
        how = {"method": settings.method, "substeps": settings.substeps}
        x = acting.step(x, entry["inputs"], dt, **how, **values)
    return x


def near(found: Any, expected: Array) -> bool:
    return bool(
        (np.abs(np.array(found) - expected) <= SAME * np.maximum(np.abs(expected), 1)).all()
    )


def test_five_seconds_of_keys_lead_where_the_compiled_model_comes(
    driven: Any, short: Solved
) -> None:
    """Forward, to the left, backward, to the right; the mass is changed on the way."""
    drive(driven, [("ArrowUp", 1.0), ("ArrowLeft", 2.0)])
    slider = driven.locator("#drive .slider", has_text="m").first.locator("input")
    slider.evaluate("e => { e.value = 150; e.dispatchEvent(new Event('input')); }")
    driven.keyboard.press("Space")
    drive(driven, [("ArrowDown", 3.0), ("ArrowRight", 4.0), ("ArrowUp", LONG)])
    log = driven.evaluate("kinolab.drive.log")
    assert len(log) * driven.evaluate("kinolab.drive.dt") >= LONG - 1e-9
    assert len({tuple(entry["inputs"]) for entry in log}) >= 4
    assert len({tuple(entry["parameters"]) for entry in log}) == 2
    assert np.ptp([entry["inputs"] for entry in log], axis=0).min() > 0
    end = driven.evaluate("kinolab.drive.state")
    assert np.abs(np.subtract(end, driven.evaluate("kinolab.drive.begin"))).max() > 0.1
    assert near(end, done_again(short.problem, driven))
    driven.locator("#drive button", has_text="Reset parameters").click()


def test_a_controller_is_driven_by_its_references_and_may_be_left_out(
    browse: Opener, tmp_path: Path
) -> None:
    """Speed and turn rate first; then the plant's own inputs, under which the coin soon falls."""
    problem = problem_of(tmp_path, SLALOM)
    page = browse(page_of(problem, None, tmp_path))
    page.keyboard.press("m")
    drive(page, [("ArrowUp", 1.5), ("ArrowLeft", 3.0), ("ArrowRight", LONG)])
    log, end = page.evaluate("kinolab.drive.log"), page.evaluate("kinolab.drive.state")
    assert all(entry["closed"] for entry in log)
    assert log[-1]["inputs"][0] > log[0]["inputs"][0]  # the speed stays where it was set
    assert near(end, done_again(problem, page))
    page.locator("#drive label", has_text="Controller").locator("input").uncheck()
    page.keyboard.press("Space")
    drive(page, [("ArrowUp", page.evaluate("kinolab.drive.time") + 0.6)])
    log = page.evaluate("kinolab.drive.log")
    assert log[-1]["closed"] is False
    assert len(log[-1]["inputs"]) == problem.model.plant.nu
    assert near(page.evaluate("kinolab.drive.state"), done_again(problem, page))


def test_the_same_inputs_give_the_same_state_to_the_last_bit(driven: Any) -> None:
    drive(driven, [("ArrowUp", 0.5), ("ArrowLeft", 1.0)])
    first, again = driven.evaluate(
        """() => {
            const { log, state, begin } = kinolab.drive;
            kinolab.drive.reset(begin);
            log.forEach(({ inputs }) => kinolab.drive.step(inputs));
            return [state, kinolab.drive.state];
        }"""
    )
    assert first == again


def test_one_goes_on_from_where_the_plan_is(driven: Any, short: Solved) -> None:
    trajectory = short.trajectory
    row = len(trajectory.u) // 2
    driven.evaluate("kinolab.drive.pause()")
    driven.evaluate("t => kinolab.seek(t)", float(trajectory.t[row] + 1e-6))
    driven.keyboard.press("End")
    assert driven.evaluate("kinolab.drive.begin") == trajectory.x[row].tolist()
    assert driven.evaluate("kinolab.time") == trajectory.t[row]
    driven.keyboard.press("Home")
    assert driven.evaluate("kinolab.drive.begin") == short.problem.start.tolist()


def test_the_plan_goes_on_beside_the_driver(driven: Any, short: Solved) -> None:
    """Its time is the driver's, counted from where the motion began, until the plan ends."""
    driven.evaluate("kinolab.speed = 0.2")
    until(driven, "kinolab.drive.time >= 0.1")
    driven.keyboard.press("Space")
    time = driven.evaluate("kinolab.drive.time")
    assert driven.evaluate("kinolab.time") == pytest.approx(time)
    assert time < short.trajectory.t[-1]


def test_a_stick_pushes_as_far_as_it_is_moved(driven: Any) -> None:
    """Forward is away from the body, which gamepads count as negative."""
    driven.evaluate("navigator.getGamepads = () => [{ axes: [0, -0.56, 0, 0] }]")
    later(driven, 0.2)
    part = driven.evaluate("kinolab.drive.log.at(-1).inputs")
    driven.evaluate("navigator.getGamepads = () => [{ axes: [0, -1, 0, 0] }]")
    later(driven, 0.2)
    whole = driven.evaluate("kinolab.drive.log.at(-1).inputs")
    driven.evaluate("navigator.getGamepads = () => []")
    assert whole[0] > 0
    assert part == pytest.approx([0.5 * whole[0], 0.0])


def test_leaving_gives_the_plan_back(driven: Any, short: Solved) -> None:
    drive(driven, [("ArrowUp", 0.3)])
    assert driven.locator("#drive").is_visible()
    driven.keyboard.press("Escape")
    assert driven.evaluate("kinolab.drive.active") is False
    assert not driven.locator("#drive").is_visible()
    driven.keyboard.press("End")
    assert driven.evaluate("kinolab.time") == short.trajectory.t[-1]


def test_what_leaves_its_limits_is_named(driven: Any, short: Solved) -> None:
    far = short.problem.start.tolist()
    far[short.problem.model.state_names.index("x")] = 7.0
    driven.evaluate("x => { kinolab.drive.pause(); kinolab.drive.reset(x); }", far)
    driven.locator("#drive .status", has_text="outside its limits: x").wait_for(timeout=20_000)


def test_a_machine_as_large_as_its_world_is_followed_with_all_of_it(
    browse: Opener, tmp_path: Path
) -> None:
    """A pendulum's goal is above where it hangs."""
    problem = kinolab.load("pendulum_swingup")
    plan = problem.solve(planner="rrt_fast", seed=1, max_iterations=5000, optimize=False)
    page = browse(page_of(problem, plan, tmp_path))
    page.evaluate("kinolab.view('follow')")
    for share in (0.0, 0.5, 1.0):
        page.evaluate("share => kinolab.seek(share * kinolab.last)", share)
        page.wait_for_timeout(100)
        assert "goal" in page.locator("#captions .sign:visible").all_inner_texts()


def test_an_energy_beyond_all_numbers_is_told_as_none(browse: Opener, tmp_path: Path) -> None:
    """Gravity of 1e80 m/s^2 moves a pendulum within a step; the square of 1e200 is no float."""
    page = browse(page_of(kinolab.load("pendulum_swingup"), None, tmp_path))
    gravity = [entry.name for entry in kinolab.systems.get("pendulum").parameters].index("g")
    page.evaluate(
        "() => { kinolab.drive.start(); kinolab.drive.pause(); kinolab.drive.step([1]); }"
    )
    shown = page.locator(".energies output")
    for value, told in ((1e80, r"\d\.\de1\d\d J"), (1e200, "–")):
        page.evaluate("([k, v]) => kinolab.drive.setParameter(k, v)", [gravity, value])
        page.evaluate("kinolab.drive.step([1])")
        assert re.fullmatch(told, shown.nth(0).inner_text())
        assert re.fullmatch(told, shown.nth(2).inner_text())
    page.evaluate("kinolab.drive.reset()")


def test_driving_is_followed_and_what_is_run_into_is_named(browse: Opener, tmp_path: Path) -> None:
    """The wall's near side is at x = 2.95 m; the coin, seen along x, reaches 0.25 m ahead."""
    problem = problem_of(tmp_path, OPEN + WALL)
    page = browse(page_of(problem, None, tmp_path))
    page.evaluate("kinolab.drive.start()")
    assert page.inner_text("#views [aria-pressed=true]") == "Follow"
    radius = problem.system.parameter_values["R"]
    for x, touching in ((2.95 - 1.01 * radius, []), (2.95 - 0.99 * radius, [["coin", "wall"]])):
        state = problem.start.tolist()
        state[problem.model.state_names.index("x")] = x
        page.evaluate("x => { kinolab.drive.reset(x); }", state)
        assert page.evaluate("kinolab.drive.touching") == touching
    page.evaluate("kinolab.drive.pause()")
    page.locator("#drive .status", has_text="coin touches wall").wait_for(timeout=20_000)
    page.evaluate("kinolab.drive.stop()")
    assert page.inner_text("#views [aria-pressed=true]") == "3-D"

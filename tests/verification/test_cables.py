"""A rope that hits what trolley and load pass by: found at the ends, on the way, and in plans.

The crane is driven, so that its motions are parabolas; its rope hangs straight down.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab.dynamics import (
    Body,
    Box,
    Cable,
    Drive,
    System,
    length,
    move,
    require,
    toward,
)
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.errors import EndpointError
from kinolab.problem import PlanningTask
from kinolab.simulation.dop853 import follow
from kinolab.testing import assert_collision_free
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from tests.support import detail, failed, problem_of, time_in

Array = NDArray[np.float64]

RADIUS = 0.02  # [m] of the rope
SCENARIO = """\
schema = 1
title = "A rope and a beam"

[system]
file = "machine.json"

[world]
bounds = { x = [-5, 5] }

[[world.obstacle]]
name = "beam"
box = [0.1, 2.0, 0.1]
position = [1.0, 0.0, 2.0]

[start]
l = 3.0

[goal]
x = 2.0
tolerance = 0.5

[integration]
step = 0.05

[planner]
improve = 0
name = "rrt"
"""


def crane(radius: float = RADIUS, collides: bool = True, **parts: object) -> System:
    x, l = length("x", -4, 4, speed=2.0), length("l", 0.5, 3.5, speed=2.0)  # noqa: E741
    rail = move(x, 0, 4)
    trolley = Body("trolley", rail, mass=1.0, shape=Box(0.2, 0.2, 0.2))
    load = Body("load", rail @ move(0, 0, -l), mass=1.0, shape=Box(0.2, 0.2, 0.2))
    return System(
        "crane",
        bodies=[trolley, load],
        inputs=[Drive("travel", on=x, limit=2.0), Drive("hoist", on=l, limit=2.0)],
        gravity=toward("-z"),
        cables=[Cable((rail, load.frame), "rope", radius=radius, collides=collides)],
        **parts,  # type: ignore[arg-type]
    )


def load(folder: Path, *overrides: str, system: System | None = None) -> PlanningTask:
    folder.mkdir(exist_ok=True)
    (folder / "machine.json").write_text(machine_to_json(system or crane()), encoding="utf-8")
    return problem_of(folder, SCENARIO, *overrides)


def driven(
    problem: PlanningTask, start: list[float], inputs: list[list[float]], step: float
) -> Array:
    """Return the states (x, l, x_dot, l_dot) at the knots under held accelerations."""
    states = [np.array(start)]
    for held in inputs:
        q, v = np.split(states[-1], 2)
        a = np.array(held)
        states.append(np.concatenate([q + v * step + a * step**2 / 2, v + a * step]))
    assert problem.model.state_names == ("x", "l", "x_dot", "l_dot")
    return np.array(states)


def motion_of(
    problem: PlanningTask, start: list[float], inputs: list[list[float]], step: float
) -> Trajectory:
    t: Array = step * np.arange(len(inputs) + 1, dtype=float)
    x = driven(problem, start, inputs, step)
    model = problem.model
    u = np.array(inputs, dtype=float)
    return Trajectory(t, x, u, model.state_names, model.control_names)


def gliding(problem: PlanningTask, l: float, steps: int = 1) -> Trajectory:  # noqa: E741
    """Return 2 m of travel at 1 m/s."""
    return motion_of(problem, [0.0, l, 1.0, 0.0], [[0.0, 0.0]] * steps, 2.0 / steps)


# The rope's near side meets the beam's near side, in [s] at 1 m/s.
CONTACT = 1.0 - 0.05 - RADIUS


@pytest.mark.parametrize("steps", [1, 40])
def test_a_rope_pulled_through_a_beam_fails_and_is_named(tmp_path: Path, steps: int) -> None:
    problem = load(tmp_path, "start.x_dot=1.0")
    certificate = verify(problem, gliding(problem, 3.0, steps))
    assert failed(certificate) == {"collision"}
    words = detail(certificate, "collision")
    assert "rope touches beam" in words
    assert CONTACT - 1e-4 <= time_in(words) <= CONTACT + 1e-4  # touching begins 1e-5 m earlier
    with pytest.raises(AssertionError, match="rope touches beam"):
        assert_collision_free(problem, gliding(problem, 3.0, steps))


def test_a_hoisted_load_carries_its_rope_over_the_beam(tmp_path: Path) -> None:
    problem = load(tmp_path, "start.x_dot=1.0", "start.l=1.5")
    assert failed(verify(problem, gliding(problem, 1.5))) == set()


def test_a_rope_that_is_only_drawn_passes_the_beam(tmp_path: Path) -> None:
    problem = load(tmp_path, "start.x_dot=1.0", system=crane(collides=False))
    assert failed(verify(problem, gliding(problem, 3.0))) == set()


def test_lowering_the_load_beside_the_beam_is_free_and_into_it_is_not(tmp_path: Path) -> None:
    """At x = 0.9 the load would meet the beam 0.05 m deep, at x = 0.8 it passes by 0.05 m."""
    problem = load(tmp_path, "start.l_dot=1.0", "start.l=1.0", "goal={l=3.0, tolerance=0.5}")
    for place, hits in ((0.8, False), (0.9, True)):
        lowered = replace(problem, start=np.array([place, 1.0, 0.0, 1.0]))
        motion = motion_of(lowered, lowered.start.tolist(), [[0.0, 0.0]], 2.0)
        assert ("collision" in failed(verify(lowered, motion))) == hits


@pytest.mark.parametrize(("gap", "passes"), [(1e-4, True), (-1e-4, False)])
def test_hanging_beside_a_beam_a_tenth_of_a_millimetre_decides(
    tmp_path: Path, gap: float, passes: bool
) -> None:
    """A thin rope is lowered past the beam's side; the load is drawn without a shape of its own."""
    place = 1.0 - 0.05 - 0.001 - gap
    x = length("x", -4, 4, speed=2.0)
    l = length("l", 0.5, 3.5, speed=2.0)  # noqa: E741
    rail = move(x, 0, 4)
    weight = Body("weight", rail @ move(0, 0, -l), mass=1.0)
    thin = System(
        "crane",
        bodies=[weight],
        inputs=[Drive("travel", on=x, limit=2.0), Drive("hoist", on=l, limit=2.0)],
        cables=[Cable((rail, weight.frame), "rope", radius=0.001)],
    )
    overrides = ("start.l_dot=1.0", "start.l=1.0", f"start.x={place}", "goal={l=3, tolerance=0.5}")
    problem = load(tmp_path, *overrides, system=thin)
    motion = motion_of(problem, problem.start.tolist(), [[0.0, 0.0]], 2.0)
    assert ("collision" not in failed(verify(problem, motion))) == passes


@pytest.mark.parametrize("radius", [0.01, 1e-3, 1e-4])
def test_a_thread_cannot_step_over_a_wire(tmp_path: Path, radius: float) -> None:
    """Wire and thread overlap over 2 (radius + 0.0001 m) of a way of 2 m."""
    wire = ("world.obstacle=[{name='wire', box=[0.0002, 2.0, 0.0002], position=[1.003, 0, 2]}]",)
    problem = load(tmp_path, "start.x_dot=1.0", *wire, system=crane(radius=radius))
    certificate = verify(problem, gliding(problem, 3.0))
    assert failed(certificate) == {"collision"}
    expected = 1.003 - 1e-4 - radius
    assert time_in(detail(certificate, "collision")) == pytest.approx(expected, abs=1e-4)


def test_a_cable_may_be_faster_than_every_body(tmp_path: Path) -> None:
    """It is hung between frames without bodies; the only body moves at a tenth of their speed."""
    x, l = length("x", -4, 4, speed=2.0), length("l", 0.5, 3.5, speed=2.0)  # noqa: E741
    slow = Body("slow", move(x / 10, l / 10, 20), mass=1.0)
    system = System(
        "crane",
        bodies=[slow],
        inputs=[Drive("travel", on=x, limit=2.0), Drive("hoist", on=l, limit=2.0)],
        cables=[Cable((move(x, 0, 4), move(x, 0, 1)), "rope", radius=0.001)],
    )
    wire = "world.obstacle=[{name='wire', box=[0.0002, 2.0, 0.0002], position=[0.975, 0, 2]}]"
    problem = load(tmp_path, "start={ x=0.9, l=3, x_dot=2.0 }", wire, system=system)
    motion = motion_of(problem, problem.start.tolist(), [[0.0, 0.0]], 0.5)
    assert failed(verify(problem, motion)) == {"collision"}
    pytest.importorskip("ompl")
    assert _steps_made(problem, [0.0, 0.0], 1) == 0


def test_a_start_with_the_rope_in_a_beam_names_the_pair(tmp_path: Path) -> None:
    with pytest.raises(EndpointError, match="rope touches beam"):
        load(tmp_path, "start.x=1.0").check_endpoints()


def test_the_motion_of_a_rope_into_a_beam_is_refused_while_planning(tmp_path: Path) -> None:
    """From x = 0.9 at 2 m/s one step of 0.1 s leads past the beam, both ends free of it."""
    pytest.importorskip("ompl")
    for low, steps in ((3.0, 0), (1.5, 1)):
        settings = (f"start={{ x=0.9, l={low}, x_dot=2.0 }}", "integration.step=0.1")
        problem = load(tmp_path, *settings)
        checker = problem.checker()
        for x in (0.9, 1.1):
            assert not checker.collides(*problem.placement(np.array([x, low, 2.0, 0.0])))
        assert _steps_made(problem, [0.0, 0.0], 1) == steps


def _steps_made(problem: PlanningTask, inputs: list[float], steps: int) -> int:
    """Return how many steps from the start OMPL finds free."""
    bridge = problem.to_ompl()
    information = bridge.space_information
    start, end = bridge.space.allocState(), bridge.space.allocState()
    bridge.write(start, problem.start.tolist())
    assert information.isValid(start)
    control = information.allocControl()
    for k, value in enumerate(inputs):
        control[k] = value
    return int(information.propagateWhileValid(start, control, steps, end))


def test_a_plan_lifts_the_load_over_the_beam(tmp_path: Path) -> None:
    """Straight ahead, the rope is in the way: the plan has to hoist, by more than 1 m."""
    problem = load(tmp_path)
    plan = problem.solve(seed=1, time_limit=30.0)
    assert plan.status == "solved", plan.message
    assert plan.trajectory is not None
    assert plan.certificate is not None
    assert plan.certificate.passed
    x, low = plan.trajectory.x[:, 0], plan.trajectory.x[:, 1]
    passing = np.abs(x - 1.0) < 0.05
    assert (low[passing] < 2.0 - 0.05 + 0.1).all()  # [m]; the beam's top, half the load below
    assert low.min() < 1.95


# --- requirements along the way ---


def shuttle(folder: Path, margin: object, *overrides: str) -> PlanningTask:
    """Return a crane far from any beam that demands something."""
    x = length("x", -4, 4, speed=2.0)
    l = length("l", 0.5, 3.5, speed=2.0)  # noqa: E741
    rail = move(x, 0, 4)
    travel, hoist = Drive("travel", on=x, limit=2.0), Drive("hoist", on=l, limit=2.0)
    weight = Body("weight", rail @ move(0, 0, -l), mass=1.0)
    demanded = require(margin(x, travel.symbol), "demand")  # type: ignore[operator]
    system = System("crane", bodies=[weight], inputs=[travel, hoist], requirements=[demanded])
    return load(folder, "world.obstacle=[]", *overrides, system=system)


def test_a_requirement_that_is_broken_between_knots_only_fails(tmp_path: Path) -> None:
    """Forth and back within one interval: x = t - t^2/2 is 0 at both knots and 0.5 in between."""
    overrides = ("start.x_dot=1.0", "goal={x=0, tolerance=0.1}")
    for limit, short in ((0.4, 0.1), (0.6, 0.0)):
        problem = shuttle(tmp_path, lambda x, _, most=limit: most - x, *overrides)
        motion = motion_of(problem, [0.0, 3.0, 1.0, 0.0], [[-1.0, 0.0]], 2.0)
        certificate = verify(problem, motion)
        assert failed(certificate) == ({"requirements"} if short else set())
        if short:
            words = detail(certificate, "requirements")
            assert float(words.split()[-1]) == pytest.approx(0.1, abs=2e-4)  # 0.02 s off: 0.2 mm
            assert time_in(words) == pytest.approx(1.0, abs=0.02)  # [s]; 10 mm at below 0.5 m/s


def test_a_requirement_is_judged_at_both_ends_of_an_interval_under_its_inputs(
    tmp_path: Path,
) -> None:
    """Speed 1 m/s is too much while still accelerating, and allowed once the brakes are on."""
    from kinolab.dynamics import rate

    problem = shuttle(tmp_path, lambda x, a: 1.05 - rate(x) - 0.2 * a, "goal={x=1, tolerance=0.1}")
    inputs = [[1.0, 0.0], [-1.0, 0.0]]
    certificate = verify(problem, motion_of(problem, [0.0, 3.0, 0.0, 0.0], inputs, 1.0))
    assert failed(certificate) == {"requirements"}
    words = detail(certificate, "requirements")
    assert "short by 0.15" in words
    assert time_in(words) == pytest.approx(1.0)


def test_a_requirement_broken_on_the_way_is_refused_while_planning(tmp_path: Path) -> None:
    """One step of 2 s, forth and back, as above."""
    pytest.importorskip("ompl")
    reached = []
    for k, limit in enumerate((0.4, 0.6)):
        problem = shuttle(
            tmp_path / str(k),
            lambda x, _, most=limit: most - x,
            "start.x_dot=1.0",
            "integration.step=2.0",
        )
        reached.append(_steps_made(problem, [-1.0, 0.0], 1))
    assert reached == [0, 1]


def test_the_whole_motion_is_integrated_twice_and_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Once as it is, once with a perturbed start, and every interval from its own knot."""
    problem = load(tmp_path, "start.x_dot=1.0", "start.l=1.5")
    made = []

    def counted(ode: Any, t: Array, u: Array, *others: Any) -> Any:
        made.append((others[2], len(u)))
        return follow(ode, t, u, *others)

    monkeypatch.setattr("kinolab.simulation.dop853.follow", counted)
    assert verify(problem, gliding(problem, 1.5, 40)).passed
    assert sorted(made) == [(False, 40), (True, 40), (True, 40)]

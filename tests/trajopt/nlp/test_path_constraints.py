"""Margins of what states must keep are those of closed forms, and so are their slopes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab.dynamics import Body, Drive, System, length, move, rate, require
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.feasibility_check import satisfies_all, satisfies_all_at_knots
from kinolab.trajopt.nlp.path_constraints import PathConstraints, Samples
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from tests.support import OPEN, problem_of

Array = NDArray[np.float64]

RADIUS, CONE = 0.25, 0.3  # [m] of the coin of 1 kg, [rad] of the cone
FRICTION = 0.6 * 9.81  # [N] of its rim at most
LIMITED = f"""
[bounds]
x_dot = [-1.0, 2.0]
y_dot = [-0.5, 0.5]
[[keep_out]]
body = "coin"
axis = "y"
direction = [0, 1, 0]
half_angle = {CONE}
"""
TRAILER = """
schema = 1
title = "A car with a trailer that may not fold"
system = { name = "car1_v0" }
[bounds]
x = [-3, 3]
y = [-3, 3]
[goal]
x = 1.0
tolerance = 0.1
[integration]
step = 0.1
"""
CRANE = """
schema = 1
title = "A rope that only pulls"
system = { name = "crane" }
[bounds]
x = [1, 23]
y = [1, 13]
[start]
x = 3.0
y = 3.0
l = 7.8
[goal]
x = 4.0
tolerance = 0.1
[integration]
step = 0.25
"""
LAZY = 0.05  # share of inputs, so that the winch's drag sometimes outweighs its force
HOIST_DRAG = 2000.0  # [N s/m]
EVERYTHING = 1e9  # reach of a change that may use up any margin


def coin_margins(x: Array, u: Array) -> Array:
    """The rim's grip; rates by half their range; the workspace; the axis."""
    px, py, psi, _, psi_dot, phi_dot = x
    sideways, along = RADIUS * phi_dot * psi_dot, u[0] / (1.5 * RADIUS)
    grip = FRICTION**2 - sideways**2 - along**2
    x_dot, y_dot = RADIUS * phi_dot * np.cos(psi), RADIUS * phi_dot * np.sin(psi)
    rates = [(x_dot + 1.0) / 1.5, (y_dot + 0.5) / 0.5, (2.0 - x_dot) / 1.5, (0.5 - y_dot) / 0.5]
    return np.array([grip, *rates, px + 5, 5 - px, py + 5, 5 - py, np.cos(CONE) - np.cos(psi)])


def trailer_margins(x: Array, u: Array) -> Array:  # noqa: ARG001
    return np.array([np.pi / 4 - abs((x[2] - x[3] + np.pi) % (2 * np.pi) - np.pi)])


def rope_margins(x: Array, u: Array) -> Array:
    """The winch's force and its drag, which pulls where the rope gets longer."""
    return np.array([u[2] + HOIST_DRAG * x[7]])


CASES: dict[str, tuple[str, Callable[[Array, Array], Array]]] = {
    "coin": (OPEN.replace("[planner]", LIMITED + "[planner]"), coin_margins),
    "trailer": (TRAILER, trailer_margins),
    "crane": (CRANE, rope_margins),
}


@pytest.fixture(scope="module", params=CASES)
def case(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[PlanningTask, Callable[[Array, Array], Array], Samples]:
    text, margins = CASES[request.param]
    problem = problem_of(tmp_path_factory.mktemp(request.param), text)
    random = np.random.default_rng(5)
    lower, upper = problem.sampling_bounds.T
    x = random.uniform(lower, upper, (40, problem.model.nx))
    u = LAZY * random.uniform(*problem.model.control_bounds.T, (40, problem.model.nu))
    return problem, margins, Samples(np.arange(40), np.zeros(40), x, u)


Case = tuple[PlanningTask, Callable[[Array, Array], Array], Samples]


def test_margins_are_those_of_closed_forms(case: Case) -> None:
    problem, margins, at = case
    expected = np.array([margins(x, u) for x, u in zip(at.x, at.u, strict=True)])
    for room in (0.0, 0.1):
        found = PathConstraints(problem, room).margins(at.x, at.u)
        np.testing.assert_allclose(found, expected - room, rtol=1e-12, atol=1e-10)
        missing = np.maximum(room - expected, 0.0).sum()
        assert PathConstraints(problem, room).violation(at) == pytest.approx(missing, rel=1e-9)
        assert missing > 0


def slopes(margins: Callable[[Array, Array], Array], x: Array, u: Array) -> Array:
    """Return central differences of closed forms, shape (margins, nx + nu)."""
    columns = []
    for d in 1e-5 * np.eye(len(x) + len(u)):
        ahead, behind = (margins(x + s * d[: len(x)], u + s * d[len(x) :]) for s in (1, -1))
        columns.append((ahead - behind) / 2e-5)
    return np.column_stack(columns)


def test_slopes_are_those_of_closed_forms(case: Case) -> None:
    """Margins that bend sharply at a state, such as those of a folded trailer, are not there."""
    problem, margins, at = case
    rows = PathConstraints(problem, 0.0).rows(at, EVERYTHING)
    own = zip(at.x, at.u, strict=True)
    expected = np.array([slopes(margins, x, u) for x, u in own])
    flat = expected.reshape(-1, expected.shape[-1])
    assert (np.abs(flat).max(axis=1) > 0).all()  # so that a large change can use all of them up
    np.testing.assert_allclose(np.hstack([rows.dx, rows.du]), flat, rtol=1e-6, atol=1e-6)
    assert (rows.dx_next == 0).all()  # all samples are at knots
    np.testing.assert_array_equal(rows.knot, np.repeat(at.knot, expected.shape[1]))


def test_what_a_change_cannot_use_up_is_left_out(tmp_path: Path) -> None:
    """A coin 0.4 m from one side of its workspace that moves by up to 0.3 m, or by up to 0.1 m.

    Limits within twice the largest change are listed.
    """
    problem = problem_of(tmp_path, OPEN)
    x = np.array([[4.6, 0.0, 0.0, 0.0, 0.0, 0.0]])
    at = Samples(np.zeros(1, np.int64), np.zeros(1), x, np.zeros((1, problem.model.nu)))
    large = problem.scales[0]
    near = PathConstraints(problem, 0.0).rows(at, 0.3 / large)
    assert near.value == pytest.approx([0.4], abs=1e-12)
    assert near.dx[0] == pytest.approx([-1, 0, 0, 0, 0, 0], abs=1e-9)
    assert not len(PathConstraints(problem, 0.0).rows(at, 0.1 / large).value)


def test_a_problem_without_demands_has_no_margins(tmp_path: Path) -> None:
    text = OPEN.replace("bounds = { x = [-5, 5], y = [-5, 5] }\n", "")
    text = text.replace("rolling_disk", "diff_drive")
    problem = problem_of(
        tmp_path, text.replace("[start]", "[bounds]\nx = [0, 1]\ny = [0, 1]\n[start]")
    )
    x, u = np.zeros((3, problem.model.nx)), np.zeros((3, problem.model.nu))
    demands = PathConstraints(problem, 0.0)
    assert demands.margins(x, u).shape == (3, 0)
    at = Samples(np.arange(3), np.zeros(3), x, u)
    assert demands.violation(at) == 0.0
    assert not len(demands.rows(at, EVERYTHING).value)


# --- where steps begin ---

SLIDE = """
schema = 1
title = "A slide that may not brake while it is fast"
[system]
file = "machine.json"
[start]
x_dot = 1.0
[goal]
x = 0.5
tolerance = 0.1
[integration]
step = 1.0
"""


def slide(folder: Path, most: float) -> PlanningTask:
    """Return a slide whose speed in [m/s], less 0.2 s times its acceleration, is limited."""
    x = length("x", -4, 4, speed=2.0)
    push = Drive("push", on=x, limit=2.0)
    demanded = require(most - rate(x) + 0.2 * push.symbol, "gentle")
    body = Body("slide", move(x, 0, 0), mass=1.0)
    system = System("slide", bodies=[body], inputs=[push], requirements=[demanded])
    folder.mkdir(exist_ok=True)
    (folder / "machine.json").write_text(machine_to_json(system), encoding="utf-8")
    return problem_of(folder, SLIDE)


@pytest.mark.parametrize(("most", "short"), [(1.1, 0.1), (1.3, 0.0)])
def test_what_inputs_decide_is_demanded_where_a_step_begins(
    most: float, short: float, tmp_path: Path
) -> None:
    """Braking at 1 m/s^2 from 1 m/s is worst at its beginning: most - 1.0 - 0.2."""
    problem, model = slide(tmp_path, most), slide(tmp_path, most).model
    x, u = np.array([[0.0, 1.0], [0.5, 0.0]]), np.array([[-1.0]])
    task = TrajectoryProblem(problem, 0.0)
    knots = Knots(x, u, 1.0)
    assert task.transcription(knots).violation(knots)[2] == pytest.approx(short, abs=1e-12)
    motion = Trajectory(np.array([0.0, 1.0]), x, u, model.state_names, model.control_names)
    assert satisfies_all(task, motion) == (short == 0.0)
    assert satisfies_all_at_knots(task, motion) == (short == 0.0)


def test_a_demand_where_a_step_begins_is_linear_in_that_knot_and_its_inputs(
    tmp_path: Path,
) -> None:
    """The last step glides and breaks nothing; the first one's beginning is short by 0.1."""
    problem = slide(tmp_path, 1.1)
    knots = Knots(np.array([[0.0, 1.0], [0.5, 0.0], [0.5, 0.0]]), np.array([[-1.0], [0.0]]), 1.0)
    rows = (
        TrajectoryProblem(problem, 0.0).transcription(knots).linearization(knots, EVERYTHING).rows
    )
    [worst] = np.flatnonzero(rows.value < 0)
    assert rows.knot[worst] == 0
    assert rows.value[worst] == pytest.approx(-0.1, abs=1e-12)
    np.testing.assert_allclose(rows.dx[worst], [0.0, -1.0], atol=1e-8)
    np.testing.assert_allclose(rows.du[worst], [0.2], atol=1e-8)
    np.testing.assert_array_equal(rows.dx_next[worst], [0.0, 0.0])

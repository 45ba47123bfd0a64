"""The verdict on a motion: what must pass passes, what must fail fails at the check that names it.

Every motion here is a closed form, and every expected contact is plane geometry: the coin stands
upright, so that it meets an obstacle with vertical faces where its outline from above does.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ellipk

from kinolab.dynamics import Body, Drive, Sphere, System, length, move, require
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from kinolab.verification.between_samples.clearance_margin import ClearanceMargin
from kinolab.verification.between_samples.dense_motion import MAX_SPACING
from tests.conftest import Solved, Solver
from tests.oracles.rolling_disk import Coin
from tests.support import (
    OPEN,
    ROOT,
    WALL,
    coin_after,
    coin_motion,
    detail,
    failed,
    problem_of,
    time_in,
    within,
)

Array = NDArray[np.float64]

COIN = Coin()
HALF = np.array([COIN.R, 0.025])  # [m] half the coin's outline from above: radius, half thickness
STEP = 0.05  # [s]


def rolling(start: list[float], torques: list[float], steps: int, step: float = STEP) -> Trajectory:
    """Return the coin's motion under constant torques."""
    t: Array = step * np.arange(steps + 1, dtype=float)
    return coin_motion(start, t, np.tile(np.array(torques, dtype=float), (steps, 1)))


def straight(steps: int = 20, step: float = STEP) -> Trajectory:
    """Return the coin rolling from (-1, 0) along x at 1 m/s: into the table's goal after 0.5 s."""
    return rolling([-1.0, 0, 0, 0, 0, 1 / COIN.R], [0, 0], steps, step)


@pytest.fixture(scope="module")
def lane(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    """The table with the coin already rolling at 1 m/s."""
    return problem_of(tmp_path_factory.mktemp("lane"), OPEN, "start.phi_dot=4")


# --- what is right ---


def test_a_good_motion_passes_every_check(lane: PlanningTask) -> None:
    certificate = verify(lane, straight())
    assert certificate.passed, [str(check) for check in certificate.failures]
    assert certificate.failures == ()


def test_a_certificate_prints_what_passed_what_did_not_and_its_margin(lane: PlanningTask) -> None:
    assert str(verify(lane, straight())).splitlines()[0] == "13 of 13 checks passed"
    short = verify(lane, straight(2))
    assert str(short).startswith("12 of 13 checks passed\n  FAILED goal (")
    near = replace(short, margin=ClearanceMargin(0.02, 1.5, ("coin – bench",)))
    assert str(near).endswith("\n  smallest clearance 20 mm at t = 1.5 s (coin – bench)")


def test_the_checks_are_those_that_a_report_promises(lane: PlanningTask) -> None:
    names = [check.name for check in verify(lane, straight()).checks]
    assert len(names) == len(set(names))
    assert {"start", "time", "dynamics", "constraints", "inputs", "error growth"} <= set(names)
    assert {"drift", "limits", "goal", "collision"} <= set(names)


def test_a_motion_under_torques_passes_and_its_error_is_the_integrators(lane: PlanningTask) -> None:
    start = [-1.0, 0, 0, 0, 0, 4.0]
    certificate = verify(lane, rolling(start, [0.1, 0.05], 14))
    value = {check.name: check.value for check in certificate.checks}
    assert failed(certificate) == set()
    assert value["dynamics"] < 1e-8  # of the scales; DOP853 is asked for 1e-9 per step
    assert value["drift"] < 1e-7  # 14 steps of that


def test_whole_turns_of_the_start_make_no_difference(lane: PlanningTask) -> None:
    turned = straight()
    turned = replace(turned, x=turned.x + np.array([0, 0, 2 * np.pi, -4 * np.pi, 0, 0]))
    assert failed(verify(lane, turned)) == set()


def test_a_motion_of_no_length_passes_where_the_start_is_in_the_goal(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "start.x=0.2")
    still = Trajectory(
        np.zeros(1), np.array([[0.2, 0, 0, 0, 0, 0]]), np.zeros((0, 2)), *_names(problem)
    )
    assert failed(verify(problem, still)) == set()


def _names(problem: PlanningTask) -> tuple[tuple[str, ...], tuple[str, ...]]:
    return problem.model.state_names, problem.model.control_names


# --- what is wrong ---


def test_no_scale_is_large_enough_to_switch_a_check_off(lane: PlanningTask) -> None:
    vast = replace(lane, scales=np.full(6, 1e12))
    assert failed(verify(vast, straight())) == set()
    beside = straight()
    beside.x[:, 1] += 0.03
    assert "start" in failed(verify(vast, beside))
    beside = straight()
    beside.x[3, 1] += 1e-3
    assert "dynamics" in failed(verify(vast, beside))


@pytest.mark.parametrize("knot", [1, 10, 20])
def test_a_state_shifted_by_a_millimetre_fails_the_dynamics(lane: PlanningTask, knot: int) -> None:
    bent = straight()
    bent.x[knot, 0] += 1e-3
    certificate = verify(lane, bent)
    assert "dynamics" in failed(certificate) <= {"dynamics", "drift"}
    words = detail(certificate, "dynamics")
    assert "x is" in words
    assert STEP * knot - 1e-9 <= time_in(words) <= STEP * (knot + 1) + 1e-9


def test_a_shift_that_stays_fails_the_dynamics_where_it_begins(lane: PlanningTask) -> None:
    bent = straight()
    bent.x[7:, 1] += 1e-3
    words = detail(verify(lane, bent), "dynamics")
    assert "y is" in words
    assert time_in(words) == pytest.approx(7 * STEP)


@pytest.mark.parametrize(("input_", "name"), [(0, "drive"), (1, "steer")])
@pytest.mark.parametrize("sign", [1, -1])
def test_an_input_a_millionth_beyond_its_limit_fails(
    table: PlanningTask, input_: int, name: str, sign: int
) -> None:
    limit = [1.0, 0.5][input_]
    u = np.zeros((20, 2))
    u[3, input_] = sign * (limit + 1e-6)
    u[4, input_] = -u[3, input_] / 2
    bad = coin_motion([-1.0, 0, 0, 0, 0, 0], STEP * np.arange(21, dtype=float), u)
    certificate = verify(table, bad)
    assert "inputs" in failed(certificate) <= {"inputs", "goal"}  # the coin hardly moves
    words = detail(certificate, "inputs")
    assert name in words
    assert time_in(words) == pytest.approx(3 * STEP)
    assert next(c.value for c in certificate.checks if c.name == "inputs") == pytest.approx(1e-6)


def test_an_input_at_its_limit_passes(table: PlanningTask) -> None:
    full = rolling([-1.0, 0, 0, 0, 0, 0], [1.0, 0.0], 16)  # 8/3 m/s^2 for 0.8 s: 0.85 m
    assert failed(verify(table, full)) == set()


@pytest.mark.parametrize(("state", "shift"), [(0, 1e-3), (1, -1e-3), (2, 0.01), (5, 1e-6)])
def test_a_motion_that_starts_elsewhere_fails_the_start(
    lane: PlanningTask, state: int, shift: float
) -> None:
    start = np.array([-1.0, 0, 0, 0, 0, 4.0])
    start[state] += shift
    certificate = verify(lane, rolling(start.tolist(), [0, 0], 20))
    assert failed(certificate) == {"start"}
    assert lane.model.state_names[state] in detail(certificate, "start")


def test_a_repeated_row_fails_the_time(lane: PlanningTask) -> None:
    good = straight()
    bad = Trajectory(
        np.insert(good.t, 5, good.t[5]),
        np.insert(good.x, 5, good.x[5], axis=0),
        np.insert(good.u, 5, good.u[5], axis=0),
        *_names(lane),
    )
    certificate = verify(lane, bad)
    assert failed(certificate) == {"time"}
    assert "row 6" in detail(certificate, "time")


def test_a_row_that_goes_back_in_time_fails_the_time(lane: PlanningTask) -> None:
    good = straight()
    t = good.t.copy()
    t[5] = t[3]
    assert "time" in failed(verify(lane, replace(good, t=t)))


def test_a_motion_that_does_not_begin_at_zero_fails_the_time(lane: PlanningTask) -> None:
    good = straight()
    assert failed(verify(lane, replace(good, t=good.t + 1.0))) == {"time"}


def test_a_shorter_step_fails_the_time_where_steps_are_what_counts(tmp_path: Path) -> None:
    """In between is no state of a discrete problem, even where the motion is the same."""
    lane = problem_of(tmp_path, OPEN, "start.phi_dot=4", 'integration.truth="discrete"')
    good = straight()
    assert failed(verify(lane, good)) == set()
    half = (good.t[5:6] + good.t[4]) / 2, (good.x[5:6] + good.x[4]) / 2
    t, x = (
        np.insert(whole, 5, row, axis=0) for whole, row in zip((good.t, good.x), half, strict=True)
    )
    certificate = verify(lane, Trajectory(t, x, np.insert(good.u, 5, 0.0, axis=0), *_names(lane)))
    assert failed(certificate) == {"time"}
    assert "row 5 does not come one step after" in detail(certificate, "time")


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize(
    ("array", "entry"),
    [("x", (0, 0)), ("x", (9, 5)), ("x", (20, 1)), ("u", (0, 0)), ("u", (19, 1)), ("t", (20,))],
)
def test_a_number_that_is_not_finite_fails_and_never_raises(
    lane: PlanningTask, array: str, entry: tuple[int, ...], wrong: float
) -> None:
    bad = straight()
    getattr(bad, array)[entry] = wrong
    with within(60):
        certificate = verify(lane, bad)
    assert not certificate.passed


@pytest.mark.parametrize("off", [2e-7, 5e-7, 9e-7])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_last_row_outside_the_goal_fails_it_though_the_motion_ends_inside(
    off: float, side: float, lane: PlanningTask
) -> None:
    """The row is off by less than a defect may be, and the goal's edge lies between both."""
    motion = straight()
    x = motion.x.copy()
    x[-1, 0] += side * off
    tolerance = 1e-7
    goal = replace(lane.goal, targets=motion.x[-1, :2], tolerances=np.full(2, tolerance))
    certificate = verify(replace(lane, goal=goal), replace(motion, x=x))
    assert failed(certificate) == {"goal"}
    assert detail(certificate, "goal").startswith(f"the last row: x is off by {off:.1g}"[:30])
    assert verify(replace(lane, goal=goal), motion).passed


def test_a_motion_cut_short_fails_the_goal_and_says_by_how_much(lane: PlanningTask) -> None:
    certificate = verify(lane, straight(steps=8))  # ends at x = -0.6, the goal begins at -0.5
    assert failed(certificate) == {"goal"}
    assert "x is off by 0.6" in detail(certificate, "goal")
    value = next(check.value for check in certificate.checks if check.name == "goal")
    assert value == pytest.approx(0.6 / 0.5)


@pytest.mark.parametrize(("x", "passes"), [(-0.5 - 1e-4, False), (-0.5 + 1e-4, True)])
def test_the_goal_ends_where_its_tolerance_does(lane: PlanningTask, x: float, passes: bool) -> None:
    certificate = verify(lane, straight(steps=10, step=(1 + x) / 10))
    assert ("goal" not in failed(certificate)) == passes


def test_a_rate_beyond_its_limit_fails_the_limits(tmp_path: Path) -> None:
    """Steering by 0.1 N m on J = m R^2 / 4 gives 6.4 rad/s^2: 3.2 rad/s after 0.5 s."""
    problem = problem_of(tmp_path, OPEN, "start.phi_dot=4", "bounds.psi_dot=[-2, 2]")
    certificate = verify(problem, rolling([-1.0, 0, 0, 0, 0, 4.0], [0, 0.1], 10))
    assert failed(certificate) - {"goal"} == {"limits"}
    words = detail(certificate, "limits")
    assert "psi_dot is 3.2" in words
    assert "outside -2 to 2" in words
    assert time_in(words) == pytest.approx(0.5)


def test_a_position_outside_the_world_fails_the_limits(tmp_path: Path) -> None:
    problem = problem_of(
        tmp_path, OPEN, "start.phi_dot=4", "world.bounds.x=[-5, 0.5]", "goal.tolerance=1"
    )
    certificate = verify(problem, straight(steps=36))  # to x = 0.8
    assert failed(certificate) == {"limits"}
    assert "x is 0.8" in detail(certificate, "limits")


def test_a_limit_that_is_passed_between_two_knots_only_fails(tmp_path: Path) -> None:
    """Forth and back within one interval: from x = -1 to -0.75 and home, at -2 m/s^2."""
    back = -8.0 * 1.5 * COIN.m * COIN.R**2  # [N m] for phi_ddot = -8 rad/s^2
    problem = problem_of(
        tmp_path, OPEN, "start.phi_dot=4", "bounds.x=[-5, -0.8]", "goal={y=0, tolerance=1}"
    )
    certificate = verify(problem, rolling([-1.0, 0, 0, 0, 0, 4.0], [back, 0], 1, step=1.0))
    assert failed(certificate) == {"limits"}
    assert time_in(detail(certificate, "limits")) == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize(("room", "passes"), [(-1e-6, False), (1e-6, True)])
def test_a_limit_that_is_passed_by_a_millionth_between_two_samples_fails(
    tmp_path: Path, room: float, passes: bool
) -> None:
    """The coin turns on the spot by t - t^2: at most 1/4 rad, and no sample is at t = 1/2."""
    problem = problem_of(
        tmp_path,
        OPEN,
        "start.psi_dot=1",
        f"bounds.psi=[-1, {0.25 + room}]",
        "goal={ y = 0, tolerance = 1 }",
    )
    turn = rolling([-1.0, 0, 0, 0, 1.0, 0], [0, -2 * COIN.diametral], 1, step=1.1)
    certificate = verify(problem, turn)
    assert failed(certificate) == (set() if passes else {"limits"})
    if not passes:
        words = detail(certificate, "limits")
        assert "psi is 0.25," in words
        assert time_in(words) == pytest.approx(0.5, abs=1e-4)


def test_a_limit_that_is_passed_just_after_an_input_changed_fails(lane: PlanningTask) -> None:
    """The coin turns on by w for a second, then by w s - s^2 / 2: highest at s = w, by w^2 / 2."""
    torques: Array = np.array([[0.0, 0.0], [0.0, -COIN.diametral]])
    for w in np.linspace(1e-3, 2e-2, 40):  # [rad/s]: at, before and behind samples
        start = np.array([-1.0, 0, 0, 0, w, 0])
        turn = coin_motion(start.tolist(), np.array([0.0, 1.0, 2.0]), torques)
        for share, passes in ((0.9, False), (1.1, True)):
            bounds = lane.bounds.copy()
            bounds[2] = -1.0, w + share * w**2 / 2
            certificate = verify(replace(lane, start=start, bounds=bounds), turn)
            assert ("limits" not in failed(certificate)) == passes, f"w = {w}, share {share}"


@pytest.mark.parametrize(("room", "passes"), [(-1e-6, False), (1e-6, True)])
def test_a_requirement_that_is_broken_by_a_millionth_between_two_samples_fails(
    tmp_path: Path, room: float, passes: bool
) -> None:
    """A lift rises by t - t^2 m, at most by 1/4 m, where a little less or more is required."""
    z = length("z", -1, 1, speed=2.0)
    lift = System(
        "lift",
        bodies=[Body("cabin", move(0, 0, z), mass=1.0, shape=Sphere(0.1))],
        inputs=[Drive("lift", on=z, limit=3.0)],
        requirements=[require(0.25 + room - z, "room above")],
    )
    (tmp_path / "lift.json").write_text(machine_to_json(lift))
    text = 'schema = 1\ntitle = "A lift"\n[system]\nfile = "lift.json"\n[goal]\nz = 0.0\n'
    problem = problem_of(tmp_path, text, "start={ z_dot = 1 }", "goal.tolerance=1")
    x = np.array([[0.0, 1.0], [1.1 - 1.1**2, 1 - 2.2]])
    motion = Trajectory(np.array([0.0, 1.1]), x, np.array([[-2.0]]), *_names(problem))
    certificate = verify(problem, motion)
    assert failed(certificate) == (set() if passes else {"requirements"})
    if not passes:
        assert "room above: short by 1e-06" in detail(certificate, "requirements")


# --- contact ---


def test_an_obstacle_moved_into_the_way_fails_the_collision(tmp_path: Path) -> None:
    """The coin's rim, R ahead of its centre, meets the wall's face at x = -0.65."""
    wall = WALL.replace("position = [3.0", "position = [-0.3").replace("0.1, 4.0", "0.2, 4.0")
    problem = problem_of(tmp_path, OPEN + wall, "start.phi_dot=4")
    certificate = verify(problem, straight())
    assert failed(certificate) == {"collision"}
    words = detail(certificate, "collision")
    assert "coin" in words
    assert "wall" in words
    expected = (-0.4 - COIN.R) - (-1.0)  # [s] at 1 m/s
    assert expected - 1e-4 <= time_in(words) <= expected + 2 * MAX_SPACING


@pytest.mark.parametrize(("gap", "passes"), [(1e-4, True), (-1e-4, False)])
def test_passing_a_wall_by_a_tenth_of_a_millimetre_decides(
    tmp_path: Path, gap: float, passes: bool
) -> None:
    """The wall is parallel to the way, its face a gap beside the coin's flat side."""
    y = 0.025 + 0.05 + gap
    wall = f'\n[[world.obstacle]]\nname = "wall"\nbox = [4, 0.1, 1]\nposition = [0, {y}, 0.5]\n'
    problem = problem_of(tmp_path, OPEN + wall, "start.phi_dot=4")
    assert ("collision" not in failed(verify(problem, straight()))) == passes


@pytest.mark.parametrize("thickness", [0.1, 0.01, 0.001])
def test_a_coin_pushed_through_a_wall_between_two_knots_fails(
    tmp_path: Path, thickness: float
) -> None:
    wall = WALL.replace("[0.1,", f"[{thickness},").replace("[3.0", "[-0.5")
    problem = problem_of(tmp_path, OPEN + wall, "start.phi_dot=4")
    certificate = verify(problem, straight(steps=1, step=1.0))  # both knots are free
    assert failed(certificate) == {"collision"}
    expected = (-0.5 - thickness / 2 - COIN.R) - (-1.0)  # [s] at 1 m/s
    assert (
        expected - 1e-4 <= time_in(detail(certificate, "collision")) <= expected + 2 * MAX_SPACING
    )


@pytest.mark.parametrize(("dip", "passes"), [(2e-6, False), (0.5e-6, True)])
def test_a_foot_that_sinks_between_two_knots_only_fails(
    tmp_path: Path, dip: float, passes: bool
) -> None:
    """Down and up again within one interval of 2 s: z = 0.1 + v (t^2/2 - t), v = 2 dip."""
    x, z = length("x", -2, 2, speed=2.0), length("z", -1, 1, speed=2.0)
    foot = Body("foot", move(x, 0, z), mass=1.0, shape=Sphere(0.1), touches_ground=True)
    drives = [Drive("walk", on=x, limit=1.0), Drive("step", on=z, limit=1.0)]
    (tmp_path / "foot.json").write_text(
        machine_to_json(System("foot", bodies=[foot], inputs=drives))
    )
    text = """
schema = 1
title = "A foot"
[system]
file = "foot.json"
[world]
ground = "plane"
[goal]
x = 1.0
tolerance = 0.1
"""
    problem = problem_of(tmp_path, text, f"start={{ z=0.1, x_dot=0.5, z_dot={-2 * dip} }}")
    end = problem.start + np.array([1.0, 0.0, 0.0, 4 * dip])
    motion = Trajectory(
        np.array([0.0, 2.0]), np.array([problem.start, end]), np.array([[0.0, 2 * dip]]),
        *_names(problem),
    )  # fmt: skip
    certificate = verify(problem, motion)
    assert failed(certificate) == (set() if passes else {"collision"})
    if not passes:
        assert "foot sinks into ground" in detail(certificate, "collision")


def test_a_turn_on_the_spot_into_a_post_fails(tmp_path: Path) -> None:
    """A post of radius 0.02 stands 0.2 m to the left: free for psi = 0, hit on the way to 90°."""
    post = (
        '\n[[world.obstacle]]\nname = "post"\ncylinder = [0.02, 1.0]\nposition = [-1, 0.2, 0.5]\n'
    )
    problem = problem_of(tmp_path, OPEN + post, "start.psi_dot=2", "goal={x=-1, tolerance=1}")
    certificate = verify(problem, rolling([-1.0, 0, 0, 0, 2.0, 0], [0, 0], 1, step=np.pi))
    assert failed(certificate) == {"collision"}
    # The outline's long side, 0.025 m off the centre line, reaches the post's near side.
    expected = (np.pi / 2 - np.arcsin((0.02 + 0.025) / 0.2)) / 2
    assert expected - 1e-3 <= time_in(detail(certificate, "collision")) <= expected + 0.02


@pytest.mark.parametrize("place", np.linspace(0.1, 0.2, 6).tolist())
def test_a_coin_smaller_than_the_spacing_of_checks_cannot_pass_a_sheet(
    tmp_path: Path, place: float
) -> None:
    """A coin of 4 mm rolls through a sheet of 1 mm: it overlaps over 5 mm of its way."""
    sheet = f"""
[[world.obstacle]]
name = "sheet"
box = [0.001, 0.5, 0.5]
position = [{place}, 0.0, 0.0]
"""
    text = OPEN.replace('name = "rolling_disk"', 'name = "rolling_disk"\nparameters = {R = 0.002}')
    problem = problem_of(
        tmp_path, text + sheet, "start={phi_dot=10}", "goal.x=0.3", 'world.ground="none"'
    )
    t = np.linspace(0.0, 15.0, 4)  # 0.02 m/s for 15 s
    x = np.zeros((4, 6))
    x[:, 0], x[:, 3], x[:, 5] = 0.02 * t, 10 * t, 10.0
    motion = Trajectory(t, x, np.zeros((3, 2)), *_names(problem))
    assert failed(verify(problem, motion)) == {"collision"}


@pytest.fixture(scope="module")
def swing(tmp_path_factory: pytest.TempPathFactory) -> tuple[PlanningTask, Trajectory]:
    """A pendulum released at 1 rad, two periods in one interval, a block where it hangs lowest.

    Its period is 4 sqrt(l / g) K(sin^2(1/2)) (Landau, Lifshitz, Mechanics, section 11).
    """
    text = """
schema = 1
title = "A pendulum and a block"
[system]
name = "pendulum"
[[world.obstacle]]
name = "block"
box = [0.1, 0.1, 0.1]
position = [1.0, 0.0, 0.0]
[start]
theta = 1.0
[goal]
theta = 1.0
"""
    problem = problem_of(tmp_path_factory.mktemp("swing"), text)
    period = 4 * np.sqrt(1 / 9.81) * float(ellipk(np.sin(0.5) ** 2))
    t = np.array([0.0, 2 * period])
    return problem, Trajectory(
        t, np.array([[1.0, 0.0], [1.0, 0.0]]), np.zeros((1, 1)), *_names(problem)
    )


def test_a_swing_that_rests_whenever_it_is_looked_at_still_fails_the_collision(
    swing: tuple[PlanningTask, Trajectory],
) -> None:
    """At every quarter of the interval the bob is at rest; in between it hits the block."""
    assert "collision" in failed(verify(*swing))


def test_a_swing_that_rests_whenever_it_is_looked_at_still_fails_the_limits(
    swing: tuple[PlanningTask, Trajectory],
) -> None:
    """Its largest rate is 2 sqrt(g / l) sin(1/2) = 3 rad/s."""
    problem = replace(swing[0], bounds=np.array([[-np.inf, np.inf], [-2.0, 2.0]]))
    assert "limits" in failed(verify(problem, swing[1]))


def test_an_interval_too_long_to_be_checked_closely_fails_the_collision(tmp_path: Path) -> None:
    """120 km at 3 m/s in one interval, and a wall across the way somewhere after half of it."""
    wall = WALL.replace("[3.0", "[60000.75")
    overrides = ("world.bounds.x=[-5, 200000]", "start={ phi_dot = 12 }", "goal={ y = 0 }")
    problem = problem_of(tmp_path, OPEN + wall, *overrides)
    t = np.array([0.0, 40_000.0])  # [s]
    x = np.array([[3 * time, 0, 0, 12 * time, 0, 12] for time in t])
    motion = Trajectory(t, x, np.zeros((1, 2)), *_names(problem))
    assert "collision" in failed(verify(problem, motion))


def test_an_axis_that_must_keep_out_of_a_cone_is_checked_or_refused(tmp_path: Path) -> None:
    """The pendulum hangs along x, in the middle of the cone, all the time."""
    text = """
schema = 1
title = "A pendulum that may not hang"
[system]
name = "pendulum"
[goal]
theta = 0.0
[[keep_out]]
body = "bob"
axis = "x"
direction = [1, 0, 0]
half_angle = 0.5
"""
    try:
        problem = problem_of(tmp_path, text)
    except InputError as refused:
        assert "keep_out" in str(refused)  # noqa: PT017  # either answer is right
        return
    hanging = Trajectory(np.array([0.0, 0.1]), np.zeros((2, 2)), np.zeros((1, 1)), *_names(problem))
    assert not verify(problem, hanging).passed


# --- an independent judge: closed form and plane geometry ---


def separation(states: Array, centre: Array, half: Array) -> Array:
    """Return the gap in [m] between the coin's outline and axis-parallel boxes from above.

    Separating axes of two rectangles: the largest gap over the four edge normals is a lower bound
    of the distance, and negative exactly where they overlap.

    Args:
        states: Of the coin, shape (n, 6).
        centre: Of the boxes, shape (boxes, 2).
        half: Half edges of the boxes, shape (boxes, 2).

    Source: Gottschalk, Lin, Manocha, OBBTree, SIGGRAPH 1996.
    """
    c, s = np.cos(states[:, 2])[:, None], np.sin(states[:, 2])[:, None]
    d = centre - states[:, None, :2]
    world = np.stack(
        [
            np.abs(d[..., 0]) - half[:, 0] - HALF[0] * np.abs(c) - HALF[1] * np.abs(s),
            np.abs(d[..., 1]) - half[:, 1] - HALF[0] * np.abs(s) - HALF[1] * np.abs(c),
            np.abs(c * d[..., 0] + s * d[..., 1])
            - HALF[0]
            - half[:, 0] * np.abs(c)
            - half[:, 1] * np.abs(s),
            np.abs(-s * d[..., 0] + c * d[..., 1])
            - HALF[1]
            - half[:, 0] * np.abs(s)
            - half[:, 1] * np.abs(c),
        ]
    )
    return np.asarray(world.max(axis=0).min(axis=1))


def maze_boxes() -> tuple[Array, Array]:
    """Return centres and half edges of the maze's walls and blocks; all reach z = R."""
    script = run_path(str(ROOT / "tools" / "meshes" / "write_meshes.py"))
    segments = np.array(script["DISK_MAZE"])
    low, high = (
        np.minimum(segments[:, :2], segments[:, 2:]),
        np.maximum(segments[:, :2], segments[:, 2:]),
    )
    blocks = np.array([[1.6, 7.0, 0.8, 0.8], [4.9, 2.6, 0.5, 1.2], [8.0, 4.2, 1.4, 0.5]])
    centre = np.vstack([(low + high) / 2, blocks[:, :2]])
    half = np.vstack([(high - low + script["THICKNESS"]) / 2, blocks[:, 2:] / 2])
    return centre, half


def dense(motion: Trajectory, pieces: int) -> Array:
    """Return states between the knots of a motion from its first state, in closed form."""
    x, found = motion.x[0], []
    for k, held in enumerate(motion.u):
        span = motion.t[k + 1] - motion.t[k]
        states = coin_after(x, held, span * np.arange(1, pieces + 1) / pieces)
        found.append(states)
        x = states[-1]
    return np.vstack([motion.x[:1], *found])


def test_the_plan_of_the_maze_is_free_and_true_by_hand(solved: Solver) -> None:
    maze = solved("rolling_disk_maze")
    motion = maze.trajectory
    states = dense(motion, 40)
    assert np.abs(states[::40] - motion.x).max() < 1e-5  # [m], [rad]: DOP853 over 30 s and turns
    assert np.abs(states[-1, :2] - 9.0).max() <= 0.25
    assert (np.abs(motion.u) <= [1.0, 0.5]).all()  # [N m]
    assert (np.abs(states[:, 4:]) <= [4.0 + 1e-6, 12.0 + 1e-6]).all()  # [rad/s]
    assert separation(states, *maze_boxes()).min() > 0  # every 4 mm or less
    assert maze.plan.certificate is not None
    assert maze.plan.certificate.passed


def test_random_motions_in_the_maze_get_the_verdict_of_plane_geometry(solved: Solver) -> None:
    """Motions that miss or overlap by less than 2 mm are left out: checks are 10 mm apart."""
    problem = solved("rolling_disk_maze").problem
    boxes = maze_boxes()
    verdicts: list[bool] = []
    generator = np.random.default_rng(1)
    while len(verdicts) < 30:
        start = np.array([*generator.uniform(0.3, 9.7, 2), *generator.uniform(-3, 3, 4)])
        u = generator.uniform(-1, 1, (4, 2)) * [0.5, 0.05]
        motion = coin_motion(start.tolist(), np.array([0, 0.1, 0.3, 0.35, 0.6]), u)
        gap = separation(dense(motion, 100), *boxes).min()
        if abs(gap) > 2e-3:
            hit = "collision" in failed(verify(replace(problem, start=start), motion))
            assert hit == (gap < 0), f"gap {gap} from {start}"
            verdicts.append(hit)
    assert {True, False} == set(verdicts)


def test_random_poses_in_the_maze_get_the_verdict_of_plane_geometry(solved: Solver) -> None:
    problem = solved("rolling_disk_maze").problem
    generator, checker = np.random.default_rng(2), problem.checker()
    states = np.zeros((3000, 6))
    states[:, :2] = generator.uniform(0, 10, (3000, 2))
    states[:, 2:4] = generator.uniform(-np.pi, np.pi, (3000, 2))
    gaps = separation(states, *maze_boxes())
    clear = np.abs(gaps) > 1e-5  # [m]; the mesh is stored in single precision
    hits = np.array([checker.collides(problem.frames(x)) for x in states])
    assert (hits == (gaps < 0))[clear].all()
    assert 100 < hits.sum() < 2900


# --- drift and growth ---


def test_small_errors_that_add_up_do_not_move_the_verdict_on_the_goal(lane: PlanningTask) -> None:
    """Knots that cheat by less than a defect each still end where the inputs really lead."""
    honest = rolling([-1.0, 0, 0, 0, 0, 4.0], [0, 0], 400, step=0.499e-3 * 2.5)  # to x = -0.501
    cheat = replace(honest, x=honest.x + np.linspace(0, 1.6e-3, 401)[:, None] * np.eye(6)[0])
    assert cheat.x[-1, 0] > -0.5
    assert not verify(lane, cheat).passed


def test_a_balancing_machine_is_found_too_sensitive(tmp_path: Path) -> None:
    """Upright, errors grow as exp(sqrt(g / l) t): 1e6 is passed after 4.4 s, 1e8 after 5.9 s."""
    text = 'schema = 1\ntitle = "Upright"\n[system]\nname = "pendulum"\n'
    ends = f"[start]\ntheta = {np.pi}\n[goal]\ntheta = {np.pi}\n"
    problem = problem_of(tmp_path, text + ends)
    t = np.linspace(0.0, 6.0, 61)
    motion = resimulate(problem, t, np.zeros((60, 1)))
    assert "error growth" in failed(verify(problem, motion))
    t = np.linspace(0.0, 3.0, 31)
    motion = resimulate(problem, t, np.zeros((30, 1)))
    assert "error growth" not in failed(verify(problem, motion))


def test_every_pair_of_shifted_start_and_turn_is_judged_on_the_circle(lane: PlanningTask) -> None:
    for psi, phi in product([0.0, 2 * np.pi], [0.0, -2 * np.pi]):
        motion = rolling([-1.0, 0, psi, phi, 0, 4.0], [0, 0], 20)
        assert "start" not in failed(verify(lane, motion))
    motion = rolling([-1.0, 0, np.pi, 0, 0, 4.0], [0, 0], 4)
    assert "start" in failed(verify(lane, motion))


def test_verification_does_not_change_what_it_judges(short: Solved) -> None:
    before = [array.tobytes() for array in (short.trajectory.t, short.trajectory.x)]
    verify(short.problem, short.trajectory)
    assert [a.tobytes() for a in (short.trajectory.t, short.trajectory.x)] == before

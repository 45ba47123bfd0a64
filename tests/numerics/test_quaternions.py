"""Attitudes: quaternions against SciPy's rotations, and in scenarios, goals and plans."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.stats import ks_2samp, kstest

from kinolab import planners
from kinolab.errors import InputError
from kinolab.loading import build_problem, find_scenario
from kinolab.numerics.manifolds.rotations import (
    multiply,
    of_matrices,
    slerp,
    to_matrices,
    turn_between,
    unit,
)
from kinolab.numerics.manifolds.state_parts import Rotations
from kinolab.problem import PlanningTask
from kinolab.problem.goal import PartTarget
from kinolab.runs import read_run, write_run
from kinolab.scenario import load_scenario, write_scenario
from kinolab.search import Budget
from kinolab.simulation.reference import reference_motion
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from tests.support import detail, failed, plan, problem_of

Array = NDArray[np.float64]

ATTITUDE = Rotations("R", 0, 4)
HALF_TURNS = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0.6, 0.8, 0, 0], [0, 0.6, 0, 0.8]]


def attitudes(count: int) -> Array:
    """Rotations at random, none, and half turns, where signs and roots are delicate."""
    drawn = Rotation.random(count, random_state=1).as_quat()
    nearly = Rotation.from_rotvec([[np.pi - 1e-9, 0, 0], [0, 1e-9, 0], [0, 0, 0]]).as_quat()
    return np.vstack([drawn, nearly, HALF_TURNS])


def test_matrices_of_attitudes_are_scipys() -> None:
    q = attitudes(200)
    matrices = Rotation.from_quat(q).as_matrix()
    np.testing.assert_allclose(to_matrices(q), matrices, atol=1e-15)
    np.testing.assert_allclose(turn_between(of_matrices(matrices), q), 0.0, atol=1e-15)
    assert of_matrices(matrices.reshape(4, 52, 3, 3)).shape == (4, 52, 4)


def test_slerp_turns_at_a_constant_rate_along_the_shorter_way() -> None:
    """Between rotations a and b it is a exp(s log(a^-1 b)), by SciPy's exp and log."""
    a, b = attitudes(200)[:200], attitudes(400)[200:400]
    s = np.linspace(0.0, 1.0, 200)
    turn = (Rotation.from_quat(a).inv() * Rotation.from_quat(b)).as_rotvec()
    want = Rotation.from_quat(a) * Rotation.from_rotvec(s[:, None] * turn)
    for sign in (1.0, -1.0):
        np.testing.assert_allclose(to_matrices(slerp(a, sign * b, s)), want.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(slerp(a, a, s), a, atol=1e-15)


WATER = """\
schema = 1
title = "A submarine in open water"

[system]
name = "submarine"

[world]
bounds = { x = [-20, 20], y = [-20, 20], z = [-20, 0] }

[start]
z = -10.0

[goal]
R = [0.0, 0.0, 1.0, 1.0]

[goal.tolerance]
R = 0.3

[planner]
improve = 0
time_limit = 20.0
"""

SEED = 18  # of a short plan
QUARTER = Rotation.from_euler("z", 90, degrees=True)  # the goal's attitude: a yaw to the left
ROTATION = "Give its quaternion [x, y, z, w]; [0, 0, 0, 1] is not turned."
COORDINATE = (
    'Give a number, an angle such as "pi/2" or "90 deg", or four numbers x, y, z, w for a rotation.'
)


def pairs(count: int) -> list[tuple[Rotation, Rotation]]:
    """Random pairs of rotations."""
    generator = np.random.default_rng(1843)
    first, second = (Rotation.from_quat(generator.normal(size=(count, 4))) for _ in range(2))
    return list(zip(first, second, strict=True))


def angle_from(x: Array, target: Rotation) -> float:
    """The angle in [rad] between the submarine's attitude at a state and a rotation."""
    return float((Rotation.from_quat(x[3:7]).inv() * target).magnitude())


# --- the arithmetic ---


def test_the_angle_between_two_attitudes_is_that_of_the_turn_from_one_to_the_other() -> None:
    for a, b in pairs(300):
        p, q = a.as_quat(), b.as_quat()
        wanted = float((a.inv() * b).magnitude())
        assert turn_between(p, q) == pytest.approx(wanted, abs=1e-14)  # [rad] rounding
        assert turn_between(q, p) == turn_between(p, q) == turn_between(-p, q)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-9, 1e-4, 1.0, np.pi - 1e-9, np.pi])
def test_the_smallest_and_largest_angles_keep_their_digits(angle: float) -> None:
    """An arc cosine would lose everything below 1e-8 rad."""
    for a, b in pairs(50):
        axis = b.apply([1.0, 0.0, 0.0])
        p, q = a.as_quat(), (a * Rotation.from_rotvec(angle * axis)).as_quat()
        assert turn_between(p, q) == pytest.approx(angle, abs=3e-15)  # [rad] ten roundings
        assert turn_between(p, -q) == pytest.approx(angle, abs=3e-15)


def test_an_attitude_is_not_turned_from_itself_whatever_its_sign() -> None:
    for a, _ in pairs(50):
        q = a.as_quat()
        assert turn_between(q, q) == turn_between(q, -q) == 0.0


@pytest.mark.parametrize("size", [5e-324, 1e-300, 1e-160, 1.0, 3.0, 1e160, 1.7e308])
def test_a_quaternion_of_any_length_is_made_unit(size: float) -> None:
    assert unit([0.0, 0.0, size, -size]) == pytest.approx([0, 0, np.sqrt(0.5), -np.sqrt(0.5)])
    assert np.linalg.norm(unit([0.0, size, 0.0, 0.0])) == 1.0


def test_a_product_turns_in_the_axes_of_the_first() -> None:
    for a, b in pairs(100):
        product = multiply(a.as_quat(), b.as_quat())
        matrix = a.as_matrix() @ b.as_matrix()
        assert Rotation.from_quat(product).as_matrix() == pytest.approx(matrix, abs=1e-14)
        assert np.linalg.norm(product) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("angle", [1e-9, 0.1, 2.0, np.pi])
def test_a_random_turn_is_within_its_angle_and_has_no_favourite_axis(angle: float) -> None:
    generator, (base, _) = np.random.default_rng(0), pairs(1)[0]
    drawn = [ATTITUDE.near(base.as_quat(), angle, generator) for _ in range(2000)]
    turns = (base.inv() * Rotation.from_quat(drawn)).as_rotvec()
    sizes = np.linalg.norm(turns, axis=1)
    assert sizes.max() <= angle + 1e-14  # [rad] rounding
    assert sizes.max() > 0.99 * angle
    # The mean of 2000 directions is 0 within 1/sqrt(3 * 2000) = 0.013 per axis; four of these.
    assert np.abs((turns / sizes[:, None]).mean(axis=0)).max() < 0.052


def test_random_attitudes_are_uniform_on_the_rotations() -> None:
    """Angles have the density (1 - cos) / pi; a turned axis has a uniform height (Archimedes).

    Source: Miles, On random rotations in R^3, Biometrika 52, 1965.
    """
    generator = np.random.default_rng(0)
    drawn = Rotation.from_quat([ATTITUDE.random(generator) for _ in range(2000)])
    assert kstest(drawn.magnitude(), lambda s: (s - np.sin(s)) / np.pi).pvalue > 0.01
    for axis in np.eye(3):
        heights = drawn.apply(axis)[:, 2]
        assert kstest(heights, "uniform", args=(-1.0, 2.0)).pvalue > 0.01


# --- scenarios that are right ---


@pytest.fixture(scope="module")
def water(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    return problem_of(tmp_path_factory.mktemp("water"), WATER)


@pytest.mark.parametrize(
    "given", ["[0, 0, 3, 4]", "[0, 0, 3e-310, 4e-310]", "[0.0, 0, 1.2e308, 1.6e308]"]
)
def test_a_start_that_is_not_of_unit_length_is_made_so(given: str, tmp_path: Path) -> None:
    problem = problem_of(tmp_path, WATER, f"start.R={given}")
    assert problem.start[3:7] == pytest.approx([0, 0, 0.6, 0.8], abs=1e-15)


def test_a_start_without_an_attitude_is_not_turned(water: PlanningTask) -> None:
    assert water.model.attitudes == {"R": 3}
    assert water.start[3:7].tolist() == [0.0, 0.0, 0.0, 1.0]


def test_one_weight_holds_for_a_whole_attitude(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, WATER, "metric={ R = 0.25, R_wx = 3 }")
    weights = dict(zip(problem.model.state_names, problem.weights.tolist(), strict=True))
    assert [weights[f"R_{k}"] for k in "xyzw"] == [0.25] * 4
    assert (weights["x"], weights["R_wx"]) == (1.0, 3.0)


def test_a_machine_that_is_only_simulated_takes_an_attitude_too() -> None:
    scenario = find_scenario("submarine", overrides=["start.R=[1, 0, 0, 0]"])
    assert build_problem(scenario, planning=False).start[3:7].tolist() == [1.0, 0.0, 0.0, 0.0]


def test_a_scenario_with_quaternions_is_written_and_read_without_loss(tmp_path: Path) -> None:
    text = WATER.replace("z = -10.0", "z = -10.0\nR = [0.1, -0.2, 1e-300, 0.7000000000000001]")
    scenario = problem_of(tmp_path, text).scenario
    (tmp_path / "again.toml").write_text(write_scenario(scenario), encoding="utf-8")
    assert load_scenario(tmp_path / "again.toml") == scenario


# --- scenarios that are wrong ---


def refused(folder: Path, text: str, *overrides: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        problem_of(folder, text, *overrides)
    return [str(mistake) for mistake in caught.value.mistakes]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "z = -10.0",
            "R = 1.57",
            f"[start] R: R is a rotation, not a single number. {ROTATION}",
        ),
        (
            "R = [0.0, 0.0, 1.0, 1.0]",
            "R = 1",
            f"[goal] R: R is a rotation, not a single number. {ROTATION}",
        ),
        (
            "z = -10.0",
            "z = [0, 0, 0, 1]",
            "[start] z: z is a single number, not a rotation. Give one number.",
        ),
        (
            "R = [0.0, 0.0, 1.0, 1.0]",
            "R_wz = [0, 0, 0, 1]",
            "[goal] R_wz: R_wz is a single number, not a rotation. Give one number.",
        ),
        (
            "[planner]",
            "[bounds]\nR = [-1, 1]\n[planner]",
            "[bounds] R: R is a rotation, which has no limits. "
            "Limit its rates, or use [[keep_out]].",
        ),
        (
            "z = -10.0",
            "R = [0, 0, 0, 0.0]",
            f"[start] R: [0, 0, 0, 0.0] is zero and has no direction. {COORDINATE}",
        ),
        (
            "[0.0, 0.0, 1.0, 1.0]",
            "[0, 0, 0, 0]",
            f"[goal] R: [0, 0, 0, 0] is zero and has no direction. {COORDINATE}",
        ),
        ("z = -10.0", "R = [0, 0, 1]", f"[start] R: [0, 0, 1] is too short. {COORDINATE}"),
        (
            "z = -10.0",
            "R = [0, 0, 0, 0, 1]",
            f"[start] R: [0, 0, 0, 0, 1] is too long. {COORDINATE}",
        ),
        (
            "z = -10.0",
            "R = [0, nan, 0, 1]",
            f"[start] R: entry 2, nan, is not finite. {COORDINATE}",
        ),
        ("R = 0.3", "R = 0", "[goal] tolerance.R: 0 is too small. Give a number of at least 1e-12"),
    ],
)
def test_a_mistake_is_told_with_its_place_and_what_would_work(
    old: str, new: str, told: str, tmp_path: Path
) -> None:
    assert old in WATER
    (mistake,) = refused(tmp_path, WATER.replace(old, new, 1))
    if told.endswith("at least 1e-12"):
        mistake = mistake[: len("table.toml ") + len(told)]
    assert mistake == f"table.toml {told}"


@pytest.mark.parametrize("section", ["start", "goal", "goal.tolerance", "bounds", "metric"])
def test_the_entries_of_a_quaternion_are_no_coordinates(section: str, tmp_path: Path) -> None:
    value = "[-1, 1]" if section == "bounds" else "0.5"
    (mistake,) = refused(tmp_path, WATER, f"{section}.R_x={value}")
    assert "no coordinate" in mistake
    assert "is called 'R_x'" in mistake


def test_all_wrong_kinds_are_told_together(tmp_path: Path) -> None:
    wrong = ("start.R=1", "start.x=[0, 0, 0, 1]", "goal.R=2", "bounds.R=[0, 1]")
    told = refused(tmp_path, WATER, *wrong)
    places = sorted(mistake.partition(": ")[0] for mistake in told)
    assert places == sorted(f"--set {override}" for override in wrong)


# --- goals ---


def turned(water: PlanningTask, rotation: Rotation) -> Array:
    """The submarine's start with another attitude."""
    x = water.start.copy()
    x[3:7] = rotation.as_quat()
    return x


def test_the_excess_is_the_angle_over_its_tolerance(water: PlanningTask) -> None:
    for a, _ in pairs(50):
        x, wanted = turned(water, a), float((a.inv() * QUARTER).magnitude())
        assert water.goal_excess(x) == pytest.approx(wanted / 0.3, abs=1e-13)
        assert water.goal_distance(x) == pytest.approx(wanted, abs=1e-14)
        x[3:7] *= -1
        assert water.goal_excess(x) == pytest.approx(wanted / 0.3, abs=1e-13)


def test_the_largest_share_counts_and_the_norm_of_all_errors(tmp_path: Path) -> None:
    """Half a metre of a tolerance of 2 m, and 90 degrees of 0.3 rad."""
    overrides = ("goal.x=0.5", "goal.tolerance={ x = 2, R = 0.3 }")
    problem = problem_of(tmp_path, WATER, *overrides)
    assert problem.goal_excess(problem.start) == pytest.approx(np.pi / 2 / 0.3)
    assert problem.goal_distance(problem.start) == pytest.approx(np.hypot(0.5, np.pi / 2))
    x = turned(problem, QUARTER)
    assert problem.goal_excess(x) == pytest.approx(0.25)


def test_a_target_keeps_the_tolerance_of_its_own(tmp_path: Path) -> None:
    (target,) = problem_of(tmp_path, WATER, "goal.tolerance=0.05").goal.parts
    half = float(np.sqrt(0.5))
    assert (target.part.name, target.part.first, target.tolerance) == ("R", 3, 0.05)
    assert target.target == pytest.approx((0, 0, half, half), abs=1e-15)
    assert isinstance(target, PartTarget)


@pytest.mark.parametrize("spread", [1.0, 4.0, 1e6])
def test_samples_of_the_goal_lie_within_the_stretched_tolerance(
    spread: float, water: PlanningTask
) -> None:
    generator = np.random.default_rng(0)
    drawn = np.array([water.sample_goal(generator, spread) for _ in range(500)])
    angles = np.array([angle_from(x, QUARTER) for x in drawn])
    assert angles.max() <= min(0.3 * spread, np.pi) + 1e-14  # [rad] rounding
    assert angles.max() > 0.98 * min(0.3 * spread, np.pi)
    assert np.linalg.norm(drawn[:, 3:7], axis=1) == pytest.approx(1.0, abs=1e-14)
    lower, upper = water.sampling_bounds.T
    assert (drawn >= lower).all()
    assert (drawn <= upper).all()
    if spread == 1.0:
        assert max(map(water.goal_excess, drawn)) <= 1.0


@pytest.mark.parametrize(
    "goal", ["goal.x=0.5", "goal={ x = 3, tolerance = 0.5 }", "goal.norm='euclidean'"]
)
def test_states_drawn_at_once_come_from_where_one_does(goal: str, tmp_path: Path) -> None:
    """By Kolmogorov and Smirnov, entry by entry, and for the angle from the goal's attitude."""
    problem, count = problem_of(tmp_path, WATER, goal), 2000
    one, other = np.random.default_rng(1), np.random.default_rng(2)
    for spread in (1.0, 3.0):
        single = np.array([problem.sample_goal(one, spread) for _ in range(count)])
        drawn = problem.sample_goals(other, np.full(count, spread))
        assert drawn.shape == single.shape
        for a, b in [*zip(single.T, drawn.T, strict=True), angles_of(single, drawn)]:
            assert ks_2samp(a, b).pvalue > 1e-4  # of some thirty, by chance one in 300 runs
        assert np.linalg.norm(drawn[:, 3:7], axis=1) == pytest.approx(1.0, abs=1e-14)


def angles_of(*drawn: Array) -> tuple[Array, ...]:
    return tuple(np.array([angle_from(x, QUARTER) for x in states]) for states in drawn)


def test_each_of_the_states_drawn_at_once_has_its_own_spread(water: PlanningTask) -> None:
    spreads = np.random.default_rng(0).uniform(0.0, 5.0, 500)
    drawn = water.sample_goals(np.random.default_rng(1), spreads)
    shares = np.array([water.goal_excess(x) for x in drawn])
    assert (shares <= np.maximum(spreads, 1e-7)).all()  # an angle is known to 1e-8 rad
    assert (shares > 0.5 * spreads).sum() > 100


def test_an_attitude_that_the_goal_leaves_out_is_drawn_from_all(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, WATER, "goal={ x = 3, tolerance = 0.5 }")
    generator = np.random.default_rng(0)
    drawn = np.array([problem.sample_goal(generator) for _ in range(1000)])
    angles = Rotation.from_quat(drawn[:, 3:7]).magnitude()
    assert kstest(angles, lambda s: (s - np.sin(s)) / np.pi).pvalue > 0.01
    assert np.abs(drawn[:, 0] - 3.0).max() <= 0.5


# --- the verifier ---


def resting(problem: PlanningTask, rotation: Rotation) -> Trajectory:
    """The submarine afloat for a second: with its keel down it stays where it is."""
    x = turned(problem, rotation)
    names = problem.model.state_names, problem.model.control_names
    return Trajectory(np.array([0.0, 1.0]), np.array([x, x]), np.zeros((1, 3)), *names)


@pytest.mark.parametrize(
    ("yaw", "told"),
    [
        (np.pi / 2 - 0.29, ""),
        (np.pi / 2 + 0.29, ""),
        (np.pi / 2 - 0.5, "R is off by 0.5 rad"),
        (np.pi / 2 + 0.3001, "R is off by 0.3001 rad"),
        (-np.pi / 2, "R is off by 3.142 rad"),
    ],
)
def test_the_verifier_says_by_how_much_an_attitude_misses(
    yaw: float, told: str, tmp_path: Path
) -> None:
    rotation = Rotation.from_euler("z", yaw)
    quaternion = ", ".join(map(repr, rotation.as_quat().tolist()))
    problem = problem_of(tmp_path, WATER, f"start.R=[{quaternion}]")
    certificate = verify(problem, resting(problem, rotation))
    assert failed(certificate) == ({"goal"} if told else set())
    assert detail(certificate, "goal") == told


def test_the_verifier_tells_every_part_that_misses(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, WATER, "goal.x=1", "goal.tolerance={ x = 0.5, R = 0.3 }")
    certificate = verify(problem, resting(problem, Rotation.identity()))
    assert detail(certificate, "goal") == "x is off by 1; R is off by 1.571 rad"


# --- plans ---


@pytest.fixture(scope="module")
def turn(water: PlanningTask) -> PlanResult:
    """A plan for the turn to the left."""
    return water.solve(planner="rrt", seed=SEED, max_iterations=5000)


def motion_of(found: PlanResult) -> Trajectory:
    assert found.trajectory is not None, found.message
    return found.trajectory


def inputs(folder: Path, override: str) -> bytes:
    """The bits of the inputs that the search finds where an override applies."""
    planner = planners.get("rrt")()
    return planner.solve(problem_of(folder, WATER, override), SEED, Budget(20.0, 5000)).u.tobytes()


def test_a_quarter_turn_is_found_and_verified(turn: PlanResult) -> None:
    assert turn.status == "solved", turn.certificate
    x = motion_of(turn).x
    assert angle_from(x[-1], QUARTER) <= 0.3  # [rad]
    assert angle_from(x[0], QUARTER) == pytest.approx(np.pi / 2)
    # The truth is integrated to 1e-9; what its quaternions gain in length adds up step by step.
    assert np.linalg.norm(x[:, 3:7], axis=1) == pytest.approx(1.0, abs=1e-7)


@pytest.mark.parametrize("override", ["goal.R=[0, 0, -1, -1]", "start.R=[0, 0, 0, -1]"])
def test_the_sign_of_a_quaternion_does_not_matter(
    override: str, turn: PlanResult, tmp_path: Path
) -> None:
    assert inputs(tmp_path, override) == motion_of(turn).u.tobytes()


def test_a_run_with_attitudes_is_read_back_and_checked(
    water: PlanningTask, turn: PlanResult, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    write_run(folder, water, turn)
    again = read_run(folder)
    assert again.problem.scenario.goal == water.scenario.goal
    assert again.problem.scenario.start == water.scenario.start
    assert write_scenario(again.problem.scenario) == (folder / "scenario.toml").read_text()
    assert again.problem.start.tobytes() == water.start.tobytes()
    assert again.trajectory.x.tobytes() == motion_of(turn).x.tobytes()
    done = plan("check", folder, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"{folder}: passed")


def test_between_the_knots_of_a_discrete_motion_an_attitude_stays_one(tmp_path: Path) -> None:
    """Halfway it is half the turn, and the pose of the hull is no larger or smaller."""
    own = ("integration={ method = 'euler', step = 0.5, truth = 'discrete' }", "start.R_wy=1.0")
    problem = problem_of(tmp_path, WATER, *own)
    motion = reference_motion(problem, problem.start, np.array([0.0, 0.5]), np.zeros((1, 3)))
    halfway = motion.between(0, np.array([0.25]))[0]
    np.testing.assert_allclose(halfway[3:7], Rotation.from_euler("y", 0.25).as_quat(), atol=1e-15)
    turned = problem.frames(halfway)[0].reshape(3, 4)[:, :3]
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-15)

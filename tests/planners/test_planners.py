"""Every planner: repeatable, within its budget, and a failure is a result."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from kinolab import planners
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.search import Budget, Outcome
from kinolab.solve import PlanResult
from tests.conftest import SLOWEST, Solved
from tests.support import OPEN, environment, failed, problem_of, within

every_planner = pytest.mark.parametrize("name", planners.names())


OF_GUESSES = {"shooting": 5, "kinematic_first": 2}  # iterations enough, each of which takes long


def at_most(name: str, most: int) -> int:
    """Return fewer iterations for a planner each of whose iterations is a whole optimisation."""
    return min(most, OF_GUESSES.get(name, most))


def bits(found: PlanResult) -> bytes:
    if found.trajectory is None:
        return b""
    motion = found.trajectory
    return b"".join(array.tobytes() for array in (motion.t, motion.x, motion.u))


@pytest.fixture(scope="module")
def hard(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    """The table with a goal that is not hit by chance, in a pen that has no gate."""
    pen = "".join(
        f"\n[[world.obstacle]]\nbox = {edges}\nposition = [{x}, {y}, 0.5]\n"
        for x, y, edges in [
            *((3.2, 0.0, [0.1, 1.7, 1.0]), (4.8, 0.0, [0.1, 1.7, 1.0])),
            *((4.0, 0.8, [1.7, 0.1, 1.0]), (4.0, -0.8, [1.7, 0.1, 1.0])),
        ]
    )
    folder = tmp_path_factory.mktemp("hard")
    return problem_of(folder, OPEN + pen, "goal.x=4", "goal.tolerance=1e-6")


@pytest.fixture(scope="module")
def still(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    """The table, where rates may hardly differ from 0: every motion breaks a limit."""
    limits = ("bounds.psi_dot=[-1e-9, 1e-9]", "bounds.phi_dot=[-1e-9, 1e-9]")
    return problem_of(tmp_path_factory.mktemp("still"), OPEN, *limits)


@pytest.fixture
def endless(
    request: pytest.FixtureRequest, hard: PlanningTask, still: PlanningTask
) -> PlanningTask:
    """A problem that the planner of a test does not solve.

    kinematic_first looks for seconds for a path into the pen, in each iteration.
    """
    return still if request.getfixturevalue("name") == "kinematic_first" else hard


@every_planner
def test_every_planner_solves_the_table(name: str, table: PlanningTask) -> None:
    found = table.solve(planner=name, seed=1, max_iterations=20_000)
    assert found.status == "solved"
    assert (found.planner, found.seed) == (name, 1)


SEEDS = (0, 2**32 - 1, 2**32, 2**63 - 1)  # that a scenario may have; two by two alike in 32 bits


@every_planner
def test_equal_seeds_give_the_same_bits_and_others_do_not(name: str, table: PlanningTask) -> None:
    """At once, and after other searches.

    A field that leads straight to the goal takes none of the inputs that it draws; what the seed
    does where a field is stuck is tested beside its escapes.
    """

    def made(seed: int) -> tuple[bytes, int]:
        found = table.solve(planner=name, seed=seed, max_iterations=5000)
        return bits(found), found.iterations

    first = {seed: made(seed) for seed in SEEDS}
    for seed in (SEEDS[-1], SEEDS[0]):
        assert made(seed) == first[seed], f"seed {seed}"
    different = {motion for motion, _ in first.values()}
    assert len(different) == len(SEEDS) or name == "potential_field"


ALL_BY_THE_COMMAND_LINE = """
import sys
from kinolab.cli import run
options = ["--seed", "3", "--max-iterations", "1000", "--no-animation", "--quiet"]
options += ["--no-diagnosis", "--no-optimize"]
run(["rolling_disk_maze", *options, "--out", "maze"])
for name in sys.argv[1:]:
    run(["table.toml", "--planner", name, *options, "--out", name])
"""


@pytest.fixture(scope="module")
def two_processes(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The maze, and all planners on the table, by two processes that hash differently."""
    homes = []
    for hashing in ("1", "2"):
        home = tmp_path_factory.mktemp("process")
        (home / "table.toml").write_text(OPEN)
        subprocess.run(
            [sys.executable, "-c", ALL_BY_THE_COMMAND_LINE, *planners.names()],
            cwd=home,
            env=environment(PYTHONHASHSEED=hashing),
            capture_output=True,
            timeout=300,
            check=True,
        )
        homes.append(home)
    return homes[0], homes[1]


def test_two_processes_give_the_same_bits(two_processes: tuple[Path, Path]) -> None:
    one, other = ((home / "maze" / "trajectory.csv").read_bytes() for home in two_processes)
    assert one == other
    assert one.count(b"\n") > 10


@every_planner
def test_two_processes_write_the_same_file(name: str, two_processes: tuple[Path, Path]) -> None:
    one, other = ((home / name / "trajectory.csv").read_bytes() for home in two_processes)
    assert one == other
    assert one.count(b"\n") > 2


@every_planner
@pytest.mark.parametrize("most", [1, 20])
def test_a_search_ends_at_its_iterations(name: str, most: int, endless: PlanningTask) -> None:
    most = at_most(name, most)
    found = endless.solve(planner=name, seed=1, max_iterations=most, time_limit=SLOWEST)
    assert found.status in {"approximate", "not_found"}
    assert found.iterations == most


@every_planner
def test_a_search_ends_at_its_time(name: str, hard: PlanningTask) -> None:
    found = hard.solve(planner=name, seed=1, time_limit=0.1)
    assert found.status in {"approximate", "not_found"}
    assert found.timings["search"] < 20.0  # [s]; what is done is counted in test_time_limits


@every_planner
def test_the_iterations_of_a_timed_run_repeat_it(name: str, endless: PlanningTask) -> None:
    limit = 0.1  # [s]
    timed = endless.solve(planner=name, seed=2, time_limit=limit)
    while not timed.iterations:  # on a busy machine some have not begun by then
        limit *= 3
        timed = endless.solve(planner=name, seed=2, time_limit=limit)
    again = endless.solve(planner=name, seed=2, time_limit=60, max_iterations=timed.iterations)
    assert again.iterations == timed.iterations
    assert bits(again) == bits(timed)


# An optimisation that fails leaves no approach.
@pytest.mark.parametrize("name", [name for name in planners.names() if name not in OF_GUESSES])
def test_an_approximate_plan_ends_nearer_to_the_goal_than_it_starts(
    name: str, hard: PlanningTask
) -> None:
    """What does not come nearer is not found; Outcome says so."""
    for seed in range(1, 6):
        found = hard.solve(planner=name, seed=seed, max_iterations=1)
        if found.status == "approximate":
            assert found.goal_distance < hard.goal_distance(hard.start)


@every_planner
def test_nothing_found_is_a_result(name: str, still: PlanningTask) -> None:
    most = at_most(name, 100)
    found = still.solve(planner=name, max_iterations=most)
    assert (found.status, found.exit_code) == ("not_found", 3)
    assert found.trajectory is None
    assert found.certificate is None
    assert found.cost is None
    assert found.goal_distance == 1.0  # [m]


@every_planner
def test_a_start_in_the_goal_is_solved(name: str, tmp_path: Path) -> None:
    found = problem_of(tmp_path, OPEN, "start.x=0").solve(planner=name, seed=1)
    assert found.status == "solved"


@every_planner
def test_the_inputs_are_held_for_whole_steps_within_their_limits(name: str, short: Solved) -> None:
    motion = short.problem.solve(planner=name, seed=1, max_iterations=20_000).trajectory
    assert motion is not None
    assert motion.t == pytest.approx(0.05 * np.arange(len(motion.t)), abs=1e-12)
    assert (np.abs(motion.u) <= [1.0, 0.5]).all()


@every_planner
def test_an_interrupted_search_ends_and_keeps_what_it_has(name: str, endless: PlanningTask) -> None:
    budgets: list[Budget] = []
    # Milestones by which a roadmap leads somewhere, or motions of which one comes nearer.
    least = 1 if name in OF_GUESSES else 100

    def stop(iterations: int, _: float) -> None:
        assert iterations > 0
        budgets[0].interrupted = iterations >= least

    watched = {"progress": stop, "watch": budgets.append}
    found = endless.solve(planner=name, seed=1, time_limit=300.0, **watched)
    assert (found.status, found.exit_code) == ("interrupted", 130)
    assert found.timings["search"] < 200.0  # [s] of 300, also where code is still compiled
    if name == "potential_field":  # knows no way into the pen, so that it has nothing to keep
        return
    if name in {*OF_GUESSES, "flat_connect"}:  # nothing to keep before a motion is there
        return
    assert found.trajectory is not None


def test_a_planner_and_a_setting_that_do_not_exist_are_refused(table: PlanningTask) -> None:
    with pytest.raises(InputError, match="Did you mean 'rrt'"):
        table.solve(planner="rtt")
    with pytest.raises(InputError, match="Did you mean 'goal_bias'"):
        table.solve(planner="rrt", goal_bia=0.1)
    with pytest.raises(InputError, match="goal_bias"):
        table.solve(planner="rrt", goal_bias="often")


def test_whole_numbers_are_taken_for_numbers() -> None:
    """Loops are compiled for the types of settings, and would be compiled anew for integers."""
    sparse = planners.get("sst").from_settings({"goal_bias": 0, "pruning_radius": 2, "threads": 2})
    assert [type(sparse.goal_bias), type(sparse.pruning_radius)] == [float, float]  # type: ignore[attr-defined]
    assert type(sparse.threads) is int  # type: ignore[attr-defined]


def test_settings_given_here_win_over_the_scenarios(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "planner.max_steps=1", "planner.goal_bias=0.3")
    same = problem.solve(seed=1, max_iterations=5000)
    assert bits(problem.solve(seed=1, max_iterations=5000, max_steps=1)) == bits(same)
    assert bits(problem.solve(seed=1, max_iterations=5000, max_steps=20)) != bits(same)


def test_a_step_of_any_length_ends_in_time(tmp_path: Path) -> None:
    for step in ("1e-300", "1e-9"):
        with pytest.raises(InputError, match="too short a step"):
            problem_of(tmp_path, OPEN, f"integration.step={step}")
    for step in ("1e-6", "1000.0", "1e300"):
        problem = problem_of(tmp_path, OPEN, f"integration.step={step}")
        found = problem.solve(seed=1, time_limit=0.1)
        assert found.timings["search"] < 20.0  # [s]; test_time_limits counts what is done


@pytest.mark.parametrize("name", ["rrt", "rrt_fast", "kpiece_fast"])
@pytest.mark.parametrize("substeps", [1, 4])
def test_a_discrete_problem_is_judged_on_its_own_map(
    name: str, substeps: int, tmp_path: Path
) -> None:
    """Its knots are substeps of x + h f(x, u), to 1e-9."""
    own = ('integration.truth="discrete"', 'integration.method="euler"')
    problem = problem_of(tmp_path, OPEN, *own, f"integration.substeps={substeps}")
    found = problem.solve(planner=name, seed=1, max_iterations=20_000)
    assert found.status == "solved"
    motion = found.trajectory
    assert motion is not None
    x, h = motion.x[:-1], np.diff(motion.t)[:, None] / substeps
    for _ in range(substeps):
        x = x + h * problem.model.f(x, motion.u)
    assert np.abs(motion.x[1:] - x).max() < 1e-9


@every_planner
@pytest.mark.parametrize(("norm", "order"), [("euclidean", 2), ("sum", 1)])
def test_a_goal_that_is_a_ball_is_reached(name: str, norm: str, order: int, tmp_path: Path) -> None:
    ball = (f"goal.norm='{norm}'", "goal.x=1.0", "goal.y=0.5", "goal.tolerance=0.2")
    found = problem_of(tmp_path, OPEN, *ball).solve(planner=name, seed=1, max_iterations=20_000)
    assert found.status == "solved"
    assert found.trajectory is not None
    x, y = found.trajectory.x[-1, :2]
    assert np.linalg.norm([x - 1.0, y - 0.5], order) <= 0.2


# --- restarts ---


def test_a_search_begins_anew_in_ever_longer_rounds(hard: PlanningTask) -> None:
    """Rounds of 200, 300 and 450 iterations are over after 950, the next after 1625."""
    first, second = (
        hard.solve(planner="rrt", seed=1, max_iterations=1000, restart_after=200) for _ in range(2)
    )
    assert first.statistics["restarts"] == 3.0
    assert first.iterations == 1000
    assert bits(first) == bits(second)


@pytest.mark.parametrize("most", [1, 99, 100, 101, 250, 251, 475, 476])
def test_a_search_in_rounds_ends_at_its_iterations(most: int, hard: PlanningTask) -> None:
    """Rounds of 100, 150 and 225 end at 100, 250 and 475; the search may end together with one."""
    found = hard.solve(planner="rrt", seed=1, max_iterations=most, restart_after=100)
    assert found.iterations == most
    ended, begun = (sum(end < last for end in (100, 250, 475)) for last in (most, most + 1))
    assert ended <= found.statistics["restarts"] <= begun


def test_no_search_begins_anew_where_that_is_turned_off(hard: PlanningTask) -> None:
    found = hard.solve(planner="rrt", seed=1, max_iterations=1000, restart_after=0)
    assert (found.iterations, found.statistics["restarts"]) == (1000, 0.0)


def test_rounds_of_one_iteration_end(hard: PlanningTask) -> None:
    """Rounds of 1, 1.5, 2.25, … whole iterations sum up to 100 after ten of them or so."""
    found = hard.solve(planner="rrt", seed=1, max_iterations=100, restart_after=1)
    assert found.iterations == 100
    assert 5 <= found.statistics["restarts"] <= 15


def test_the_first_round_is_a_search_without_rounds(hard: PlanningTask) -> None:
    plain, first = (
        hard.solve(planner="rrt", seed=4, max_iterations=400, restart_after=after)
        for after in (0, 500)
    )
    assert bits(plain) == bits(first)


def followed(problem: PlanningTask, found: PlanResult) -> float:
    """The excess over the goal where the planner's own integrator ends."""
    assert found.trajectory is not None
    x = problem.start
    for u in found.trajectory.u:
        x = problem.model.step(x, u, problem.step)
    return problem.goal_excess(x)


@pytest.mark.parametrize("seed", range(1, 5))
def test_the_nearest_approach_of_all_rounds_is_kept(seed: int, hard: PlanningTask) -> None:
    """Near is what the planner's integrator finds near; angles are wrapped, so that bits differ."""
    first, later = (
        hard.solve(planner="rrt", seed=seed, max_iterations=most, restart_after=200)
        for most in (200, 1000)
    )
    assert later.statistics["restarts"] >= 2
    assert followed(hard, later) <= followed(hard, first) * (1 + 1e-12)


def test_a_search_that_is_interrupted_in_a_later_round_keeps_what_it_has(
    hard: PlanningTask,
) -> None:
    budgets: list[Budget] = []

    def stop(iterations: int, _: float) -> None:
        budgets[0].interrupted = iterations > 200

    settings = {"progress": stop, "watch": budgets.append, "restart_after": 50}
    found = hard.solve(planner="rrt", seed=1, time_limit=30.0, **settings)
    assert found.status == "interrupted"
    assert found.statistics["restarts"] > 0
    assert found.trajectory is not None
    assert found.timings["search"] < 200.0  # [s] of 300, also where code is still compiled


@pytest.mark.parametrize(
    ("setting", "value", "told"),
    [
        (
            "goal_region_scale",
            0.999,
            "0.999 is out of range. Give at least 1.0, at most 1000000.0.",
        ),
        ("goal_region_scale", -1, "-1 is out of range. Give at least 1.0, at most 1000000.0."),
        (
            "goal_region_scale",
            2e6,
            "2000000.0 is out of range. Give at least 1.0, at most 1000000.0.",
        ),
        ("goal_region_scale", "far", "'far' does not fit. Give a number, such as the default 1.0."),
        ("restart_after", -1, "-1 is out of range. Give at least 0."),
        (
            "restart_after",
            1.5,
            "1.5 does not fit. Give a whole number, such as the default 20000.",
        ),
    ],
)
def test_a_setting_out_of_its_range_is_told_with_what_would_work(
    setting: str, value: object, told: str, table: PlanningTask
) -> None:
    with pytest.raises(InputError) as caught:
        table.solve(planner="rrt", **{setting: value})
    assert str(caught.value) == f"[planner] {setting}: {told}"


def test_a_goal_region_scale_widens_what_the_search_aims_at(hard: PlanningTask) -> None:
    plain, one, ten = (
        bits(hard.solve(planner="rrt", seed=1, max_iterations=300, goal_bias=0.5, **zoom))
        for zoom in ({}, {"goal_region_scale": 1.0}, {"goal_region_scale": 1e6})
    )
    assert plain == one
    assert plain != ten


def test_rounds_in_which_every_step_fails_end(tmp_path: Path) -> None:
    """A step that fails leaves the machine where it started, which stays a valid start."""
    problem = problem_of(tmp_path, OPEN, "integration.step=1e300")
    with within(100):
        found = problem.solve(planner="rrt", seed=1, max_iterations=100, restart_after=10)
    assert (found.status, found.iterations) == ("not_found", 100)
    assert found.statistics["restarts"] == 4.0  # 10 + 15 + 22.5 + 33.75 = 81.25


# --- what is true of the planner's integrator only ---


@pytest.fixture(scope="module")
def coarse(tmp_path_factory: pytest.TempPathFactory) -> list[PlanResult]:
    """Plans made with Euler's method in steps of half a second, off by some tenths of a metre."""
    overrides = ('integration.method="euler"', "integration.step=0.5", "goal.tolerance=0.3")
    problem = problem_of(tmp_path_factory.mktemp("coarse"), OPEN, *overrides)
    return [problem.solve(seed=seed, max_iterations=100) for seed in range(30)]


def test_a_goal_that_is_missed_in_truth_is_not_reached(coarse: list[PlanResult]) -> None:
    missed = [found for found in coarse if found.statistics["missed_the_goal_in_truth"] > 0]
    assert missed
    for found in missed:
        assert found.status == "solved" or found.iterations == 100  # the search went on
    for found in coarse:
        if found.status == "verification_failed":
            assert found.certificate is not None
            assert "goal" not in failed(found.certificate)


def test_an_approach_that_passes_every_check_is_a_solution(coarse: list[PlanResult]) -> None:
    for found in coarse:
        if found.certificate is not None and found.certificate.passed:
            assert found.status == "solved", f"seed {found.seed}"


# --- starts at the edge of what is possible ---


@every_planner
@pytest.mark.parametrize("gap", [2e-5, 4e-5])
def test_a_search_from_a_start_that_almost_touches_ends(
    name: str, gap: float, tmp_path: Path
) -> None:
    """The coin's rim is 0.25 m behind its centre, the wall 0.05 m behind its face."""
    at = -1.0 - 0.25 - gap - 0.05
    wall = f'\n[[world.obstacle]]\nname = "wall"\nbox = [0.1, 2, 1]\nposition = [{at}, 0, 0.5]\n'
    problem = problem_of(tmp_path, OPEN + wall)
    problem.check_endpoints()
    with within(100):
        problem.solve(planner=name, seed=1, time_limit=0.1, max_iterations=at_most(name, 50))


@every_planner
def test_a_search_from_a_start_that_is_outside_by_rounding_ends(name: str, tmp_path: Path) -> None:
    overrides = ("start.x=-5.0000000005", "goal.x=-4")
    problem = problem_of(tmp_path, OPEN, *overrides)
    problem.check_endpoints()
    with within(100):
        problem.solve(planner=name, seed=1, time_limit=0.1, max_iterations=at_most(name, 50))


def test_every_outcome_is_a_sentence() -> None:
    for outcome in Outcome:
        assert outcome.value.endswith(".")

"""Every planner: repeatable, within its budget, and a failure is a result."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinolab import planners
from kinolab.errors import InputError
from kinolab.planning import Plan
from kinolab.problem import Problem
from kinolab.search import Budget, Outcome
from tests.conftest import Solved
from tests.support import OPEN, plan, problem_of

every_planner = pytest.mark.parametrize("name", planners.names())


def bits(found: Plan) -> bytes:
    assert found.trajectory is not None
    motion = found.trajectory
    return b"".join(array.tobytes() for array in (motion.t, motion.x, motion.u))


@pytest.fixture(scope="module")
def hard(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    """The table with a goal that is not hit by chance."""
    folder = tmp_path_factory.mktemp("hard")
    return problem_of(folder, OPEN, "goal.x=4", "goal.tolerance=1e-6")


@every_planner
def test_every_planner_solves_the_table(name: str, table: Problem) -> None:
    found = table.solve(planner=name, seed=1, max_iterations=20_000)
    assert found.status == "solved"
    assert (found.planner, found.seed) == (name, 1)


@every_planner
def test_the_same_seed_gives_the_same_bits(name: str, table: Problem) -> None:
    first, second = (table.solve(planner=name, seed=7, max_iterations=5000) for _ in range(2))
    assert bits(first) == bits(second)
    assert first.iterations == second.iterations


@every_planner
def test_other_searches_in_between_do_not_matter(name: str, table: Problem) -> None:
    first = table.solve(planner=name, seed=7, max_iterations=5000)
    table.solve(planner=name, seed=8, max_iterations=100)
    np.random.default_rng(0).normal(size=10)
    assert bits(table.solve(planner=name, seed=7, max_iterations=5000)) == bits(first)


@every_planner
@pytest.mark.parametrize("seed", [0, 2**31, 2**32 - 1, 2**32, 2**63 - 1])
def test_every_seed_that_a_scenario_may_have_is_repeatable(
    name: str, seed: int, table: Problem
) -> None:
    first, second = (table.solve(planner=name, seed=seed, max_iterations=5000) for _ in range(2))
    assert bits(first) == bits(second)


@every_planner
def test_different_seeds_give_different_motions(name: str, table: Problem) -> None:
    seeds = (0, 1, 2, 3, 2**32 + 1, 2**33 + 1)
    found = {bits(table.solve(planner=name, seed=seed, max_iterations=5000)) for seed in seeds}
    assert len(found) == len(seeds)


def test_two_processes_give_the_same_bits(tmp_path: Path) -> None:
    for hashing in ("1", "2"):
        options = ("--seed", "3", "--max-iterations", "1000", "--no-animation", "--out", hashing)
        plan("rolling_disk_maze", *options, cwd=tmp_path, PYTHONHASHSEED=hashing)
    one, other = ((tmp_path / k / "trajectory.csv").read_bytes() for k in ("1", "2"))
    assert one == other
    assert one.count(b"\n") > 10


@every_planner
@pytest.mark.parametrize("most", [1, 20])
def test_a_search_ends_at_its_iterations(name: str, most: int, hard: Problem) -> None:
    found = hard.solve(planner=name, seed=1, max_iterations=most)
    assert found.status in {"approximate", "not_found"}
    assert found.iterations == most


@every_planner
def test_a_search_ends_at_its_time(name: str, hard: Problem) -> None:
    found = hard.solve(planner=name, seed=1, time_limit=0.5)
    assert found.status == "approximate"
    assert found.timings["search"] < 1.0  # [s]


@every_planner
def test_the_iterations_of_a_timed_run_repeat_it(name: str, hard: Problem) -> None:
    timed = hard.solve(planner=name, seed=2, time_limit=0.3)
    again = hard.solve(planner=name, seed=2, time_limit=60, max_iterations=timed.iterations)
    assert again.iterations == timed.iterations
    assert bits(again) == bits(timed)


@every_planner
def test_an_approximate_plan_ends_nearer_to_the_goal_than_it_starts(
    name: str, hard: Problem
) -> None:
    """What does not come nearer is not found; Outcome says so."""
    for seed in range(1, 11):
        found = hard.solve(planner=name, seed=seed, max_iterations=1)
        if found.status == "approximate":
            assert found.goal_distance < hard.goal_distance(hard.start)


@every_planner
def test_nothing_found_is_a_result(name: str, tmp_path: Path) -> None:
    """Rates may hardly differ from 0: every motion breaks a limit."""
    still = ("bounds.psi_dot=[-1e-9, 1e-9]", "bounds.phi_dot=[-1e-9, 1e-9]")
    found = problem_of(tmp_path, OPEN, *still).solve(planner=name, max_iterations=100)
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
def test_an_interrupted_search_ends_and_keeps_what_it_has(name: str, hard: Problem) -> None:
    budgets: list[Budget] = []

    def stop(iterations: int, seconds: float) -> None:
        assert iterations > 0
        assert seconds > 0
        budgets[0].interrupted = True

    found = hard.solve(planner=name, seed=1, time_limit=30.0, progress=stop, watch=budgets.append)
    assert (found.status, found.exit_code) == ("interrupted", 130)
    assert found.trajectory is not None
    assert found.timings["search"] < 2.0  # [s]; it reports four times a second


def test_a_planner_and_a_setting_that_do_not_exist_are_refused(table: Problem) -> None:
    with pytest.raises(InputError, match="Did you mean 'rrt'"):
        table.solve(planner="rtt")
    with pytest.raises(InputError, match="Did you mean 'goal_bias'"):
        table.solve(planner="rrt", goal_bia=0.1)
    with pytest.raises(InputError, match="goal_bias"):
        table.solve(planner="rrt", goal_bias="often")


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
        found = problem.solve(seed=1, time_limit=0.3)
        assert found.timings["search"] < 2.0  # [s]


def test_a_discrete_problem_is_judged_on_its_own_map_or_refused(tmp_path: Path) -> None:
    """Its knots are x + h f(x, u), to 1e-9."""
    overrides = ('integration.truth="discrete"', 'integration.method="euler"')
    try:
        problem = problem_of(tmp_path, OPEN, *overrides)
    except InputError as refused:
        assert "truth" in str(refused)  # noqa: PT017  # either answer is right
        return
    motion = problem.solve(seed=1, max_iterations=20_000).trajectory
    assert motion is not None
    h = np.diff(motion.t)[:, None]
    steps = motion.x[:-1] + h * problem.model.f(motion.x[:-1], motion.u)
    assert np.abs(motion.x[1:] - steps).max() < 1e-9


def test_every_outcome_is_a_sentence() -> None:
    for outcome in Outcome:
        assert outcome.value.endswith(".")


@every_planner
def test_every_planner_describes_itself(name: str) -> None:
    assert planners.summary(name).endswith(".")

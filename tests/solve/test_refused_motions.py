"""A motion that the verifier refuses does not end a search: another one follows, if there is time.

A planner in a file drives a coin straight into its goal, with more torque than the motor has or
with as much as it has, as its random numbers fall; it notes how it was asked.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from kinolab import cli
from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult
from tests.planners.test_planners import bits
from tests.support import OPEN, problem_of, within

Capture = pytest.CaptureFixture[str]

FICKLE = '''"""A planner that asks too much of the motor."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from kinolab.search import AbstractPlanner, Outcome, SearchResult, setting

LOG = Path(__file__).with_name("asked.jsonl")


@dataclass(frozen=True, kw_only=True)
class Fickle(AbstractPlanner):
    """Drive straight on until the goal is reached.

    Source: none; a test needs it.
    """

    name: ClassVar[str] = "fickle"

    bad: float = setting(0.7, 0.0, 1.0, meaning="How often a motion asks too much.")
    random: bool = setting(True, meaning="Whether anything is drawn at random.")
    once: bool = setting(False, meaning="Whether only the first step asks too much.")
    most: int = setting(1000, meaning="Searches until the user interrupts.")

    def solve(self, problem, seed, budget):
        draw = np.random.default_rng(seed if self.random else 0)
        bad = draw.uniform() < self.bad
        u = np.array([draw.uniform(1.5, 2.0) if bad else draw.uniform(0.5, 1.0), 0.0])
        x, rows = problem.start, []
        while problem.goal_excess(x) > 1.0 and not budget.spent():
            x, rows = problem.model.step(x, u, problem.step), [*rows, u]
            u = np.array([0.3, 0.0]) if self.once else u
        asked = LOG.read_text().splitlines() if LOG.exists() else []
        left = budget.max_iterations
        line = {"seed": seed, "bad": bool(bad), "left": left, "made": budget.iterations}
        with LOG.open("a") as log:  # two searches may write at once
            log.write(json.dumps(line) + "\\n")
        budget.interrupted = budget.interrupted or len(asked) + 1 >= self.most
        outcome = Outcome.SOLVED if problem.goal_excess(x) <= 1.0 else Outcome.APPROXIMATE
        t = problem.step * np.arange(len(rows) + 1)
        return SearchResult(outcome, t, np.reshape(rows, (-1, 2)), budget.iterations)
'''
PLANNER = 'planner.name="fickle.py:Fickle"'


def fickle(folder: Path, *overrides: str) -> PlanningTask:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "fickle.py").write_text(FICKLE)
    return problem_of(folder, OPEN, PLANNER, *overrides)


def asked(folder: Path) -> list[dict[str, float]]:
    return [json.loads(line) for line in (folder / "asked.jsonl").read_text().splitlines()]


@pytest.mark.parametrize("seed", range(1, 7))
def test_a_refused_motion_does_not_end_a_search(seed: int, tmp_path: Path) -> None:
    found = fickle(tmp_path).solve(seed=seed, time_limit=600.0, optimize=False)
    calls = asked(tmp_path)
    assert (found.status, found.seed) == ("solved", seed)
    assert [call["bad"] for call in calls] == [True] * (len(calls) - 1) + [False]
    assert len({call["seed"] for call in calls}) == len(calls)
    assert calls[0]["seed"] == seed
    assert found.refused == ({"inputs": len(calls) - 1} if len(calls) > 1 else {})
    assert found.iterations == sum(call["made"] for call in calls)
    assert [attempt.refused for attempt in found.attempts] == [len(calls) - 1]


def test_what_is_mended_has_been_refused_all_the_same(tmp_path: Path) -> None:
    """The first step asks too much; the optimiser makes one of it that the motor can do."""
    found = fickle(tmp_path, "planner.improve=10").solve(
        seed=1, bad=1.0, once=True, max_iterations=1000, time_limit=600.0
    )
    assert found.status == "solved"
    assert found.refused == {"inputs": 1}
    assert [call["seed"] for call in asked(tmp_path)].count(1) == 1  # others came to improve it


def test_equal_seeds_give_the_same_bits_where_motions_are_refused(tmp_path: Path) -> None:
    def made(name: str) -> PlanResult:
        return fickle(tmp_path / name).solve(seed=5, bad=0.9, max_iterations=5000, optimize=False)

    one, other = made("one"), made("other")
    assert bits(one) == bits(other)
    assert (one.iterations, one.refused) == (other.iterations, other.refused)
    assert asked(tmp_path / "one") == asked(tmp_path / "other")
    assert one.refused["inputs"] > 0


def test_all_searches_together_make_no_more_iterations_than_they_may(tmp_path: Path) -> None:
    found = fickle(tmp_path).solve(seed=1, bad=1.0, max_iterations=50, optimize=False)
    calls = asked(tmp_path)
    assert (found.status, found.exit_code, found.iterations) == ("verification_failed", 7, 50)
    left = 50.0
    for call in calls:
        assert call["left"] == left
        left -= call["made"]
    assert left == 0
    assert found.refused["inputs"] in {len(calls), len(calls) - 1}  # the last one is cut short
    assert found.certificate is not None
    assert not found.certificate.passed


def test_a_planner_that_draws_nothing_is_asked_no_third_time(tmp_path: Path) -> None:
    with within(100):
        found = fickle(tmp_path).solve(
            seed=1, bad=1.0, random=False, time_limit=1e6, optimize=False
        )
    assert found.status == "verification_failed"
    assert found.refused == {"inputs": 2}
    assert len(asked(tmp_path)) == 2


def test_a_search_that_is_always_refused_ends_at_its_time_limit(tmp_path: Path) -> None:
    with within(100):
        found = fickle(tmp_path).solve(seed=1, bad=1.0, time_limit=0.3, optimize=False)
    assert found.status == "verification_failed"
    assert found.refused.keys() == {"inputs"}
    searches = len(asked(tmp_path))  # the time may be over before the last one has found anything
    assert searches - 1 <= found.refused["inputs"] <= searches


def test_the_user_ends_searches_that_follow_each_other(tmp_path: Path) -> None:
    with within(100):
        found = fickle(tmp_path).solve(seed=1, bad=1.0, most=3, time_limit=1e6, optimize=False)
    assert len(asked(tmp_path)) == 3
    assert (found.status, found.exit_code) == ("verification_failed", 130)


def test_several_jobs_go_on_as_well(tmp_path: Path) -> None:
    found = fickle(tmp_path).solve(seed=1, jobs=2, bad=0.9, time_limit=60.0, optimize=False)
    assert found.status == "solved"
    calls = asked(tmp_path)
    assert any(call["bad"] for call in calls)
    assert sum(found.refused.values()) <= sum(call["bad"] for call in calls)


def test_refusals_are_printed_and_on_file(tmp_path: Path, capsys: Capture) -> None:
    fickle(tmp_path)
    out = tmp_path / "run"
    options = ["--set", PLANNER, "--set", "planner.bad=1.0", "--max-iterations", "30"]
    options += ["--no-optimize", "--no-diagnosis", "--no-animation", "--quiet", "--out", str(out)]
    assert cli.run([str(tmp_path / "table.toml"), *options]) == 7
    report = json.loads((out / "report.json").read_text())
    count = report["refused"]["inputs"]
    assert report["refused"] == {"inputs": count}
    assert report["attempts"][0]["refused"] == count
    motions = "motion" if count == 1 else "motions"
    assert f"\n  {count} {motions} refused by verification (inputs: {count})\n" in (
        capsys.readouterr().out
    )

"""Trees beside those of a search: when they grow, and that it does not matter where."""

from __future__ import annotations

from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.numerics.work import counted_work
from kinolab.planners.auto import Auto
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.search.tree import search_state
from kinolab.search.tree.growth_work import ITERATION_SECONDS, step_seconds
from kinolab.search.tree.threads import OtherTrees, other_trees
from kinolab.search.tree.tree import FULL, GROWING, REACHED, insert_node, tree
from kinolab.search.tree.tree_extension import AbstractTreeExtension
from tests.support import OPEN, problem_of


class Inline:
    """A pool that does all at once, as if there were no other processor."""

    def __init__(self, *_: Any) -> None:
        pass

    def submit(self, work: Any, *arguments: Any) -> Future[Any]:
        done: Future[Any] = Future()
        done.set_result(work(*arguments))
        return done

    def shutdown(self) -> None:
        pass


class Threadless(Inline):
    """A pool in a system that has no thread left."""

    def submit(self, *_: Any) -> Future[Any]:
        raise RuntimeError("can't start new thread")


class Late(Inline):
    """A pool whose first thread cannot be had, and which does that work, too, once it has one."""

    def __init__(self, *_: Any) -> None:
        self.waiting = list[Any]()
        self.refused = False

    def submit(self, work: Any, *arguments: Any) -> Future[Any]:
        if not self.refused:
            self.refused = True
            self.waiting.append((work, arguments))
            raise RuntimeError("can't start new thread")
        for late, given in self.waiting:
            late(*given)
        self.waiting.clear()
        return super().submit(work, *arguments)


class Scripted(AbstractTreeExtension):
    """A tree whose growth ends as it was told, one iteration being one step."""

    def __init__(self, problem: PlanningTask, ends: list[int]) -> None:
        self.nodes, self.best = tree(search_state(problem, 1.0, 1).problem, 64), np.zeros(2)
        self.ends, self.begun, self.grown = ends, 0, list[int]()
        self.closed = False

    def begin(self) -> None:
        self.begun += 1
        insert_node(self.nodes, np.zeros(6), np.zeros(2), np.int64(-1), np.int64(0), 0.0)
        insert_node(self.nodes, np.ones(6), np.array([1.0, 2.0]), np.int64(0), np.int64(3), 0.0)

    def grow(self, iterations: int) -> tuple[int, int]:
        self.grown.append(iterations)
        self.nodes.rejections[3] += iterations
        return self.ends.pop(0) if self.ends else GROWING, iterations

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def table(tmp_path: Path) -> PlanningTask:
    return problem_of(tmp_path, OPEN)


def turns(others: OtherTrees, own: Scripted, count: int) -> list[Any]:
    """Advance a search, one iteration after the other, and return what is found."""
    found = []
    for _ in range(count):
        own.nodes.rejections[3] += 1
        found.append(others.advance(1, own))
    return found


def test_they_begin_when_a_search_has_worked_for_a_while(table: PlanningTask) -> None:
    own, made = Scripted(table, []), list[Scripted]()

    def make() -> Scripted:
        made.append(Scripted(table, []))
        return made[-1]

    others = OtherTrees(table, make, 0)
    each = step_seconds(table) + ITERATION_SECONDS
    early = int(0.9 * other_trees.WORK_BEFORE / each)
    turns(others, own, early)
    assert not made
    with counted_work() as clock:
        turns(others, own, 2 * early)
        others.close()
    (trees,) = made
    assert trees.begun == 1
    assert trees.closed
    # The turn before the last was paid for, and both have done about as much since they began.
    assert clock.seconds == pytest.approx(sum(trees.grown[:-1]) * each)
    assert sum(trees.grown) * each == pytest.approx(
        3 * early * each - other_trees.WORK_BEFORE, abs=3 * other_trees.WORK_PER_TURN
    )


def test_they_restart_in_longer_rounds_and_tell_what_they_find(
    table: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(other_trees, "WORK_BEFORE", 0.0)
    monkeypatch.setattr(other_trees, "WORK_PER_TURN", 1e-4)
    trees = Scripted(table, [GROWING, FULL, GROWING, REACHED])
    others, own = OtherTrees(table, lambda: trees, 100), Scripted(table, [])
    found = [u for u in turns(others, own, 400) if u is not None]
    (inputs,) = found
    np.testing.assert_array_equal(inputs, [[1.0, 2.0]] * 3)  # to the node that was added last
    others.close()
    restarts = trees.begun - 1
    assert restarts >= 2  # for a full tree, and when a round was over


def test_processors_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(other_trees, "WORK_BEFORE", 0.0)
    monkeypatch.setattr(other_trees, "WORK_PER_TURN", 1e-3)
    biped, results, made = kinolab.load("biped_walk"), [], list[OtherTrees]()
    begin = OtherTrees.__init__

    def noted(self: OtherTrees, *arguments: Any) -> None:
        begin(self, *arguments)
        made.append(self)

    monkeypatch.setattr(OtherTrees, "__init__", noted)
    for pool in (other_trees.ThreadPoolExecutor, Inline, Threadless, Late):
        monkeypatch.setattr(other_trees, "ThreadPoolExecutor", pool)
        found = biped.solve(planner="auto", seed=3, max_iterations=3000, optimize=False)
        assert found.trajectory is not None
        assert made[-1]._own > 1000  # iterations
        results.append((found.status, made[-1]._own, found.trajectory.u.tobytes()))
    assert all(result == results[0] for result in results)


def test_where_guesses_are_made_there_are_none(table: PlanningTask) -> None:
    beside = Auto().beside(table, 1, Budget(1.0))
    assert not any(isinstance(one, OtherTrees) for one in beside)
    biped = kinolab.load("biped_walk")
    (others,) = Auto().beside(biped, 1, Budget(1.0))
    others.close()
    assert not Auto().beside(biped, 1, Budget(1.0, below=3.0))  # known to take 3 s

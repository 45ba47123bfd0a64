"""Loops over rows: what they give does not depend on the number of processors."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import kinolab
from kinolab.concurrency import rows
from kinolab.concurrency.rows import in_parts
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.numerics.arrays import Array
from kinolab.show.film.crew import Crew, Share
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.trajopt.nlp.collision_constraints import CollisionConstraints
from kinolab.trajopt.nlp.path_constraints import Samples


@pytest.mark.parametrize("count", [1, 2, 3, 64])
@pytest.mark.parametrize("total", [0, 1, 7, 100])
def test_every_row_is_worked_on_once_and_in_order(
    count: int, total: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rows, "processors", lambda: count)
    threads: set[int] = set()

    def work(part: slice) -> list[int]:
        threads.add(threading.get_ident())
        return list(range(total))[part]

    parts = in_parts(work, total, total * rows.WORTH / 5.0)
    assert [row for part in parts for row in part] == list(range(total))
    assert len(parts) == max(1, min(count, total // 5, rows.MOST))
    assert threading.get_ident() in threads


def test_where_no_thread_can_be_had_all_is_done_in_this_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refused(*_: object) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(rows, "processors", lambda: 4)
    monkeypatch.setattr(rows, "_threads", lambda: ThreadPoolExecutor(4))
    monkeypatch.setattr(threading.Thread, "start", refused)
    parts = in_parts(lambda part: list(range(100))[part], 100, 1.0)
    assert [row for part in parts for row in part] == list(range(100))
    crew = Crew(lambda: Share(4))
    assert list(crew.in_order(str, range(10))) == [str(k) for k in range(10)]


def test_a_part_that_fails_is_no_result(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "processors", lambda: 2)

    def work(part: slice) -> None:
        if part.start:
            raise ArithmeticError("second half")

    with pytest.raises(ArithmeticError, match="second half"):
        in_parts(work, 10, 1.0)


def test_derivatives_and_distances_are_the_same_with_many_processors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem = kinolab.load("motorcycle_chicane")
    generator = np.random.default_rng(1)
    x = problem.start + 0.3 * generator.normal(size=(300, problem.model.nx))
    u = generator.uniform(*problem.model.control_bounds.T, size=(300, problem.model.nu))
    steps = StepSensitivities(problem.model, METHODS["rk4"], 2, 1)
    near = CollisionConstraints(problem, 0.05)
    samples = Samples(np.arange(300), np.zeros(300), x, u)

    def results(count: int) -> list[Array]:
        monkeypatch.setattr(rows, "processors", lambda: count)
        found = near.rows(samples, 1.0)
        return [*steps.linearized(x, u, 0.02), found.value, found.dx, found.knot]

    alone, together = results(1), results(7)
    assert len(alone[2]) > 100  # distances
    for one, other in zip(alone, together, strict=True):
        assert one.tobytes() == other.tobytes()

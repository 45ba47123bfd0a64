"""One false plan of each kind of the study in ``benchmarks/mutations.py``, and good ones.

What is false is decided by the study's judge, which shares nothing with the verifier.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import mpmath
import numpy as np
import pytest
import sympy

import kinolab
from benchmarks.mutation_study import faults, files, good, machines, nested, worlds
from benchmarks.mutation_study.attacks import answer
from benchmarks.mutation_study.faults import Case
from benchmarks.mutation_study.judge import Judge
from benchmarks.mutation_study.machines import ANYWHERE, EMPTY
from benchmarks.mutation_study.records import ACCEPTED, REFUSED
from benchmarks.mutation_study.solids import Bodies
from benchmarks.mutation_study.worlds import like
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from tests.conftest import Finished, Solved
from tests.support import OPEN, WALL, problem_of

ROWS, TRIES = 8, 6


def case_of(problem: PlanningTask, motion: Trajectory) -> Case:
    return Case("a/b", problem, motion, Judge(problem), Bodies(problem), Path())


def driven(scenario: str, held: Callable[[int], list[float]]) -> Case:
    """A few rows of a machine under given inputs, or references, by the judge's integrator."""
    problem = like(kinolab.load(scenario), goal=ANYWHERE, world=EMPTY)
    judge, law = Judge(problem), Judge(problem).law
    states, inputs, references = [np.array(problem.start)], [], []
    for k in range(ROWS):
        given = np.array(held(k))
        u = given if law is None else law(states[-1], given)
        inputs.append(u)
        references.append(given if law is not None else given[:0])
        states.append(judge.after(states[-1], u, problem.step))
    model = problem.model
    names = () if law is None else model.control_names
    t = problem.step * np.arange(ROWS + 1)
    motion = Trajectory(
        t, np.array(states), np.array(inputs), model.plant.state_names, model.plant.control_names,
        np.array(references).reshape(ROWS, -1), names,
    )  # fmt: skip
    return case_of(problem, motion)


@pytest.fixture(scope="module")
def coin(short: Solved, tmp_path_factory: pytest.TempPathFactory) -> Case:
    """The coin's short plan on a table with a wall that it does not come near."""
    walled = problem_of(tmp_path_factory.mktemp("walled"), OPEN + WALL)
    return case_of(walled, short.trajectory)


@pytest.fixture(scope="module")
def leaning() -> Case:
    """A coin that its controller holds upright, through a turn."""
    return driven("falling_disk_slalom", lambda k: [2.0, 0.1 * k])


@pytest.fixture(scope="module")
def telescope() -> Case:
    """A satellite that three wheels turn."""
    return driven("satellite_pointing", lambda k: [0.05, -0.03, 0.02 * (-1) ** k])


def judged(case: Case, kind: faults.Kind, seed: int) -> str | None:
    """Make a fault; return the judge's verdict once the verifier has agreed."""
    fault = kind(case, np.random.default_rng(seed))
    if fault is None:
        return None
    said, checks, _ = answer(fault.problem, fault.motion)
    expected = {"false": REFUSED, "true": ACCEPTED}.get(fault.verdict.truth, said)
    assert said == expected, f"{fault.what}, {fault.verdict}: {said} {checks}"
    return fault.verdict.truth


OF_COINS = {
    **{
        kind: faults.KINDS[kind] for kind in faults.KINDS if kind not in ("reference", "quaternion")
    },
    **worlds.KINDS,
    "parameter": machines.parameter,
    "limit passed": machines.limit,
    "requirement of nested terms": nested.broken,
}


@pytest.mark.parametrize("kind", OF_COINS)
def test_a_false_plan_of_the_coin_is_refused(coin: Case, kind: str) -> None:
    assert "false" in {judged(coin, OF_COINS[kind], seed) for seed in range(TRIES)}


@pytest.mark.parametrize("seed", range(4))
def test_requirements_of_nested_terms_are_what_their_closed_forms_say(seed: int) -> None:
    """By 50 digits, at the place and at all distances from it: the judge knows how it was made."""
    s = sympy.Symbol("s", real=True)
    window = nested.window_at(np.random.default_rng(seed), s, nested.DEEPEST)
    assert window.subs(s, 0) == pytest.approx(1.0, abs=1e-15)
    values = sympy.lambdify(s, window, "mpmath")
    with mpmath.workdps(50):
        beside = [values(mpmath.mpf(sign * 10.0**k)) for k in range(-12, 2) for sign in (-1, 1)]
    assert all(0 <= value <= 1 + 1e-15 for value in beside)
    assert min(beside) < 0.9


@pytest.mark.parametrize("kind", [faults.reference, faults.input_, machines.gain])
def test_a_plan_that_its_law_does_not_give_is_refused(leaning: Case, kind: faults.Kind) -> None:
    assert "false" in (judged(leaning, kind, seed) for seed in range(TRIES))


def test_a_quaternion_that_is_changed_is_refused(telescope: Case) -> None:
    assert {judged(telescope, faults.quaternion, seed) for seed in range(TRIES)} == {"false"}


@pytest.mark.parametrize(
    "kind",
    ["whole turns", "piece", "rows between", "made by the judge", "requirement of nested terms"],
)
def test_good_plans_pass_however_they_are_written(
    coin: Case, telescope: Case, leaning: Case, kind: str
) -> None:
    said = {judged(one, good.KINDS[kind], 1) for one in (coin, telescope, leaning)}
    assert "true" in said <= {"true", None}


def test_signs_of_quaternions_make_no_difference(telescope: Case) -> None:
    assert judged(telescope, good.signs, 1) == "true"


def test_a_certified_file_that_was_edited_is_refused(table_run: Finished) -> None:
    generator, seen = np.random.default_rng(1), set()
    for _ in range(12):
        found = files.edited(table_run.folder, table_run.folder, generator)
        if found is not None:
            _, name, verdict, (said, _, _) = found
            assert verdict.truth != "false" or said == REFUSED, f"{name}: {verdict.why}"
            seen.add(verdict.truth)
    assert "false" in seen

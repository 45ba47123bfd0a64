"""Plans that many tests look at, made once."""

from __future__ import annotations

import json
import os
import pickle
import shutil
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Protocol, TypeVar

import pytest

# As the command line has it: with a thread per processor in each of several processes, they wait
# for each other most of the time. Who loads BLAS first reads it, so it comes before NumPy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import kinolab
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.files import FileLock
from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory
from tests.selection import (  # noqa: F401  # hooks of pytest
    pytest_addoption,
    pytest_collection_modifyitems,
    pytest_configure,
    pytest_fixture_setup,
    pytest_runtest_setup,
)
from tests.show.view.browsing import CHROMIUM, FLAGS
from tests.support import OPEN, plan, problem_of

Made = TypeVar("Made")

SLOWEST = 600.0  # [s]: the same search on the slowest machine; it ends by its seed, not by time


@dataclass(frozen=True)
class Solved:
    """A problem, its plan and the plan's trajectory."""

    problem: PlanningTask
    plan: PlanResult
    trajectory: Trajectory


@dataclass(frozen=True)
class Finished:
    """A run of the command line and the folder it wrote."""

    folder: Path
    report: dict[str, Any]
    stdout: str
    stderr: str
    code: int


class Solver(Protocol):
    """Solves a built-in scenario, each only once."""

    def __call__(self, name: str) -> Solved: ...


@pytest.fixture(autouse=True)
def _methods_of_one_test() -> Iterator[None]:
    """Methods of integration that a test adds, or that a scenario it reads brings, end with it.

    Machines that are made later would have them, and so would their pages.
    """
    before = dict(METHODS)
    yield
    for name in METHODS.keys() - before:
        del METHODS[name]


@pytest.fixture(scope="session", autouse=True)
def _signals_are_heard() -> Iterator[None]:
    """Whoever started the tests may ignore them, as nohup and a shell in the background do.

    What ignores one hands that on to every process that it starts.
    """
    heard = {signal.SIGINT: signal.default_int_handler, signal.SIGHUP: signal.SIG_DFL}
    before = {number: signal.signal(number, heard[number]) for number in heard}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture(scope="session")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Solver:
    home = _shared(tmp_path_factory, "solved")

    @cache
    def solve(name: str) -> Solved:
        problem = kinolab.load(name, overrides=["planner.improve=0"])

        def search() -> PlanResult:
            return problem.solve(time_limit=SLOWEST, optimize=False)

        return _solved(problem, _once(home / name, search))

    return solve


@pytest.fixture(scope="session")
def table(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    """A coin in the open, a few iterations from its goal."""
    return problem_of(tmp_path_factory.mktemp("table"), OPEN)


@pytest.fixture(scope="session")
def short(table: PlanningTask) -> Solved:
    """The table's plan: about a second of motion."""
    return _solved(table, table.solve(seed=1, max_iterations=20_000))


@pytest.fixture(scope="session")
def maze_run(tmp_path_factory: pytest.TempPathFactory) -> Finished:
    """The maze, planned and drawn by the command line in a process of its own."""
    return _finished(
        _shared(tmp_path_factory, "maze"), "rolling_disk_maze", "--json", "--no-optimize"
    )


@pytest.fixture(scope="session")
def table_run(tmp_path_factory: pytest.TempPathFactory) -> Finished:
    """The table with a mesh on it, planned by the command line without a picture."""
    return finished_table(_shared(tmp_path_factory, "table_run"))


@pytest.fixture
def run_copy(table_run: Finished, tmp_path: Path) -> Path:
    """A finished run that a test may damage."""
    return Path(shutil.copytree(table_run.folder, tmp_path / "copy"))


def finished_table(home: Path) -> Finished:
    """Plan for the table in a folder that is there."""
    (home / "meshes").mkdir(exist_ok=True)
    (home / "meshes" / "post.off").write_text(POST)
    post = '\n[[world.obstacle]]\nmesh = "meshes/post.off"\nposition = [3.0, 3.0, 0.0]\n'
    (home / "table.toml").write_text(OPEN + post)
    return _finished(home, "table.toml", "--no-animation", "--json")


def _solved(problem: PlanningTask, found: PlanResult) -> Solved:
    assert found.trajectory is not None, found.message
    return Solved(problem, found, found.trajectory)


def _shared(factory: pytest.TempPathFactory, name: str) -> Path:
    """Return a folder that all processes of pytest-xdist share."""
    own = factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / name
    folder.mkdir(exist_ok=True)
    return folder


def _finished(home: Path, *arguments: str) -> Finished:
    """Return the run of a command."""

    def run() -> tuple[str, str, int]:
        done = plan(*arguments, cwd=home)
        return done.stdout, done.stderr, done.returncode

    out, err, code = _once(home / "finished", run)
    folders = list((home / "runs").glob("*"))
    assert len(folders) == 1, err
    report = json.loads((folders[0] / "report.json").read_text(encoding="utf-8"))
    return Finished(folders[0], report, out, err, code)


def _once(kept: Path, make: Callable[[], Made]) -> Made:
    """Return what the first process that asks for it makes, and keeps in a file for the others."""
    lock = FileLock(kept.with_suffix(".lock"))
    lock.acquire()
    try:
        if not kept.exists():
            kept.write_bytes(pickle.dumps(make()))
    finally:
        lock.release()
    made: Made = pickle.loads(kept.read_bytes())
    return made


POST = """\
OFF
8 12 0
0 0 0
1 0 0
1 1 0
0 1 0
0 0 1
1 0 1
1 1 1
0 1 1
3 0 2 1
3 0 3 2
3 4 5 6
3 4 6 7
3 0 1 5
3 0 5 4
3 1 2 6
3 1 6 5
3 2 3 7
3 2 7 6
3 3 0 4
3 3 4 7
"""


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Return one browser for all tests of a process: no second one can be driven in it."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield chromium
        chromium.close()

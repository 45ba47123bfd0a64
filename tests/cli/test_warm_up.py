"""Compiling: told while it takes time, done ahead of time by one command, and then never again."""

from __future__ import annotations

import importlib
import io
import json
import os
import pkgutil
import re
import subprocess
import sys
import time
from pathlib import Path

import numba
import pytest
from numba.core.dispatcher import Dispatcher

import kinolab
from kinolab.cli.progress import Progress
from kinolab.cli.warm_up_parts import PARTS, compiled_planners
from kinolab.cli.warm_up_processes import Warmed, WarmUpError, warm_up
from kinolab.errors import MissingPlannerError
from kinolab.numerics.compiling import compilation
from kinolab.planners import built_in, get
from kinolab.search.tree import AbstractCompiledPlanner
from tests.cli.test_interrupts import of_group
from tests.support import ENTER, environment, plan

LINE = "compiling inner loops, once on this computer"

PLANS = """
import json, sys
from numba.core.event import Listener, register

class Names(Listener):
    found = []
    def on_start(self, event):
        self.found.append(str(event.data["dispatcher"].py_func.__qualname__))
    def on_end(self, event):
        pass

register("numba:compile", Names())
import kinolab
from kinolab.show.film.animation import animate

for scenario, planner, settings in json.loads(sys.argv[1]):
    few = ["render.size=[64, 64]", "render.speed=100"]  # pixels, pictures
    problem = kinolab.load(scenario, overrides=few)
    found = problem.solve(planner, seed=1, time_limit=5.0, max_iterations=2000, **settings)
    if found.trajectory is not None:
        problem.checker(0.01).clearance(*problem.placement(found.trajectory.x[-1]))
        animate(problem, found.trajectory)
print(json.dumps(Names.found))
"""
SOLVED: list[tuple[str, str, dict[str, int]]] = [
    ("rolling_disk_maze", "rrt_fast", {"goal_bias": 0}),  # a mesh and boxes
    ("rolling_disk_maze", "kpiece_fast", {"cost_to_go_exponent": 1, "goal_region_scale": 4}),
    ("rolling_disk_maze", "prm", {}),
    ("crane_factory", "rrt_fast", {}),  # cables, and a mesh of many parts
    ("submarine_corridor", "kpiece_fast", {}),  # an attitude
    ("diffdrive_trap", "potential_field", {}),
    ("crane_factory", "potential_field", {}),  # in space
]


@pytest.mark.long
def test_after_warming_up_nothing_is_left_to_compile(tmp_path: Path) -> None:
    """In an empty cache of kernels; no machine and no grid of distances is kept either."""
    extra = {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "KINOLAB_CACHE": str(tmp_path / "kept")}
    first = plan("warm-up", cwd=tmp_path, timeout=1800, **extra)
    assert first.returncode == 0, first.stderr
    *rows, last = first.stdout.splitlines()
    assert {row.partition(":")[0] for row in rows} == set(PARTS)
    assert last.startswith("compiled ")
    assert LINE in first.stderr

    assert unkept(tmp_path / "numba") == set()
    again = plan("warm-up", "--quiet", cwd=tmp_path, timeout=300, **extra)
    told = {*(f"{part}: nothing to compile" for part in PARTS), "everything was compiled before"}
    assert set(again.stdout.splitlines()) == told
    assert again.stderr == ""

    plans = [sys.executable, "-c", PLANS, json.dumps(SOLVED)]
    done = subprocess.run(
        plans, cwd=tmp_path, env=environment(**extra), capture_output=True, text=True, check=True
    )
    assert json.loads(done.stdout.splitlines()[-1]) == []


def unkept(folder: Path) -> set[str]:
    """Name the compiled functions of kinolab that a cache of numba's lacks."""
    kept = {path.name.rpartition("-")[0] for path in folder.rglob("*.nbi")}
    modules = pkgutil.walk_packages(kinolab.__path__, "kinolab.")
    functions = {
        value.py_func
        for module in modules
        for value in vars(importlib.import_module(module.name)).values()
        if isinstance(value, Dispatcher) and value.py_func.__module__.startswith("kinolab.")
    }
    assert len(functions) > 100
    names = {f"{f.__module__.rpartition('.')[2]}.{f.__qualname__}" for f in functions}
    return names - kept


def test_every_planner_that_is_compiled_is_warmed_up() -> None:
    found = set()
    for name in built_in():
        try:
            if issubclass(get(name), AbstractCompiledPlanner):
                found.add(name)
        except MissingPlannerError:
            continue
    assert set(compiled_planners()) == found
    assert {"rrt_fast", "kpiece_fast"} <= found


def fresh() -> int:
    """Compile a function that nobody has compiled before, which compiles another one."""
    inner = numba.njit(lambda x: x + 1)
    return int(numba.njit(lambda x: inner(x) + 1)(1))


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """Let stderr be a terminal from now on."""
    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)
    return screen


def test_a_terminal_shows_what_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = terminal(monkeypatch)
    with Progress(quiet=False).compiling():
        assert fresh() == 3
    shown = re.sub(r": [0-9]+ s, ", ": … s, ", screen.getvalue()).split("\r\033[K")
    assert shown == ["", f"{LINE}: … s, 1 function …", f"{LINE}: … s, 2 functions …"]


def test_a_quiet_command_says_nothing_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = terminal(monkeypatch)
    with Progress(quiet=True).compiling():
        fresh()
    assert screen.getvalue() == ""


def test_a_log_is_told_at_most_every_five_seconds(capsys: pytest.CaptureFixture[str]) -> None:
    progress = Progress(quiet=False)
    progress("searching")
    with progress.compiling():
        fresh()
    assert capsys.readouterr().err == "searching\n"


def test_what_was_compiled_before_is_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = terminal(monkeypatch)
    function = numba.njit(lambda x: x + 1)
    function(1)
    with Progress(quiet=False).compiling(), compilation() as counted:
        function(1)
    assert (counted.functions, counted.seconds) == (0, 0.0)
    assert screen.getvalue() == ""


def test_time_counts_while_something_is_compiled() -> None:
    seen: list[float] = []
    with compilation(lambda so_far: seen.append(so_far.seconds)) as counted:
        fresh()
        before = counted.seconds
        fresh()
    assert counted.functions == 4
    assert 0.0 <= seen[0] <= seen[1] <= before < counted.seconds
    assert seen[2] >= before


def test_a_part_that_cannot_be_compiled_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> None:
        raise RuntimeError("no room on the disk")

    monkeypatch.setitem(PARTS, "broken", broken)
    with pytest.raises(WarmUpError, match=r"(?s)broken: .*no room on the disk"):
        list(warm_up(["broken"], jobs=1))


def test_parts_are_done_one_after_the_other_by_one_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[str] = []
    for name in ("one", "other"):
        monkeypatch.setitem(PARTS, name, lambda name=name: seen.append(name))
    told = list(warm_up(["one", "other"], jobs=1))
    assert seen == ["one", "other"]
    assert told == [Warmed(name, 0, 0.0, done=True) for name in seen]


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are read in /proc")
def test_ctrl_c_ends_all_processes_that_compile(tmp_path: Path) -> None:
    """Once one of them has compiled something; a line that says so would come after 5 s."""
    extra = {"NUMBA_CACHE_DIR": str(tmp_path / "numba")}
    process = subprocess.Popen(
        [sys.executable, "-c", ENTER, "warm-up", "--jobs", "2"],
        cwd=tmp_path,
        env=environment(**extra),
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 60
    while not [*tmp_path.rglob("*.nbc")] and time.monotonic() < deadline:
        time.sleep(0.05)
    assert len(of_group(process.pid)) == 4  # the parent, its child, two that compile
    os.killpg(process.pid, 2)
    process.communicate(timeout=30)
    assert process.returncode == 130
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)

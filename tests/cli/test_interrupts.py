"""Ctrl-C at any moment: over within a second, with what was found, and nothing left behind.

A terminal sends the signal to every process of a command; so do these tests.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinolab.problem import PlanningTask
from kinolab.search import Budget
from tests.support import OPEN, ROOT, environment

pytestmark = pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are read in /proc")

# says so when the command begins: before that, Ctrl-C ends the interpreter itself
ENTER = """
import sys
from kinolab.cli import INTERRUPTS, main
INTERRUPTS.guard()
print("begun", file=sys.stderr, flush=True)
main()
"""
LATEST = 3.0  # [s]; 1 is promised, on a machine that does nothing else
HARD = ("--set", "goal.x=4", "--set", "goal.tolerance=1e-9")  # is not hit by chance
READY = '''
"""Has a motion of so many steps that it takes a second to re-simulate and to verify."""

import sys
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kinolab.search import AbstractPlanner, Outcome, SearchResult


@dataclass(frozen=True, kw_only=True)
class Ready(AbstractPlanner):
    """Rolls ahead for 4 s."""

    name: ClassVar[str] = "ready"

    def solve(self, problem, seed, budget):
        u = np.tile([0.05, 0.0], (80_000, 1))
        print("found", file=sys.stderr, flush=True)
        t = problem.step * np.arange(len(u) + 1.0)
        return SearchResult(Outcome.SOLVED, t, u, np.int64(1))
'''
FOUND = ("--planner", "planners.py:Ready", "--set", "integration.step=0.00005", "--no-animation")
TELLING = '''
"""Says now and then that its tree grows."""

import sys
from dataclasses import dataclass
from typing import ClassVar

from kinolab.planners.rrt import RRT


@dataclass(frozen=True, kw_only=True)
class Telling(RRT):
    """OMPL's trees, of which several grow in as many processes."""

    name: ClassVar[str] = "telling"

    def solve(self, problem, seed, budget):
        told = budget.progress

        def progress(iterations, seconds):
            if iterations > 1000:  # by then one motion came nearer to the goal
                print("growing", file=sys.stderr, flush=True)
            if told:
                told(iterations, seconds)

        budget.progress = progress
        return super().solve(problem, seed, budget)
'''
GROWING = (*HARD, "--planner", "planners.py:Telling", "--no-animation")
# One extension makes 100 000 steps, which takes seconds without a look at the budget.
LONG = ("integration.step=0.00001", "planner.max_steps=100000", "planner.min_steps=100000")
LONG_CALLS = tuple(word for setting in LONG for word in ("--set", setting))


@dataclass(frozen=True)
class Ended:
    """What became of a command that was interrupted."""

    code: int
    seconds: float
    out: str
    err: str
    home: Path

    @property
    def report(self) -> dict[str, Any] | None:
        """The report of the run, None where none was written."""
        path = self.home / "runs" / "table" / "report.json"
        return json.loads(path.read_text()) if path.is_file() else None


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A working folder with the table in it."""
    (tmp_path / "table.toml").write_text(OPEN)
    return tmp_path


def start(home: Path, *arguments: str, **extra: str) -> subprocess.Popen[str]:
    """Start the command as a terminal does, with a process group of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", ENTER, *arguments],
        cwd=home,
        env=environment(**extra),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def listen(process: subprocess.Popen[str], word: str) -> str:
    """Read stderr until a word is said, and return what was read."""
    assert process.stderr is not None
    heard = ""
    for line in process.stderr:
        heard += line
        if word in line:
            break
    return heard


def of_group(group: int) -> list[str]:
    """The states of all processes of a group; Z where nobody has asked yet how one ended."""
    states = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            state, _, own = (entry / "stat").read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue  # it has just left
        if int(own) == group:
            states.append(state)
    return states


def interrupt(
    home: Path,
    *arguments: str,
    after: float,
    word: str = "begun",
    again: float | None = None,
    **extra: str,
) -> Ended:
    """Send Ctrl-C some seconds after a word, and check what holds at any moment."""
    process = start(home, *arguments, **extra)
    heard = listen(process, word)
    time.sleep(after)
    begun = time.monotonic()
    os.killpg(process.pid, signal.SIGINT)
    if again is not None:
        time.sleep(again)
        os.killpg(process.pid, signal.SIGINT)
    process.wait(timeout=60)
    seconds = time.monotonic() - begun
    while (left := of_group(process.pid)) and time.monotonic() < begun + LATEST:
        time.sleep(0.01)  # the kernel ends what belongs to a killed process, in a moment
    while set(left) == {"Z"} and time.monotonic() < begun + seconds + LATEST:
        time.sleep(0.01)  # it has ended: init asks how, when it comes to it
        left = of_group(process.pid)
    out, err = process.communicate(timeout=10)
    ended = Ended(process.returncode, seconds, out, heard + err, home)
    assert ended.code == 130, ended.err
    assert ended.seconds < LATEST
    assert left == []
    for sign in ("Traceback", "Exception", "nanobind", "mistake in kinolab"):
        assert sign not in ended.err
    assert [path for path in home.rglob(".*") if path.is_file()] == []  # half-written files
    return ended


# --- at many moments ---


# In [s] after what is said.
@pytest.mark.parametrize(
    ("word", "after"),
    [("begun", 0.1), ("deriving", 0.0), ("searching", 0.0), ("searching", 0.1), ("searching", 0.5)],
)
def test_a_search_can_be_interrupted_at_any_moment(word: str, after: float, home: Path) -> None:
    """Imports, the machine, the start, the search: a report exists only where one began."""
    ended = interrupt(home, "table.toml", *HARD, "--no-animation", word=word, after=after)
    if ended.report is not None:
        assert ended.report["status"] == "interrupted"
        assert ended.report["iterations"] > 0
        assert ended.out.startswith("interrupted: ")


@pytest.mark.parametrize("after", [0.5, 1.0])
def test_several_processes_can_be_interrupted_while_they_begin(after: float, home: Path) -> None:
    options = (*HARD, "--jobs", "2", "--no-animation")
    ended = interrupt(home, "table.toml", *options, word="searching", after=after)
    assert ended.report is None or ended.report["status"] == "interrupted"


def test_several_processes_that_search_can_be_interrupted(home: Path) -> None:
    (home / "planners.py").write_text(TELLING)
    ended = interrupt(home, "table.toml", *GROWING, "--jobs", "2", word="growing", after=0.0)
    assert ended.report is not None
    assert ended.report["status"] == "interrupted"
    assert (home / "runs" / "table" / "trajectory.csv").is_file()


@pytest.mark.parametrize("after", [0.0, 0.1, 0.5])
def test_re_simulation_and_verification_can_be_interrupted(after: float, home: Path) -> None:
    (home / "planners.py").write_text(READY)
    ended = interrupt(home, "table.toml", *FOUND, word="found", after=after)
    if ended.report is not None:
        assert ended.report["status"] in {"interrupted", "solved"}


@pytest.mark.parametrize(
    ("after", "cold"), [(0.0, False), (0.2, False), pytest.param(1.0, True, marks=pytest.mark.long)]
)
def test_a_picture_can_be_interrupted_and_the_plan_stays(
    after: float, cold: bool, home: Path
) -> None:
    """Cold is a renderer that has to be compiled first."""
    extra = {"NUMBA_CACHE_DIR": str(home / "numba")} if cold else {}
    slow = ("--set", "render.speed=0.01")  # as many frames as a film may have
    ended = interrupt(home, "table.toml", *slow, word="drawing the film", after=after, **extra)
    assert ended.report is not None
    assert ended.report["status"] == "solved"
    assert ended.out.startswith("solved: ")
    assert "written to" not in ended.out
    assert (home / "runs" / "table" / "scene.html").is_file()
    assert not (home / "runs" / "table" / "animation.gif").exists()


@pytest.mark.parametrize("after", [0.0, 0.3, 1.0])
def test_deriving_and_compiling_can_be_interrupted(after: float, home: Path) -> None:
    extra = {"KINOLAB_CACHE": str(home / "cache"), "NUMBA_CACHE_DIR": str(home / "numba")}
    ended = interrupt(home, "submarine_corridor", word="deriving", after=after, **extra)
    assert not (home / "runs").exists()
    assert ended.out == ""


@pytest.mark.parametrize("command", ["examine", "equations"])
def test_other_commands_can_be_interrupted(command: str, home: Path) -> None:
    """Of a machine that takes seconds to derive, on any computer."""
    own = {"KINOLAB_CACHE": str(home / "cache")}
    assert interrupt(home, command, "marionette", after=1.0, **own).out == ""


# --- what must not stand in the way ---


def test_a_long_call_of_ompl_comes_to_its_end(home: Path) -> None:
    ended = interrupt(home, "table.toml", *LONG_CALLS, word="searching", after=0.5)
    assert ended.report is None or ended.report["status"] == "interrupted"


MACHINE = """
import sys, time

def tell():
    print("stuck", file=sys.stderr, flush=True)

def make():
    {}
"""
STUCK = {
    "native code that holds the interpreter's lock": "tell(); sum(range(10**12))",
    "native code that lets others run": "import ctypes; tell(); ctypes.CDLL(None).usleep(10**8)",
    "compiled code that never returns": """
    import numba
    def endless(number):
        while number >= 0:
            number = (number + 1) % 1000
    compiled = numba.njit("void(int64)")(endless)
    tell()
    compiled(0)
""",
    "a library that swallows KeyboardInterrupt": """
    tell()
    while True:
        try:
            time.sleep(0.01)
        except BaseException:
            pass
""",
}


@pytest.mark.parametrize("code", STUCK.values(), ids=STUCK.keys())
def test_nothing_holds_the_command(code: str, home: Path) -> None:
    write_machine(home, code)
    interrupt(home, "own.toml", word="stuck", after=0.1)
    assert not (home / "runs").exists()


def write_machine(home: Path, code: str) -> None:
    """Write a scenario own.toml whose machine runs some code when it is made."""
    (home / "own.py").write_text(MACHINE.format(code))
    (home / "own.toml").write_text(OPEN.replace('name = "rolling_disk"', 'file = "own.py:make"'))


def test_the_signal_may_come_twice_for_one_press(home: Path) -> None:
    """From the terminal and from the program that started the command: the plan is kept."""
    (home / "planners.py").write_text(TELLING)
    ended = interrupt(home, "table.toml", *GROWING, word="growing", after=0.0, again=0.01)
    assert ended.report is not None


def test_the_second_press_ends_at_once(home: Path) -> None:
    (home / "planners.py").write_text(READY)
    ended = interrupt(home, "table.toml", *FOUND, word="found", after=0.3, again=0.2)
    assert ended.seconds < 0.2 + LATEST


# --- what is kept ---


def test_a_plan_that_was_verified_before_stays_solved(home: Path) -> None:
    """Ctrl-C means that it is good enough."""
    options = ("--anytime", "--time-limit", "60")
    ended = interrupt(home, "table.toml", *options, word="s of motion", after=0.5)
    assert ended.report is not None
    assert (ended.report["status"], ended.report["interrupted"]) == ("solved", True)
    assert ended.out.startswith("solved: ")
    assert "Interrupted" in ended.out


def test_an_earlier_run_stays_where_nothing_was_found(home: Path) -> None:
    folder = home / "runs" / "table"
    folder.mkdir(parents=True)
    (folder / "trajectory.csv").write_text("mine")
    interrupt(home, "table.toml", *HARD, "--jobs", "2", word="searching", after=0.1)
    assert (folder / "trajectory.csv").read_text() == "mine"


# --- the parent and its child ---


def stuck(home: Path, code: str) -> subprocess.Popen[str]:
    """Start a command, and wait until some code holds it."""
    write_machine(home, code)
    process = start(home, "own.toml")
    listen(process, "stuck")
    return process


def child_of(process: subprocess.Popen[str]) -> int:
    """The process that a command's parent waits for."""
    (child,) = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return int(child)


def wait_for(process: subprocess.Popen[str], states: set[str]) -> None:
    """Wait until all processes of a command are in one of some states, or gone."""
    deadline = time.monotonic() + 10
    while not set(of_group(process.pid)) <= states and time.monotonic() < deadline:
        time.sleep(0.05)
    assert set(of_group(process.pid)) <= states


@pytest.mark.parametrize("code", STUCK.values(), ids=STUCK.keys())
def test_no_orphan_stays_when_the_parent_is_killed(code: str, home: Path) -> None:
    process = stuck(home, code)
    process.kill()
    process.communicate()
    wait_for(process, {"Z"})  # nobody may be there to bury it


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_other_signals_end_both_and_say_so(number: signal.Signals, home: Path) -> None:
    """A shell tells by what signal a command ended."""
    process = stuck(home, STUCK["native code that holds the interpreter's lock"])
    process.send_signal(number)
    process.communicate(timeout=10)
    assert process.returncode == -number
    assert of_group(process.pid) == []


def test_a_command_that_is_killed_is_told_as_killed(home: Path) -> None:
    """As a system does that has no memory left."""
    process = stuck(home, "tell(); time.sleep(60)")
    os.kill(child_of(process), signal.SIGKILL)
    process.communicate(timeout=10)
    assert process.returncode == -signal.SIGKILL


def test_ctrl_z_stops_both_until_they_are_let_go_on(home: Path) -> None:
    """Also where only the parent hears of it, of a group that somebody else may let go on."""
    (home / "table.toml").write_text(OPEN)
    process = subprocess.Popen(
        [sys.executable, "-c", ENTER, "table.toml", *HARD, "--no-animation"],
        cwd=home,
        env=environment(),
        stderr=subprocess.PIPE,
        text=True,
        process_group=0,
    )
    listen(process, "searching")
    process.send_signal(signal.SIGTSTP)
    wait_for(process, {"T"})
    process.send_signal(signal.SIGCONT)
    wait_for(process, {"R", "S", "D"})
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=10)
    assert process.returncode == 130


def test_processes_leave_when_the_one_that_started_them_is_killed(home: Path) -> None:
    process = start(home, "table.toml", *HARD, "--jobs", "2", "--quiet")
    deadline = time.monotonic() + 30
    while len(of_group(process.pid)) < 4 and time.monotonic() < deadline:
        time.sleep(0.05)
    assert len(of_group(process.pid)) == 4  # the parent, its child, two that search
    process.kill()
    process.communicate()
    wait_for(process, {"Z"})  # nobody may be there to bury them


def test_the_process_that_draws_leaves_when_the_one_that_started_it_is_killed(home: Path) -> None:
    process = start(home, "table.toml", "--set", "render.speed=0.01")
    listen(process, "drawing the film")
    process.kill()
    process.communicate()
    wait_for(process, {"Z"})  # nobody may be there to bury it


def test_a_motion_that_nobody_waits_for_is_the_planners_own(
    table: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The truth takes DOP853 its time; one step of the planner's integrator per knot does not."""
    budgets: list[Budget] = []

    def broken_off(*_: Any) -> None:
        budgets[0].end()

    monkeypatch.setattr("kinolab.solve.attempt.resimulate", broken_off)
    found = table.solve(seed=1, max_iterations=5000, watch=budgets.append)
    assert (found.status, found.interrupted, found.exit_code) == ("interrupted", True, 130)
    assert found.certificate is None
    motion = found.trajectory
    assert motion is not None
    assert (motion.x[0] == table.start).all()
    for k, u in enumerate(motion.u):
        after = table.model.step(motion.x[k], u, table.step)
        assert np.abs(motion.x[k + 1] - after).max() < 1e-12  # the times are rounded


def test_a_plan_that_was_not_verified_in_time_says_so(
    table: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    budgets: list[Budget] = []
    monkeypatch.setattr("kinolab.solve.attempt.verify", lambda *_: budgets[0].end())
    found = table.solve(seed=1, max_iterations=5000, watch=budgets.append)
    assert found.status == "interrupted"
    assert found.message == "Interrupted before what was found had been verified."
    assert found.trajectory is not None
    assert table.goal_excess(found.trajectory.x[-1]) <= 1.0


# --- a budget that is ended ---


def test_the_first_call_of_end_asks_and_the_second_breaks_off() -> None:
    budget = Budget(10.0)

    def work() -> str:
        budget.end()
        assert budget.spent()
        budget.end()
        return "done"  # pragma: no cover

    assert budget.breaking(work, patience=1) is None
    assert Budget(10.0).breaking(lambda: "done") == "done"


def test_what_a_library_makes_of_the_interrupt_is_understood() -> None:
    budget = Budget(10.0)

    def work() -> None:
        try:
            budget.end()
        except KeyboardInterrupt as error:
            raise RuntimeError("no compiled object yet") from error

    assert budget.breaking(work) is None


def test_an_error_of_its_own_is_not_taken_for_an_interrupt() -> None:
    budget = Budget(10.0)
    budget.end()
    with pytest.raises(ZeroDivisionError):
        budget.breaking(lambda: 1 / 0)
    with pytest.raises(KeyboardInterrupt):  # from the user of a program, not from ``end``
        budget.breaking(lambda: signal.raise_signal(signal.SIGINT))


def test_nothing_is_broken_off_outside() -> None:
    budget = Budget(10.0)
    for _ in range(3):
        budget.end()
    assert budget.breaking(lambda: "later") == "later"
    budget.end()


# --- where nobody hears it ---

DEAF = """
import signal, sys, pytest
signal.signal(signal.SIGINT, signal.SIG_IGN)
sys.exit(pytest.main(["-q", "-n", "0", "-m", "", "-p", "no:cacheprovider", *sys.argv[1:]]))
"""
HEARD = """
import signal, subprocess, sys

def test_signals_are_heard_here_and_in_a_process_that_is_started() -> None:
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    asked = "import signal; print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)"
    done = subprocess.run([sys.executable, "-c", asked], capture_output=True, check=True)
    assert done.stdout == b"True\\n"
"""


def test_these_tests_do_not_mind_who_ignores_ctrl_c(tmp_path: Path) -> None:
    """As nohup and shells in the background do; it is handed on to every process."""
    (tmp_path / "test_hearing.py").write_text(HEARD)
    (tmp_path / "conftest.py").write_text("from tests.conftest import _signals_are_heard as _heard")
    done = subprocess.run(
        [sys.executable, "-c", DEAF, str(tmp_path / "test_hearing.py"), f"--rootdir={ROOT}",
         "-c", str(ROOT / "pyproject.toml")],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout

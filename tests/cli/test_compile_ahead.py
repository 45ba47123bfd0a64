"""A second process compiles what a command needs later; it ends with the command."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numba
import pytest

from kinolab.cli.compile_ahead import compiled_ahead
from kinolab.concurrency import process_worker
from kinolab.concurrency.processors import processors
from tests.cli.test_warm_up import PLANS
from tests.support import environment

ALONE = sys.platform == "win32" or processors() < 2
needs_two = pytest.mark.skipif(ALONE, reason="needs a second processor and signals")

BUSY = """
import time
import numba
from kinolab.cli.compile_ahead import compiled_ahead
from kinolab.concurrency import process_worker

with compiled_ahead():
    numba.njit(lambda x: x + 1)(1)
    print(*(process.pid for process in process_worker._running), flush=True)
    time.sleep(600)
"""
AHEAD = """
from kinolab.cli.compile_ahead import in_order

for part in in_order():
    part()
"""


def fresh() -> int:
    """Compile a function that nobody has compiled before."""
    return int(numba.njit(lambda x: x + 1)(1))


def is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"


@needs_two
def test_a_process_starts_once_something_is_compiled_and_ends_with_the_command() -> None:
    with compiled_ahead():
        assert not process_worker._running
        assert fresh() == 2
        assert fresh() == 2
        (process,) = process_worker._running
        assert process.poll() is None
    assert not process_worker._running
    assert process.returncode is not None


@needs_two
def test_where_all_is_compiled_no_process_starts() -> None:
    made = numba.njit(lambda x: x + 1)
    made(1)
    with compiled_ahead():
        assert made(1) == 2
        assert not process_worker._running


@needs_two
def test_a_command_without_a_second_processor_compiles_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("kinolab.concurrency.processors.processors", lambda: 1)
    with compiled_ahead():
        assert fresh() == 2
        assert not process_worker._running


@needs_two
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are read in /proc")
def test_it_does_not_outlive_a_command_that_is_killed(tmp_path: Path) -> None:
    """SIGKILL leaves no time to clear up."""
    extra = {"NUMBA_CACHE_DIR": str(tmp_path / "numba")}
    command = subprocess.Popen(
        [sys.executable, "-c", BUSY], env=environment(**extra), stdout=subprocess.PIPE, text=True
    )
    assert command.stdout is not None
    helper = int(command.stdout.readline())
    assert is_alive(helper)
    command.send_signal(signal.SIGKILL)
    command.communicate()
    until = time.monotonic() + 60
    while is_alive(helper):
        assert time.monotonic() < until
        time.sleep(0.05)


@pytest.mark.long
def test_what_it_compiles_a_plan_does_not(tmp_path: Path) -> None:
    """The signatures are those that the default planner asks for."""
    extra = {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "KINOLAB_CACHE": str(tmp_path / "kept")}
    where = {"cwd": tmp_path, "env": environment(**extra)}
    subprocess.run([sys.executable, "-c", AHEAD], check=True, **where)
    solved = json.dumps([("rolling_disk_maze", "auto", {})])
    done = subprocess.run(
        [sys.executable, "-c", PLANS, solved], check=True, capture_output=True, text=True, **where
    )
    compiled = set(json.loads(done.stdout.splitlines()[-1]))
    assert compiled & {"explore", "mark_shape"}  # these are left to the command
    assert not compiled & {"grow", "extend", "integrate", "linearise", "find_at", "normal", "_draw"}

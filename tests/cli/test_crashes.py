"""Native code that crashes: told in a sentence, and the searches with other seeds go on."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import OPEN, environment, plan

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there is no second process")

SUPERVISED = """
import os, signal
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.supervisor import supervise
supervise()
with INTERRUPTS.sharing_fate({several}):
    if INTERRUPTS.after_crash and {once}:
        os._exit(3)
    os.kill(os.getpid(), signal.{crash})
"""
PLANNER = '''
"""Crashes with the first seed, as native code does."""

import fcntl
import os
import time
from dataclasses import dataclass
from typing import ClassVar

from kinolab.planners.rrt_fast import RRTFast


@dataclass(frozen=True, kw_only=True)
class Crashing(RRTFast):
    """RRT that crashes."""

    name: ClassVar[str] = "crashing"

    def solve(self, problem, seed, budget):
        with open("crashes", "ab") as crashes:
            if seed == 1:
                fcntl.flock(crashes, fcntl.LOCK_EX)  # given back when the process is gone
                os.write(crashes.fileno(), b"x")
                os.abort()
            while os.fstat(crashes.fileno()).st_size < 2:  # in a thread, and then in a process
                time.sleep(0.01)
            fcntl.flock(crashes, fcntl.LOCK_EX)
        return super().solve(problem, seed, budget)
'''


def supervised(several: bool, crash: str, *, once: bool) -> subprocess.CompletedProcess[str]:
    """Run code below a parent process that crashes, in the first process only or in both."""
    code = SUPERVISED.format(several=several, once=once, crash=crash)
    words = [sys.executable, "-c", code]
    return subprocess.run(words, env=environment(), capture_output=True, text=True, check=False)


@pytest.mark.parametrize("crash", ["SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL"])
def test_a_crash_is_told_and_has_an_exit_code(crash: str) -> None:
    ended = supervised(False, crash, once=True)
    assert ended.returncode == 70
    assert f"error: native code crashed ({crash})" in ended.stderr


def test_what_others_can_go_on_with_is_done_once_more() -> None:
    ended = supervised(True, "SIGSEGV", once=True)
    assert ended.returncode == 3
    assert ended.stderr.count("native code crashed (SIGSEGV)") == 1
    assert "error" not in ended.stderr


def test_what_crashes_again_is_not_done_a_third_time() -> None:
    ended = supervised(True, "SIGSEGV", once=False)
    assert ended.returncode == 70
    assert ended.stderr.count("native code crashed (SIGSEGV)") == 2


def test_a_signal_that_is_no_crash_is_passed_on() -> None:
    assert supervised(True, "SIGKILL", once=False).returncode == -9


def test_the_other_seeds_go_on_where_one_crashes_in_a_thread(tmp_path: Path) -> None:
    (tmp_path / "table.toml").write_text(OPEN)
    (tmp_path / "own.py").write_text(PLANNER)
    words = ("table.toml", "--planner", "own.py:Crashing", "--jobs", "2", "--no-animation")
    ended = plan(*words, cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    report = json.loads((tmp_path / "runs" / "table" / "report.json").read_text())
    first, second = report["attempts"]
    assert (first["seed"], first["status"]) == (1, "failed")
    assert first["detail"] == "its process was ended by SIGABRT."
    assert (second["seed"], second["status"]) == (2, "solved")


def test_a_command_goes_on_where_no_second_process_can_be_had(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from kinolab.cli.supervisor import supervise

    def refused() -> int:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(os, "fork", refused)
    supervise()  # and returns here

"""Streams that are closed or full: the command does its work, and says so by its exit code."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import ENTER, environment

pytestmark = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no such device")


def code_of(tmp_path: Path, streams: str, *arguments: str) -> int:
    """Run a command whose streams a shell redirects, and return its exit code."""
    words = shlex.join([sys.executable, "-c", ENTER, *arguments])
    ended = subprocess.run(
        ["sh", "-c", f"{words} {streams}"], cwd=tmp_path, env=environment(), check=False
    )
    return ended.returncode


@pytest.mark.parametrize(
    "streams", [">&-", "2>&-", ">&- 2>&-", "<&-", "<&- >&- 2>&-", "2>/dev/full"]
)
def test_no_stream_is_needed(streams: str, tmp_path: Path) -> None:
    assert code_of(tmp_path, streams, "help") == 0


def test_what_is_wrong_is_told_by_the_exit_code_alone(tmp_path: Path) -> None:
    assert code_of(tmp_path, "2>&-", "check", "nowhere") == 2


def test_a_result_that_cannot_be_told_is_no_success(tmp_path: Path) -> None:
    assert code_of(tmp_path, ">/dev/full", "help") == 2


def test_no_file_takes_the_place_of_a_stream(tmp_path: Path) -> None:
    """It got what was meant for the stream."""
    code = (
        "import sys; from kinolab.cli.streams import prepare_streams; prepare_streams(); "
        "file = open('file', 'w'); print(file.fileno(), file=file); "
        "print('out'); print('err', file=sys.stderr)"
    )
    words = shlex.join([sys.executable, "-c", code])
    script = f"{words} <&- >&- 2>&-"
    subprocess.run(["sh", "-c", script], cwd=tmp_path, env=environment(), check=True)
    assert int((tmp_path / "file").read_text()) > 2

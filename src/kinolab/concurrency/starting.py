"""Starting other processes, connected by a pipe and shielded from Ctrl-C.

They are fresh interpreters, not forks, since native libraries do not survive a fork; and unlike
those of ``multiprocessing`` they do not re-import the user's script.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import Pipe
from multiprocessing.connection import Connection

from kinolab.errors import InputError, Mistake

Process = subprocess.Popen[bytes]

ENTRY = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from {module} import enter; enter(int(sys.argv[2]))"
)


STDERR = 2  # all output goes there: stdout is for the result

_running: set[Process] = set()


def start_process(module: str) -> tuple[Process, Connection]:
    """Start a process and return it with the connection to it.

    Args:
        module: Its ``enter`` is run with the file descriptor of the other end of the connection,
            and passes it to ``serving.serve``.

    Raises:
        InputError: If this platform cannot inherit a connection.
        OSError: If the system cannot start another process.
    """
    if sys.platform == "win32":
        what = "several processes are not to be had on Windows."
        raise InputError([Mistake("jobs", what, "Use jobs=1.")])
    ours, theirs = Pipe()
    code = ENTRY.format(module=module)
    command = [sys.executable, "-c", code, json.dumps(sys.path), str(theirs.fileno())]
    try:
        with theirs, _deaf_to_interrupts():
            process = subprocess.Popen(
                command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, stdout=STDERR
            )
            _running.add(process)
    except BaseException:
        ours.close()
        raise
    return process, ours


def bury(process: Process) -> None:
    """Reap a killed process."""
    process.wait()
    _running.discard(process)


def kill_all() -> None:
    """Kill all processes, for exits that skip the usual clean-up."""
    for process in tuple(_running):
        process.kill()
    for process in tuple(_running):
        process.wait()


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Block SIGINT, so that processes started here are shielded before they can ignore it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

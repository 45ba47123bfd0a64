"""Fresh Python processes, connected to this one, that Ctrl-C does not reach.

They are interpreters of their own and not forks, since native libraries do not survive a fork; and
they do not read the user's script again, as those of ``multiprocessing`` do.
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
SEARCHES = "kinolab.solve.worker"
STDERR = 2  # where all output goes: stdout belongs to the result

_running: set[Process] = set()


def start_process(module: str = SEARCHES) -> tuple[Process, Connection]:
    """Start a process and return it with the connection to it.

    Args:
        module: Whose ``enter`` it runs, with the file descriptor of its end of the connection.

    Raises:
        InputError: If this platform cannot pass a connection on.
        OSError: If the system has no room for one more.
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
    """Wait until a process that was killed has left."""
    process.wait()
    _running.discard(process)


def kill_all() -> None:
    """Kill all processes, for one that leaves without coming back to what it was doing."""
    for process in tuple(_running):
        process.kill()
    for process in tuple(_running):
        process.wait()


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Start processes that Ctrl-C does not reach, not even before they can say so themselves."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

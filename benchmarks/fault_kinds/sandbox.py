"""Commands in forked processes: started, struck by a fault, and watched from outside.

The process that forks has imported what the commands import, so a command begins at once. It is the
command itself that runs, ``kinolab.cli.main`` with its own second process, not a part of it.
"""

from __future__ import annotations

import ctypes
import mmap
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, NoReturn

ENTER = "from kinolab.cli import main; main()"
PR_SET_CHILD_SUBREAPER = 36  # orphans become children of this process, and are seen
LOOK = 0.002  # [s] between looks at a command
LEAVE = 5.0  # [s] for what a command started to leave after it
GIGABYTE = 2**30
SIGNS = ("Traceback (most recent call last)", "Exception ignored", "Fatal Python error")


@dataclass(frozen=True)
class Ended:
    """What is seen of a command from outside.

    Attributes:
        code: Its exit code, negative for the signal that ended it; None if it had to be killed.
        out: Its stdout.
        err: Its stderr.
        seconds: How long it took.
        orphans: Processes that it started and that did not leave.
    """

    code: int | None
    out: str
    err: str
    seconds: float
    orphans: int = 0

    @property
    def traceback(self) -> bool:
        """Whether a traceback or what stands for one is in its output."""
        return any(sign in self.err + self.out for sign in SIGNS)


@dataclass
class Command:
    """A command under way.

    Attributes:
        pid: Of its first process, which leads a session of its own.
        scratch: Where its output goes.
    """

    pid: int
    scratch: Path
    begun: float = field(default_factory=time.monotonic)

    def send(self, number: int) -> None:
        """Send a signal to its first process."""
        with suppress(ProcessLookupError):
            os.kill(self.pid, number)

    def send_all(self, number: int) -> None:
        """Send a signal to all its processes, as a terminal does."""
        with suppress(ProcessLookupError):
            os.killpg(self.pid, number)

    def ended(self, limit: float) -> Ended:
        """Wait for its end, and for that of all it started; kill what stays."""
        code, until = self._code(self.begun + limit), time.monotonic() + LEAVE
        seconds = time.monotonic() - self.begun
        if code is None:
            # One that has only just begun does not lead its group yet.
            self.send_all(signal.SIGKILL)
            self.send(signal.SIGKILL)
            os.waitpid(self.pid, 0)
        while (left := session(self.pid)) and time.monotonic() < until:
            reap(self.pid)
            time.sleep(LOOK)
        for process in left:
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        out, err = (self.scratch / name for name in ("out", "err"))
        # One that was killed at once has not opened them yet.
        texts = [
            path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
            for path in (out, err)
        ]
        return Ended(code, *texts, seconds, len(left))

    def _code(self, until: float) -> int | None:
        while time.monotonic() < until:
            gone, status = os.waitpid(self.pid, os.WNOHANG)
            if gone:
                return os.waitstatus_to_exitcode(status)
            time.sleep(LOOK)
        return None


def adopt_orphans() -> None:
    """Make this process the parent of those whose own parent ends."""
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)


def session(leader: int) -> list[int]:
    """Return the processes of a session that are not over."""
    found = []
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            with suppress(OSError):
                stat = Path("/proc", entry, "stat").read_text(errors="replace")
                state, _, _, own = stat.rpartition(")")[2].split()[:4]
                if int(own) == leader and state != "Z":
                    found.append(int(entry))
    return found


def reap(leader: int) -> None:
    """Bury what a command left to this process."""
    with suppress(ChildProcessError):
        while os.waitpid(-leader, os.WNOHANG)[0]:
            pass


def start(
    arguments: Sequence[str | bytes | Path],
    cwd: Path,
    scratch: Path,
    *,
    prepare: Callable[[], None] | None = None,
    environment: Mapping[str, str] | None = None,
    fresh: bool = False,
    gigabytes: float = 6.0,
) -> Command:
    """Start a command.

    Args:
        arguments: Those of ``plan``.
        cwd: Working folder.
        scratch: Folder for its output, outside of what the fault concerns.
        prepare: Called in its process before it begins.
        environment: Variables besides those of this process.
        fresh: Whether it is a new interpreter, which imports everything itself.
        gigabytes: Address space that it may take.
    """
    scratch.mkdir(parents=True, exist_ok=True)
    sys.stdout.flush()
    sys.stderr.flush()
    pid = os.fork()
    if pid == 0:
        _become(list(arguments), cwd, scratch, prepare, environment or {}, fresh, gigabytes)
    return Command(pid, scratch)


def run(
    arguments: Sequence[str | bytes | Path],
    cwd: Path,
    scratch: Path,
    limit: float = 120.0,
    **further: object,
) -> Ended:
    """Run a command to its end; what further words mean is said by ``start``."""
    return start(arguments, cwd, scratch, **further).ended(limit)  # type: ignore[arg-type]


def _become(
    arguments: Iterable[str | bytes | Path],
    cwd: Path,
    scratch: Path,
    prepare: Callable[[], None] | None,
    environment: Mapping[str, str],
    fresh: bool,
    gigabytes: float,
) -> NoReturn:
    try:
        os.setsid()
        os.chdir(cwd)
        _redirect(0, Path(os.devnull), os.O_RDONLY)
        _redirect(1, scratch / "out", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        _redirect(2, scratch / "err", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        resource.setrlimit(resource.RLIMIT_AS, (int(gigabytes * GIGABYTE),) * 2)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.environ.update(environment)
        if fresh:
            if prepare:
                prepare()
            words = [os.fsencode(word) for word in arguments]
            os.execv(sys.executable, [os.fsencode(sys.executable), b"-c", ENTER.encode(), *words])
        from kinolab.cli import main
        from kinolab.cli.interrupts import INTERRUPTS

        # What it shares with its own child, it shares with no other command.
        INTERRUPTS.is_writing, INTERRUPTS.shares_fate = mmap.mmap(-1, 1), mmap.mmap(-1, 1)
        sys.argv = ["plan", *(os.fsdecode(word) for word in arguments)]
        if prepare:
            prepare()
        for number, name in enumerate(("stdin", "stdout", "stderr")):  # as Python begins
            setattr(sys, name, _stream(number))
        main()
    except BaseException:
        os.write(2, traceback.format_exc().encode())
    finally:
        os._exit(70)


def _stream(number: int) -> IO[str] | None:
    try:
        os.fstat(number)
    except OSError:
        return None
    return open(number, "w" if number else "r", closefd=False)


def _redirect(handle: int, path: Path, flags: int) -> None:
    opened = os.open(path, flags, 0o666)
    os.dup2(opened, handle)
    os.close(opened)

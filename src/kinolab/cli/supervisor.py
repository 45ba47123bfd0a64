"""A parent process that kills its child, the command, if Ctrl-C finds it in blocking code.

Python's handlers wait until native code returns, and FCL and OMPL take seconds with a mesh of a
million triangles. A second process does not wait. It is forked before any library is loaded, whose
threads and locks would not survive a fork.

It also survives native code that crashes, and says so. Where several searches were in the process
that crashed, the command is done again with a process for each of them.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from contextlib import suppress
from typing import NoReturn

from kinolab.cli.interrupts import EXIT_CODE, INTERRUPTED, INTERRUPTS, ONE_PRESS, STDERR
from kinolab.concurrency.parent_death import end_with_parent

CRASHES = {
    signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGILL
}  # fmt: skip


def supervise() -> None:
    """Fork and continue in the child, whose signals are handled; the parent does not return.

    The parent exits with the child's exit code, or by the signal that killed it. Signals of native
    code that crashed become a sentence.
    """
    before = signal.signal(signal.SIGCHLD, lambda *_: None)  # if ignored, sigwait would miss it
    heard = {
        signal.SIGCHLD, signal.SIGALRM, signal.SIGINT, signal.SIGTERM,
        signal.SIGHUP, signal.SIGQUIT, signal.SIGTSTP,
    }  # fmt: skip
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, heard)
    parent = os.getpid()
    while child := _forked():
        status = _status_of(child, heard)
        if status is None or not os.WIFSIGNALED(status) or os.WTERMSIG(status) not in CRASHES:
            _leave_like(status)
        crash = signal.Signals(os.WTERMSIG(status))  # of native code
        again = bool(INTERRUPTS.shares_fate[0]) and not INTERRUPTS.after_crash
        _tell_of(crash, again)
        if not again:
            os._exit(70)  # the exit code of a crash
        INTERRUPTS.after_crash = True
        INTERRUPTS.shares_fate[0] = INTERRUPTS.is_writing[0] = 0
    signal.signal(signal.SIGCHLD, before)
    signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    if child == 0:  # it exits when its parent is killed
        if sys.platform == "linux":
            end_with_parent()
        else:
            threading.Thread(target=_leave_after, args=(parent,), daemon=True).start()
        if os.getppid() != parent:  # the parent was already gone
            INTERRUPTS.leave()


def _forked() -> int | None:
    """Fork and return the child's number, 0 in the child; None if there is no room for one."""
    try:
        return os.fork()
    except OSError:
        return None  # Python's handlers must suffice


def _status_of(child: int, heard: set[signal.Signals]) -> int | None:
    """Wait for a process and forward signals to it.

    Returns:
        Its status, as of ``waitpid``; None if it had to be killed after Ctrl-C.
    """
    presses, last, postponed = 0, -ONE_PRESS, False
    while True:
        number = signal.sigwait(heard)
        if number == signal.SIGCHLD:
            gone, status = os.waitpid(child, os.WNOHANG)
            if gone:
                return status
        elif number == signal.SIGALRM:
            if INTERRUPTS.is_writing[0] and not postponed:
                postponed = True
                signal.setitimer(signal.ITIMER_REAL, 1.0)  # [s] more to complete the files of a run
            else:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
                return None
        else:
            os.kill(child, number)
        if number == signal.SIGINT:
            last, since = time.monotonic(), time.monotonic() - last
            presses += since > ONE_PRESS
            if since > ONE_PRESS and presses <= 2:
                # [s] after the first Ctrl-C, or the second one, the child is killed; by then it has
                # exited if it could
                seconds = 0.9 if presses == 1 else 0.2
                signal.setitimer(signal.ITIMER_REAL, seconds)
        elif number == signal.SIGTSTP:
            _raise_signal(number)  # until both are continued
            signal.pthread_sigmask(signal.SIG_BLOCK, {number})
            os.kill(child, signal.SIGCONT)


def _tell_of(crash: signal.Signals, again: bool) -> None:
    """Say that native code crashed, and what follows."""
    what = f"native code crashed ({crash.name})"
    told = (
        f"warning: {what}; each search gets a process of its own now."
        if again
        else (f"error: {what}: a mistake in kinolab or in a library; please report it.")
    )
    with suppress(OSError):
        os.write(STDERR, f"\n{told}\n".encode())


def _leave_like(status: int | None) -> NoReturn:
    """Exit with a child's exit code, or by the signal that killed it."""
    if status is None:
        with suppress(OSError):
            os.write(STDERR, INTERRUPTED)
        os._exit(EXIT_CODE)
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        with suppress(OSError):  # SIGKILL has no handler
            signal.signal(number, signal.SIG_DFL)
        _raise_signal(number)
    os._exit(os.waitstatus_to_exitcode(status))


def _raise_signal(number: int) -> None:
    """Send a blocked signal to this process and unblock it, for its default action."""
    os.kill(os.getpid(), number)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {number})


def _leave_after(parent: int) -> NoReturn:
    while os.getppid() == parent:
        time.sleep(1.0)
    INTERRUPTS.leave()

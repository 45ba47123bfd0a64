"""The end of a process that Ctrl-C finds inside native code which does not let Python run.

Python's handler and every thread of Python wait for the interpreter's lock. FCL and OMPL hold it
while they work, which takes seconds with a mesh of a million triangles. So a few instructions of
machine code set an alarm when the signal comes, and other ones leave when it rings.
"""

from __future__ import annotations

import ctypes
import signal
import sys
from typing import Any

from kinolab.dynamics.codegen.llvm_jit import Library, compile_ir, link

ALARM_SECONDS = 0.8  # [s] after Ctrl-C

HANDLER_CODE = """
@set = internal global i32 0
@words = internal constant [13 x i8] c"\\0Ainterrupted\\0A"
declare i32 @ualarm(i32, i32)
declare i64 @write(i32, ptr, i64)
declare void @_exit(i32)

define void @interrupted(i32 %signal) {{
  %was_set = load i32, ptr @set
  %is_first = icmp eq i32 %was_set, 0
  br i1 %is_first, label %first, label %pass_on
first:
  store i32 1, ptr @set
  %left = call i32 @ualarm(i32 {microseconds}, i32 0)
  br label %pass_on
pass_on:
  %before = inttoptr i64 {handler} to ptr
  call void %before(i32 %signal)
  ret void
}}

define void @ringing(i32 %signal) {{
  %written = call i64 @write(i32 2, ptr @words, i64 13)
  call void @_exit(i32 {exit_code})
  ret void
}}
"""

_kept: list[Library] = []  # the machine code that signals jump to


def arm(exit_code: int) -> None:
    """Leave with an exit code some time after the first Ctrl-C, whatever holds the process.

    Python's own handler stays and is called as before.
    """
    if sys.platform == "win32" or _kept:
        return
    libc: Any = ctypes.CDLL(None)
    libc.signal.argtypes, libc.signal.restype = (ctypes.c_int, ctypes.c_void_p), ctypes.c_void_p
    text = HANDLER_CODE.format(
        microseconds=round(ALARM_SECONDS * 1e6), handler=_handler(libc), exit_code=exit_code
    )
    library = link(compile_ir(text), ("interrupted", "ringing"))
    _kept.append(library)
    libc.signal(signal.SIGALRM, library.address("ringing"))
    libc.signal(signal.SIGINT, library.address("interrupted"))
    signal.siginterrupt(signal.SIGINT, True)  # as Python has it: blocking calls give way


def _handler(libc: Any) -> int:
    """Return the address of Python's own handler in C, with which a ``struct sigaction`` begins."""
    action = (ctypes.c_void_p * 64)()  # larger than that is anywhere
    libc.sigaction(ctypes.c_int(signal.SIGINT), None, action)
    return int(action[0] or 0)


def postpone(seconds: float) -> None:
    """Let an alarm that is set ring some seconds from now, since something is being written."""
    if _kept:
        signal.setitimer(signal.ITIMER_REAL, seconds)

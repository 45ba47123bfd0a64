"""Linux: a process that the kernel kills when its parent ends."""

from __future__ import annotations

import signal

PR_SET_PDEATHSIG = 1  # signal that a process gets when its parent dies


def end_with_parent() -> None:
    """Have this process killed when its parent ends, from now on; Linux only.

    The parent may be gone already: compare ``os.getppid`` with it afterwards.
    """
    from ctypes import CDLL

    CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)

"""Linux: a process that the kernel kills when its parent ends."""

from __future__ import annotations

import signal


def end_with_parent() -> None:
    """Have this process killed when its parent ends, from now on; Linux only.

    The parent may be gone already: compare ``os.getppid`` with it afterwards.
    """
    from ctypes import CDLL

    CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG: the signal when its parent dies

"""Decorators that compile inner loops with numba.

Kernels have no reference counting, which took longer than the loops themselves; so they cannot
allocate and work on the memory they are given. The GIL is released.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from kinolab.numerics.linking import Kernel

OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "nogil": True,
    "nopython": True,
    "boundscheck": None,  # as the environment says
    "no_cfunc_wrapper": True,  # never called from C; the wrappers took a twelfth of compilation
}


allocating_kernel: Any = partial(Kernel, options=OPTIONS)  # around the kernels
kernel: Any = partial(Kernel, options=OPTIONS | {"_nrt": False})

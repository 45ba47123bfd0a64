"""Decorators that compile inner loops with numba.

Kernels have no reference counting, which took longer than the loops themselves; so they cannot
allocate and work on the memory they are given. The GIL is released.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba

from kinolab.numerics.jit_cache import sealed_caches

OPTIONS: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "nogil": True,
    "no_cfunc_wrapper": True,  # never called from C; the wrappers took a twelfth of compilation
}


def compiler(**options: Any) -> Any:
    """Return ``numba.njit`` with these options and a disk cache with checksums."""
    decorate = numba.njit(**options)

    def compiled(function: Callable[..., Any]) -> Any:
        with sealed_caches():
            return decorate(function)

    return compiled


allocating_kernel: Any = compiler(**OPTIONS)  # around the kernels
kernel: Any = compiler(**OPTIONS, _nrt=False)

"""Decorators that compile inner loops with numba.

Kernels have no reference counting, which took longer than the loops themselves; so they cannot
allocate and work on the memory they are given. The GIL is released.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numba

from kinolab.numerics.jit_cache import cache_of

OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "nogil": True,
    "nopython": True,
    "boundscheck": None,  # as the environment says
    "no_cfunc_wrapper": True,  # never called from C; the wrappers took a twelfth of compilation
}


def _plain(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Return numba's own compiled function, which takes longer to compile."""
    made = numba.jit(**options)(function)
    made._cache = cache_of(function)
    return made


if numba.version_info.short == (0, 68):  # with whose insides it works
    from kinolab.numerics.linking import Kernel
else:
    Kernel: Any = _plain  # type: ignore[no-redef]

allocating_kernel: Any = partial(Kernel, options=OPTIONS)  # around the kernels
kernel: Any = partial(Kernel, options=OPTIONS | {"_nrt": False})

"""How inner loops are compiled.

Without reference counts: they took longer than what was counted, and without them nothing can be
allocated, so that a loop works on the memory it is given. The interpreter's lock is released.
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
    "no_cfunc_wrapper": True,  # nobody calls them from C, and a twelfth of compiling went there
}


def compiler(**options: Any) -> Any:
    """Return a decorator that compiles as numba does, and keeps what it compiles with checksums."""
    decorate = numba.njit(**options)

    def compiled(function: Callable[..., Any]) -> Any:
        with sealed_caches():
            return decorate(function)

    return compiled


allocating_kernel: Any = compiler(**OPTIONS)  # around the loops
kernel: Any = compiler(**OPTIONS, _nrt=False)

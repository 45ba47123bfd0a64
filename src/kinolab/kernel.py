"""How inner loops are compiled.

Without reference counts: they took longer than what was counted, and without them nothing can be
allocated, so that a loop works on the memory it is given. The interpreter's lock is released.
"""

from __future__ import annotations

from typing import Any

import numba

OPTIONS: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "nogil": True,
    "no_cfunc_wrapper": True,  # nobody calls them from C, and a twelfth of compiling went there
}

allocating: Any = numba.njit(**OPTIONS)  # around the loops
kernel: Any = numba.njit(**OPTIONS, _nrt=False)

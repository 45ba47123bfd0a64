"""How inner loops are compiled.

Without reference counts: they took longer than what was counted, and without them nothing can be
allocated, so that a loop works on the memory it is given. The interpreter's lock is released.
"""

from __future__ import annotations

from typing import Any

import numba

allocating: Any = numba.njit(cache=True, error_model="numpy", nogil=True)  # around the loops
kernel: Any = numba.njit(cache=True, error_model="numpy", nogil=True, _nrt=False)

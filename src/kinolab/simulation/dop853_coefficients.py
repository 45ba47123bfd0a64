"""The coefficients of DOP853, of order 8, with its error estimates and its dense output: SciPy's.

Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., sections II.5 and II.6; dop853.f.
"""

from __future__ import annotations

from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import scipy

from kinolab.dynamics.codegen.methods import Method
from kinolab.numerics.arrays import Array

STAGES, EXTRA_STAGES = 12, 3


def _scipys() -> Any:
    """Run SciPy's module alone: the package around it imports optimisers, as long as a search."""
    path = Path(scipy.__file__).parent / "integrate/_ivp/dop853_coefficients.py"
    loader = SourceFileLoader(path.stem, str(path))
    module = ModuleType(loader.name)
    loader.exec_module(module)
    return module


_given = _scipys()
A: Array = np.ascontiguousarray(_given.A[:STAGES, :STAGES])  # weights of slopes before each stage
B: Array = np.ascontiguousarray(_given.B)  # weights of the step, (12,)
E3: Array = _given.E3  # error estimate of order 3, (13,)
E5: Array = _given.E5  # error estimate of order 5, (13,)
A_EXTRA: Array = np.ascontiguousarray(_given.A[STAGES + 1 :])  # of the dense output's, (3, 16)
D: Array = _given.D  # dense output, (4, 16)

# without error control
DOP853 = Method(
    "dop853", 8, tuple(B.tolist()), tuple(tuple(A[i, :i].tolist()) for i in range(STAGES))
)

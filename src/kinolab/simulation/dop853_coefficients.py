"""The coefficients of DOP853, of order 8, with its error estimates and its dense output: SciPy's.

Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., sections II.5 and II.6; dop853.f.
"""

from __future__ import annotations

from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

import numpy as np
import scipy

from kinolab.dynamics.codegen.methods import Method
from kinolab.numerics.arrays import Array

STAGES, EXTRA_STAGES = 12, 3


def _scipys() -> tuple[Array, ...]:
    """Run SciPy's module alone: the package around it imports optimisers, as long as a search."""
    path = Path(scipy.__file__).parent / "integrate/_ivp/dop853_coefficients.py"
    if not path.is_file():  # it is a private one
        from scipy.integrate import DOP853

        return DOP853.A, DOP853.A_EXTRA, DOP853.B, DOP853.E3, DOP853.E5, DOP853.D
    loader = SourceFileLoader(path.stem, str(path))
    loader.exec_module(given := ModuleType(loader.name))
    inner, further = given.A[:STAGES, :STAGES], given.A[STAGES + 1 :]
    return inner, further, given.B, given.E3, given.E5, given.D


# Weights of the slopes before each stage (12, 12), before those of the dense output (3, 16), of the
# step (12,), of error estimates of orders 3 and 5 (13,), and of the dense output (4, 16).
A, A_EXTRA, B, E3, E5, D = map(np.ascontiguousarray, _scipys())

# without error control
DOP853 = Method(
    "dop853", 8, tuple(B.tolist()), tuple(tuple(A[i, :i].tolist()) for i in range(STAGES))
)

"""The coefficients of DOP853, against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import DOP853

from kinolab.simulation import dop853_coefficients


@pytest.mark.parametrize("name", ["A", "B", "E3", "E5", "A_EXTRA", "D"])
def test_the_coefficients_are_scipys_to_the_last_bit(name: str) -> None:
    ours, theirs = getattr(dop853_coefficients, name), getattr(DOP853, name)
    assert np.array_equal(ours, theirs)
    assert ours.flags.c_contiguous

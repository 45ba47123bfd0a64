"""Arrays are allocated with the type of numbers that their declaration names."""

from types import GenericAlias
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab.numerics.arrays import allocate

PLAIN = np.ndarray[tuple[Any, ...], np.dtype[np.int64]]  # what NumPy's alias is up to 2.4
NAMED = GenericAlias(list, (np.int64,))  # what it looks like from 2.5 on: its numbers' type alone


@pytest.mark.parametrize("declared", [NDArray[np.int64], PLAIN, NAMED])
def test_arrays_have_the_declared_type(declared: Any) -> None:
    class Table(NamedTuple):
        rows: Annotated[declared, "n", 3]

    made = allocate(Table, {"n": 2})
    assert made.rows.dtype == np.int64
    assert made.rows.shape == (2, 3)

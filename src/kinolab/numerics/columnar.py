"""Tables as dataclasses: each field is a column, an array with one row for every entry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Columns:
    """Base of dataclasses whose fields are arrays of as many rows."""

    def part(self, rows: NDArray[np.generic]) -> Self:
        """Return some of the rows."""
        return type(self)(*(getattr(self, column.name)[rows] for column in fields(self)))

    @classmethod
    def joined(cls, tables: Sequence[Self]) -> Self:
        """Return the rows of several tables, one after the other."""
        names = [column.name for column in fields(cls)]
        return cls(*(np.concatenate([getattr(one, name) for one in tables]) for name in names))

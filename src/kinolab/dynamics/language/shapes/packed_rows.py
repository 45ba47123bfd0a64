"""Tables of numbers as text, for machine files."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def packed(rows: ArrayLike, dtype: str) -> str:
    """Return rows (n, m) in base64, each number as a type of NumPy's such as "<f8"."""
    return base64.b64encode(np.asarray(rows).astype(dtype).tobytes()).decode()


def unpacked(text: str, dtype: str, columns: int = 3) -> NDArray[Any]:
    """Return the rows of ``packed``, shape (n, columns).

    Raises:
        ValueError: If there are none.
    """
    return np.frombuffer(base64.b64decode(text, validate=True), dtype).reshape(-1, columns)

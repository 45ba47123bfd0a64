"""Arrays of a page, packed into one compressed text and addressed by offset."""

from __future__ import annotations

import base64
import gzip
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

Place: TypeAlias = dict[str, Any]

TYPES = {"f4": "<f4", "f8": "<f8", "u2": "<u2", "u4": "<u4"}


class Pack:
    """Collects arrays and returns their offsets."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, array: ArrayLike, type_: str) -> Place:
        """Store an array and return its location, for the page's ``pack.js``.

        Args:
            array: Numbers of any shape.
            type_: One of ``TYPES``; positions are ``f4``, times ``f8``.
        """
        content = np.ascontiguousarray(array, dtype=TYPES[type_])
        place = {"at": self._size, "count": int(content.size), "type": type_}
        data = content.tobytes()
        self._parts.append(data + bytes(-len(data) % 8))  # bytes, as typed arrays require
        self._size += len(self._parts[-1])
        return place

    def indices(self, array: ArrayLike) -> Place:
        """Store non-negative integers, in two bytes each if they fit."""
        numbers = np.asarray(array, dtype=np.int64)
        return self.add(numbers, "u2" if numbers.max(initial=0) < 1 << 16 else "u4")

    def text(self) -> str:
        """Return all arrays as base64 of gzip; the same arrays give the same text."""
        return base64.b64encode(gzip.compress(b"".join(self._parts), 6, mtime=0)).decode()

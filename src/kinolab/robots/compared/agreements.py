"""Files whose machines were found to move as other engines say, which need not be asked again.

MuJoCo and Pinocchio take longer to import than most files to be read.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from kinolab.lazy import versions_of
from kinolab.store import Kind, code_in

PACKAGE = Path(__file__).parents[2]
LIBRARIES = ("yourdfpy", "lxml", "sympy", "numpy", "mujoco", "pin")  # the last is Pinocchio
AGREED: Kind[bytes] = Kind("agreed", bytes, bytes)


def agreement_on(file: bytes, base: str, locked: Mapping[str, float]) -> list[str | bytes]:
    """Return all that determines whether engines agree: the file, how it is read, and by what."""
    code = [code_in(PACKAGE / room) for room in ("robots", "dynamics", "numerics")]
    how = [base, sorted(locked.items()), versions_of(*LIBRARIES)]
    return [file, json.dumps(how), *code]

"""What a run was made on: processor, memory, system, versions and load."""

from __future__ import annotations

import hashlib
import json
import os
import platform
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from kinolab.concurrency.processors import processors
from kinolab.runs.report import versions

MB = 1e6


@cache
def computer() -> dict[str, Any]:
    """Return what figures depend on, and a hash of it: figures with equal ones may be compared."""
    about = {
        "host": platform.node(),
        "processor": _processor(),
        "cores": processors(),
        "memory": round(_memory() / MB),
        "system": f"{platform.system()} {platform.machine()}",
        "versions": json.dumps(versions(), sort_keys=True),
    }
    told = [value for key, value in about.items() if key not in ("host", "memory")]
    return {**about, "computer": hashlib.sha256(repr(told).encode()).hexdigest()[:8]}


def load_average() -> float:
    """Return how many processes wanted a processor in the last minute; NaN where none is told."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _memory() -> float:
    """Return the memory of the computer in bytes; 0 where it is not told."""
    with suppress(AttributeError, OSError, ValueError):
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    return 0.0

"""What a run was made on: processor, system and versions."""

from __future__ import annotations

import hashlib
import json
import platform
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from kinolab.concurrency.processors import processors
from kinolab.runs.report import versions


@cache
def computer() -> dict[str, Any]:
    """Return what figures depend on, and a hash of it: figures with equal ones may be compared."""
    about = {
        "host": platform.node(),
        "processor": processor(),
        "cores": processors(),
        "system": f"{platform.system()} {platform.machine()}",
        "versions": json.dumps(versions(), sort_keys=True),
    }
    told = [value for key, value in about.items() if key != "host"]
    return {**about, "computer": hashlib.sha256(repr(told).encode()).hexdigest()[:8]}


def processor() -> str:
    """Return the name of the processor."""
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()

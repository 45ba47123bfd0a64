"""Processes of kinolab's own: ``python -m versus.NAME``, which print one line of JSON."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

GO = "go\n"  # what a worker waits for that is to begin together with others


def start(name: str, *arguments: object, **variables: str) -> subprocess.Popen[str]:
    """Start a worker with further variables of the environment."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    return subprocess.Popen(
        [sys.executable, "-m", f"versus.{name}", *map(str, arguments)],
        env=environment | variables,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C on a terminal does not reach it
    )


def answer(worker: subprocess.Popen[str]) -> Any:
    """Wait for a worker; return what it printed.

    Raises:
        RuntimeError: If it failed; what it said is on stderr.
    """
    try:
        stdout, _ = worker.communicate()
    except BaseException:
        worker.kill()
        worker.wait()
        raise
    if worker.returncode:
        raise RuntimeError(f"{' '.join(map(str, worker.args[1:]))} failed")  # type: ignore[index]
    return json.loads(stdout)

"""OMPL's side: built with CMake, one process for every search."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from .runs import Entrant, Run
from .verdict import Judge

SOURCES = Path(__file__).resolve().parents[1] / "ompl_cpp"
PACKAGES = (
    *("cmake", "g++", "libompl-dev", "libfcl-dev", "libeigen3-dev", "libode-dev"),
    *("libboost-serialization-dev", "libboost-filesystem-dev", "libboost-system-dev"),
)
MOST, GRACE = 5.0, 60.0  # times the limit of CPU time, and [s] beyond, on a machine that is busy


class MissingError(Exception):
    """OMPL in C++ cannot be built here; the text says what to install."""

    def __init__(self, what: str) -> None:
        super().__init__(f"{what}\nInstall: apt-get install -y {' '.join(PACKAGES)}")


@dataclass(frozen=True)
class Baseline:
    """The program that searches with OMPL."""

    program: Path

    @property
    def version(self) -> str:
        """Versions of OMPL, FCL and the compiler."""
        return self._output(["version"], GRACE).strip()

    def report(
        self, problem: str, planner: str, seed: int, limit: float, sizes: Sequence[int] = ()
    ) -> dict[str, Any]:
        """Search once; return what it says, in ``baseline.cpp``'s words."""
        arguments = [problem, planner, str(seed), str(limit), *map(str, sizes)]
        found: dict[str, Any] = json.loads(self._output(arguments, MOST * limit + GRACE))
        return found

    def search(self, problem: str, judge: Judge, entrant: Entrant, seed: int, limit: float) -> Run:
        """Search once, and judge what was found."""
        found = self.report(problem, entrant.planner, seed, limit)
        u = np.array([held for steps, *held in found.get("motion", []) for _ in range(steps)])
        at_knots = judge.at_knots(u) if found["solved"] else ""
        return Run(
            problem,
            entrant,
            seed,
            **{key: found[key] for key in ("solved", "cpu", "wall", "setup")},
            nodes=found["nodes"],
            propagations=found["propagations"],
            at_knots=at_knots,
            between=judge.between(u) if found["solved"] and not at_knots else "",
            duration=judge.problem.step * len(u),
        )

    def _output(self, arguments: Sequence[str], limit: float) -> str:
        done = subprocess.run(
            [self.program, *arguments],
            capture_output=True,
            text=True,
            timeout=limit,
            check=True,
            start_new_session=True,  # Ctrl-C on a terminal does not reach it
        )
        return done.stdout


def build(folder: Path | None = None) -> Baseline:
    """Build OMPL's side, unless it was built from the same sources before.

    Args:
        folder: Where; a folder of the user's cache when left out.

    Raises:
        MissingError: If a tool or a library is missing.
    """
    for tool in ("cmake", "c++"):
        if shutil.which(tool) is None:
            raise MissingError(f"{tool} is missing, without which OMPL in C++ cannot be built.")
    folder = folder or platformdirs.user_cache_path("kinolab") / f"ompl_cpp_{_digest()}"
    for command in (["-S", str(SOURCES), "-B", str(folder)], ["--build", str(folder)]):
        done = subprocess.run(["cmake", *command], capture_output=True, text=True, check=False)
        if done.returncode:
            said = (done.stderr or done.stdout).strip()
            raise MissingError(f"OMPL in C++ cannot be built:\n{said}")
    return Baseline(folder / "baseline")


def _digest() -> str:
    digest = hashlib.sha256(str(SOURCES).encode())
    for path in sorted(SOURCES.iterdir()):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]

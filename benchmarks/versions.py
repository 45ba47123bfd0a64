"""The maze with the oldest and the newest numba and OMPL that are admitted.

    python benchmarks/versions.py

Each pair has an environment of its own, into which this folder is installed, and caches of its
own. In it `plan rolling_disk_maze` searches, `plan check` proves what was found, and the inputs
that the first pair found are followed by the compiled step. Prints a Markdown table: versions, the
verdict, seconds of the first plan (all loops are compiled) and of the second one, the SHA-256 of
`trajectory.csv`, and the largest difference of the states that are followed, relative to the
largest one. Plans have the same bits for one version of numba only; steps differ by 1e-12 at most.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import numpy as np
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
VARIED = ("numba", "ompl")
SCENARIO = "rolling_disk_maze"
FOLLOW = f"""
import sys
import numpy as np
import kinolab
from kinolab.simulation.machine import states_under
np.save(sys.argv[2], states_under(kinolab.load({SCENARIO!r}), np.load(sys.argv[1])["u"]))
"""
VERSIONS = f"from importlib.metadata import version; print(*map(version, {VARIED!r}))"


def oldest() -> list[str]:
    """Return requirements that admit nothing but the lowest versions."""
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    wanted = [Requirement(entry) for entry in listed]
    return [
        f"{entry.name}=={bound.version}"
        for entry in wanted
        for bound in entry.specifier
        if entry.name in VARIED and bound.operator in (">=", "==")
    ]


class Environment:
    """A new environment with kinolab in it, below a folder that will be removed."""

    def __init__(self, folder: Path, pinned: list[str]) -> None:
        self.folder = folder
        subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
        self._bin = folder / "venv" / "bin"
        self.run("pip", "install", "-q", ROOT, *pinned)

    def run(self, command: str, *arguments: object) -> str:
        """Run a command of it; return what it prints."""
        caches = {"NUMBA_CACHE_DIR": "numba", "KINOLAB_CACHE": "kinolab"}
        own = {name: str(self.folder / place) for name, place in caches.items()}
        line = [str(self._bin / command), *map(str, arguments)]
        done = subprocess.run(
            line, env=os.environ | own, cwd=self.folder, capture_output=True, text=True, check=False
        )
        return done.stdout if done.returncode == 0 else f"exit code {done.returncode}"

    def plan(self) -> float:
        """Plan; return the seconds that it takes."""
        begun = time.monotonic()
        self.run("plan", SCENARIO, "--quiet", "--seed", "1", "--out", "run")
        return time.monotonic() - begun


def main() -> None:
    """Print the table."""
    print("| numba, OMPL | checked | first [s] | second [s] | SHA-256 | steps differ by |")
    print("| --- | --- | ---: | ---: | --- | ---: |")
    with tempfile.TemporaryDirectory() as place:
        known: list[np.ndarray] = []
        for name, pinned in (("oldest", oldest()), ("newest", [])):
            made = Environment(Path(place, name), pinned)
            first, second = made.plan(), made.plan()
            verdict = made.run("plan", "check", "run").partition("\n")[0]
            digest = hashlib.sha256((made.folder / "run" / "trajectory.csv").read_bytes())
            made.run("python", "-c", FOLLOW, Path(place, "oldest/run/trajectory.npz"), "x.npy")
            known.append(np.load(made.folder / "x.npy"))
            apart = np.abs(known[-1] - known[0]).max() / np.abs(known[0]).max()
            versions = ", ".join(made.run("python", "-c", VERSIONS).split())
            cells = f"{first:.0f} | {second:.0f} | {digest.hexdigest()[:12]} | {apart:.1e}"
            print(f"| {versions} | {verdict} | {cells} |", flush=True)


if __name__ == "__main__":
    main()

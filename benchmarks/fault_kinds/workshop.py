"""Where faults are tried: commands, their undisturbed results, and what is counted of faults."""

from __future__ import annotations

import importlib
import json
import random
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import sandbox
from .sandbox import Ended
from .whole_files import broken, drafts

SCENARIO = "rolling_disk_maze"
PLAN = (SCENARIO, "--no-optimize", "--no-animation")
IMPROVED = (SCENARIO, "--no-animation", "--set", "planner.improve=0.2")
LIMIT = 120.0  # [s] for a command; the machine may be busy
NAMES = """
import sys
sys.argv = ["plan", *sys.argv[2:]]
from kinolab.cli import run
code = run()
with open(sys.orig_argv[3], "a") as file:
    file.write("\\n".join(sys.modules) + "\\n")
sys.exit(code)
"""  # runs a command and notes what it imported


@dataclass
class Verdict:
    """What became of one fault.

    Attributes:
        what: The fault, so that it can be told.
        seconds: How long the command took that it struck.
        tracebacks: Of all commands.
        partial: Files that are not whole, and temporary ones that the next run left.
        wrong: What else is not as promised.
        late: Commands beyond their time, and processes left over.
        codes: Exit codes of all commands.
    """

    what: str
    seconds: float = 0.0
    tracebacks: int = 0
    partial: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    late: int = 0
    codes: list[int | None] = field(default_factory=list)

    @property
    def sound(self) -> bool:
        """Whether everything is as promised."""
        return not (self.tracebacks or self.partial or self.wrong or self.late)

    def heard(self, ended: Ended, codes: Sequence[int] | None = None, limit: float = LIMIT) -> None:
        """Count what is seen of a command that has ended.

        Args:
            ended: The command.
            codes: Exit codes that are right; None for any.
            limit: Its time in [s].
        """
        self.codes.append(ended.code)
        self.tracebacks += ended.traceback
        self.late += (ended.code is None or ended.seconds > limit) + ended.orphans
        if ended.traceback:
            self.wrong.append(ended.err[-2000:])
        if codes is not None and ended.code not in codes:
            self.wrong.append(f"exit code {ended.code}, not {codes}: {ended.err[-600:]}")
        if ended.orphans:
            self.wrong.append(f"{ended.orphans} processes left")

    def files(self, folder: Path, *, settled: bool) -> None:
        """Count files that are not whole; temporary ones where nothing was struck since."""
        self.partial += broken(folder)
        if settled:
            self.partial += [f"temporary: {path}" for path in drafts(folder)]


@dataclass
class Workshop:
    """The folder that faults are tried in.

    Attributes:
        place: Of everything.
    """

    place: Path

    def run(self, *arguments: str | bytes | Path, limit: float = LIMIT, **further: Any) -> Ended:
        """Run a command in a process that was forked."""
        return sandbox.run(arguments, self.place, self.place / "scratch", limit, **further)

    def start(self, *arguments: str | bytes | Path, **further: Any) -> sandbox.Command:
        """Start a command in a process that was forked."""
        return sandbox.start(arguments, self.place, self.place / "scratch", **further)

    def empty(self, name: str) -> Path:
        """Return a folder's name, without a folder of it."""
        path = self.place / name
        remove(path)
        return path

    def copy(self, name: str) -> Path:
        """Return a copy of a run."""
        folder = self.empty(name)
        shutil.copytree(self.done(1), folder)
        return folder

    def done(self, seed: int, words: tuple[str, ...] = PLAN) -> Path:
        """Return the folder of an undisturbed run."""
        return _done(self, seed, words)

    def compare(
        self, verdict: Verdict, folder: Path, seed: int, words: tuple[str, ...] = PLAN
    ) -> None:
        """Hold a run against an undisturbed one: its motion and its report, but for times."""
        wanted = self.done(seed, words)
        for name in ("trajectory.csv", "scenario.toml", "assets/machine.json"):
            with suppress(OSError):
                if (folder / name).read_bytes() == (wanted / name).read_bytes():
                    continue
            verdict.wrong.append(f"{name} differs from an undisturbed run's")
        told, other = (_timeless(one / "report.json") for one in (folder, wanted))
        if told != other:
            keys = [key for key in {*told, *other} if told.get(key) != other.get(key)]
            verdict.wrong.append(f"report.json differs from an undisturbed run's in {keys}")

    def load(self, commands: Sequence[Sequence[str | Path]]) -> None:
        """Import what commands import, so that processes forked from this one have it."""
        names = self.empty("imports")
        for words in commands:
            ran = subprocess.run(
                [sys.executable, "-c", NAMES, names, *words],
                cwd=self.place, check=False, capture_output=True, text=True,
            )  # fmt: skip
            if ran.returncode:
                raise SystemExit(f"{words}: {ran.stderr}")
        for name in dict.fromkeys(names.read_text().split()):
            if not name.startswith("__mp"):
                importlib.import_module(name)


def remove(path: Path) -> None:
    """Remove a file or folder, or nothing."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _timeless(path: Path) -> dict[str, Any]:
    """Return what a report says, but for times."""
    try:
        report = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    attempts = [{**one, "after": 0.0} for one in report["attempts"]]
    return {**report, "attempts": attempts, "timings": {}, "improvements": [], "scenario_file": ""}


_known: dict[tuple[int, tuple[str, ...]], Path] = {}


def _done(shop: Workshop, seed: int, words: tuple[str, ...]) -> Path:
    if (seed, words) not in _known:
        folder = shop.empty(f"undisturbed-{len(_known)}")
        ended = shop.run(*words, "--seed", str(seed), "--out", folder)
        if ended.code:
            raise SystemExit(f"{words}, seed {seed}: {ended.err}")
        _known[seed, words] = folder
    return _known[seed, words]


@dataclass(frozen=True)
class Kind:
    """A kind of faults.

    Attributes:
        name: As in the table.
        count: How many there are.
        strike: Makes one of them, from random numbers that follow from its number.
        cold: Whether compiled loops must not be in memory yet.
    """

    name: str
    count: int
    strike: Callable[[Workshop, random.Random], Verdict]
    cold: bool = False

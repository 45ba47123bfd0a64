"""The authors' own package, dynobench 0.0.4: its files, and its answers to questions.

It is looked up by its metadata, for a script that is called dynobench, too, would be found first.
"""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

REASON = "dynobench==0.0.4 is not installed: it comes with [test] on CPython 3.11 for Linux x86-64"
SECONDS = 60.0  # of one question
HANGS = 8  # states at which it may hang before the rest is not asked for


def folder() -> Path | None:
    """Return where the package is, None where it is not installed."""
    try:
        return Path(str(distribution("dynobench").locate_file("dynobench")))
    except PackageNotFoundError:
        return None


def ask(question: str, robot: str, file: Path, **given: Array | float) -> dict[str, Array]:
    """Put a question to ``official.py`` and return the arrays of its answer."""
    with TemporaryDirectory() as place:
        inputs, outputs = Path(place, "in.npz"), Path(place, "out.npz")
        np.savez(inputs, **{name: np.asarray(value) for name, value in given.items()})
        subprocess.run(
            _command(question, robot, file, inputs, outputs),
            stdout=subprocess.DEVNULL,
            timeout=SECONDS,
            check=True,
        )
        return dict(np.load(outputs))


def measures(
    robot: str, file: Path, x: Array, u: Array, dt: float, start: Array, goal: Array
) -> dict[str, float]:
    """Return what the benchmark judges a trajectory by (``Trajectory::check``), but collisions.

    Args:
        robot: Stem of the model's file.
        file: Of the environment.
        x: States, shape (N+1, nx), circles in [-pi, pi).
        u: Inputs, shape (N, nu).
        dt: Step in [s].
        start: Where it must begin, shape (nx,).
        goal: Where it must end, shape (nx,).

    Returns:
        ``start`` and ``goal``, distances; ``jump``, the largest distance between a state and what
        the one before leads to; ``states`` and ``actions``, by how much limits are passed.
    """
    ends = {"start": start, "goal": goal, "dt": dt}
    answer = ask("check", robot, file, states=x, actions=u, **ends)
    return {key: float(value) for key, value in answer.items()}


def depth(robot: str, file: Path, states: Array) -> float:
    """Return the deepest overlap in [m] of some states, NaN where FCL has no answer."""
    return float(-room(robot, file, states).min())


def room(robot: str, file: Path, states: Array) -> Array:
    """Return the signed distance to obstacles in [m] of each state; NaN where FCL fails.

    A process that is stuck ends itself, and another one goes on with the next state.
    """
    found: list[float] = []
    hangs = 0
    while len(found) < len(states) and hangs < HANGS:
        rows, stuck = _room_until_stuck(robot, file, states[len(found) :])
        found += rows
        hangs += stuck
    return np.array(found + [float("nan")] * (len(states) - len(found)))


def _room_until_stuck(robot: str, file: Path, states: Array) -> tuple[list[float], bool]:
    """Return the answers until it hangs, and whether it did; that is NaN."""
    with TemporaryDirectory() as place:
        inputs, outputs = Path(place, "in.npz"), Path(place, "out.txt")
        np.savez(inputs, x=states)
        outputs.touch()
        command = _command("room", robot, file, inputs, outputs)
        ended = subprocess.run(command, stdout=subprocess.DEVNULL, timeout=SECONDS, check=False)
        rows = [float(line) for line in outputs.read_text().splitlines()]
    stuck = ended.returncode != 0
    return [*rows, float("nan")] if stuck and len(rows) < len(states) else rows, stuck


def _command(question: str, robot: str, file: Path, inputs: Path, outputs: Path) -> list[str]:
    script = Path(__file__).with_name("official.py")
    return [sys.executable, "-E", *map(str, (script, question, robot, file, inputs, outputs))]

"""What several end-to-end tests need: scenarios as text, the command line, a limit on time."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import kinolab
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate
from tests.oracles.rolling_disk import Coin, accelerations

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[1]
ENTER = "from kinolab.cli import main; main()"

OPEN = """\
schema = 1
title = "A coin on a table"

[system]
name = "rolling_disk"

[world]
bounds = { x = [-5, 5], y = [-5, 5] }
ground = "plane"

[start]
x = -1.0

[goal]
x = 0.0
y = 0.0
tolerance = 0.5

[planner]
name = "rrt"
time_limit = 20.0
improve = 0
"""

WALL = """
[[world.obstacle]]
name = "wall"
box = [0.1, 4.0, 1.0]
position = [3.0, 0.0, 0.5]
"""


def needs(*libraries: str) -> pytest.MarkDecorator:
    """Skip a test where a library is missing that only extras of the installation bring."""
    missing = [name for name in libraries if find_spec(name) is None]
    return pytest.mark.skipif(bool(missing), reason=f"needs {', '.join(missing)}")


def environment(**extra: str) -> dict[str, str]:
    """Return an environment in which any working folder finds the kinolab under test."""
    home = str(Path(str(kinolab.__file__)).absolute().parents[1])  # of links, in an editable one
    return {**os.environ, "PYTHONPATH": home, **extra}


def plan(
    *arguments: str | Path, cwd: Path, timeout: float = 120.0, **extra: str
) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", ENTER, *map(str, arguments)],
        cwd=cwd,
        env=environment(**extra),
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


def started(*arguments: str | Path, cwd: Path) -> subprocess.Popen[str]:
    """Start the command line and return at once."""
    return subprocess.Popen(
        [sys.executable, "-c", ENTER, *map(str, arguments)],
        cwd=cwd,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def problem_of(
    folder: Path, text: str, *overrides: str, name: str = "table.toml"
) -> kinolab.Problem:
    """Write a scenario into a folder and load it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(text, encoding="utf-8")
    return kinolab.load(folder / name, overrides=overrides)


def coin_motion(start: Sequence[float], t: Array, u: Array) -> Trajectory:
    """Return the motion of the coin in closed form, exact to rounding.

    Heading and roll are quadratic in time; the path is a Gauss-Legendre quadrature of 20 points
    per interval, which is exact to rounding for turns of up to about 2 rad in it.
    """
    states = [np.asarray(start, dtype=float)]
    for k, held in enumerate(u):
        states.append(coin_after(states[-1], held, np.array([t[k + 1] - t[k]]))[0])
    names = ("x", "y", "psi", "phi", "psi_dot", "phi_dot")
    return Trajectory(np.asarray(t, dtype=float), np.array(states), u, names, ("drive", "steer"))


def coin_after(x: Array, u: Array, durations: Array) -> Array:
    """Return the states after some durations under constant torques, shape (durations, 6)."""
    coin = Coin()
    a, b = accelerations(x, u, coin)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    tau = durations[:, None] * (nodes + 1) / 2  # (durations, nodes)
    psi = x[2] + x[4] * tau + a * tau**2 / 2
    ahead = coin.R * (x[5] + b * tau) * (durations[:, None] * weights / 2)
    s = durations
    return np.column_stack(
        [
            x[0] + (ahead * np.cos(psi)).sum(axis=1),
            x[1] + (ahead * np.sin(psi)).sum(axis=1),
            x[2] + x[4] * s + a * s**2 / 2,
            x[3] + x[5] * s + b * s**2 / 2,
            x[4] + a * s,
            x[5] + b * s,
        ]
    )


def failed(certificate: Certificate) -> set[str]:
    """Return the names of the checks that failed."""
    return {check.name for check in certificate.failures}


def detail(certificate: Certificate, name: str) -> str:
    """Return what a check says."""
    return next(check.detail for check in certificate.checks if check.name == name)


def time_in(text: str) -> float:
    """Return the time in [s] that a check's words give."""
    found = re.search(r"at t = ([0-9.e+-]+) s", text)
    assert found, f"no time in {text!r}"
    return float(found[1])


@contextmanager
def within(seconds: int) -> Iterator[None]:
    """Raise TimeoutError where the block takes longer, so that a hang is a failure."""

    def late(*_: Any) -> None:
        raise TimeoutError(f"not done after {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)

"""The benchmark's own package, if it is installed: its files, and its answers to questions."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]

SPEC = find_spec("dynobench")
FOLDER = Path(str(SPEC.origin)).parent if SPEC else Path("absent")
REASON = "dynobench==0.0.4 is not installed: it comes with [test] on CPython 3.11 for Linux x86-64"
needs_wheel = pytest.mark.skipif(SPEC is None, reason=REASON)

SECONDS = 60.0  # of one question

MACHINES = {
    "unicycle1_v0": "unicycle1_v0/bugtrap_0",
    "unicycle1_v1": "unicycle1_v1/kink_0",
    "unicycle1_v2": "unicycle1_v2/wall_0",
    "unicycle2_v0": "unicycle2_v0/bugtrap_0",
    "car1_v0": "car1_v0/bugtrap_0",
    "acrobot_v0": "acrobot_v0/swing_up_obs",
    "quad2d_v0": "quad2d_v0/quad_bugtrap",
    "quad2dpole_v0": "quad2dpole_v0/window",
    "quad3d_v0": "quadrotor_v0/window",
    "quad3d_omplapp": "quadrotor_v1/window",
}  # and an environment of each

FOLDERS = {**{name: name for name in MACHINES}, "quad3d_v0": "quadrotor_v0"}
FOLDERS["quad3d_omplapp"] = "quadrotor_v1"
ENVIRONMENTS = sorted(
    f"{folder}/{file.stem}"
    for folder in FOLDERS.values()
    for file in (FOLDER / "envs" / folder).glob("*.yaml")
    if file.stem != "empty"  # a world without a robot
)


def environment(name: str) -> Path:
    """Return the file of an environment, such as ``car1_v0/kink_0``."""
    return FOLDER / "envs" / f"{name}.yaml"


def ask(question: str, robot: str, file: Path, **given: Array | float) -> dict[str, Array]:
    """Put a question to ``official.py`` and return the arrays of its answer."""
    with TemporaryDirectory() as folder:
        inputs, outputs = Path(folder, "in.npz"), Path(folder, "out.npz")
        np.savez(inputs, **{name: np.asarray(value) for name, value in given.items()})
        subprocess.run(
            _command(question, robot, file, inputs, outputs),
            stdout=subprocess.DEVNULL,
            timeout=SECONDS,
            check=True,
        )
        return dict(np.load(outputs))


def _command(question: str, robot: str, file: Path, inputs: Path, outputs: Path) -> list[str]:
    script = Path(__file__).with_name("official.py")
    return [sys.executable, *map(str, (script, question, robot, file, inputs, outputs))]


def room(robot: str, file: Path, states: Array) -> Array:
    """Return the signed distance to obstacles in [m] of each state; NaN where FCL fails.

    A process that is stuck ends itself, and another one goes on with the next state.
    """
    found: list[float] = []
    while len(found) < len(states):
        found += _room_until_stuck(robot, file, states[len(found) :])
    return np.array(found)


def _room_until_stuck(robot: str, file: Path, states: Array) -> list[float]:
    with TemporaryDirectory() as folder:
        inputs, outputs = Path(folder, "in.npz"), Path(folder, "out.txt")
        np.savez(inputs, x=states)
        outputs.touch()
        command = _command("room", robot, file, inputs, outputs)
        subprocess.run(command, stdout=subprocess.DEVNULL, timeout=SECONDS, check=False)
        rows = [float(line) for line in outputs.read_text().splitlines()]
    return rows if len(rows) == len(states) else [*rows, float("nan")]

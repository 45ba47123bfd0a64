"""The benchmark's own package, if it is installed: its environments, and its answers."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.dynobench_study.wheel import REASON, ask, depth, folder, measures, room

__all__ = [
    "ENVIRONMENTS",
    "MACHINES",
    "ask",
    "depth",
    "environment",
    "measures",
    "needs_wheel",
    "room",
]

FOLDER = folder() or Path("absent")
needs_wheel = pytest.mark.skipif(not FOLDER.exists(), reason=REASON)

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

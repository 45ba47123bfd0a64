"""The coin that rolls through the maze, with a limit on the friction that its rim can give."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import kinolab
from kinolab.dynamics import (
    Body,
    Disk,
    PlaneCurves,
    System,
    Torque,
    angle,
    force_of,
    length,
    move,
    parameter,
    rate,
    require,
    rot_y,
    rot_z,
    velocity,
    zero,
)
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.problem import PlanningTask
from tests.support import ROOT

Array = NDArray[np.float64]

MASS, RADIUS, FRICTION, GRAVITY = 1.0, 0.25, 0.4, 9.81


def gripping_coin() -> System:
    """README's coin, whose constraint forces stay within the circle of friction."""
    m, R = parameter("m", MASS, "kg"), parameter("R", RADIUS, "m")
    x, y = length("x"), length("y")
    psi, phi = angle("psi", speed=4.0), angle("phi", speed=12.0)
    fork = move(x, y, R) @ rot_z(psi)
    coin = Body(
        "coin",
        fork @ rot_y(phi),
        mass=m,
        touches_ground=True,
        inertia=(m * R**2 / 4, m * R**2 / 2, m * R**2 / 4),
        shape=Disk(R, thickness=0.05, axis="y"),
    )
    V = velocity(fork)
    side, roll = zero(V.y, "no sideslip"), zero(V.x - R * rate(phi), "rolling")
    grip = (FRICTION * m * GRAVITY) ** 2 - force_of(side) ** 2 - force_of(roll) ** 2
    return System(
        "gripping_coin",
        bodies=[coin],
        constraints=[side, roll],
        inputs=[
            Torque("drive", on=coin, about=fork.y, limit=1.0),
            Torque("steer", on=coin, about=fork.z, limit=0.5),
        ],
        flat=PlaneCurves(x, y, psi),
        requirements=[require(grip, "the rim grips")],
    )


def grip(x: Array, u: Array) -> Array:
    """Return what is left of the squared friction in [N^2], in closed form.

    Sideways the rim gives m v psi_dot; along its way m a, and a = drive / (3/2 m R).

    Args:
        x: States (m, 6): x, y, psi, phi, psi_dot, phi_dot.
        u: Inputs (m, 2): drive, steer.
    """
    sideways = MASS * RADIUS * x[:, 5] * x[:, 4]
    along = u[:, 0] / (1.5 * RADIUS)
    return np.asarray((FRICTION * MASS * GRAVITY) ** 2 - sideways**2 - along**2)


def gripping_maze(folder: Path, *overrides: str) -> PlanningTask:
    """Return the maze of README with that coin."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copytree(ROOT / "scenarios" / "meshes", folder / "meshes", dirs_exist_ok=True)
    (folder / "machine.json").write_text(machine_to_json(gripping_coin()), encoding="utf-8")
    text = (ROOT / "scenarios" / "rolling_disk_maze.toml").read_text(encoding="utf-8")
    text = text.replace('name = "rolling_disk"\n', 'file = "machine.json"\n')
    (folder / "maze.toml").write_text(text, encoding="utf-8")
    return kinolab.load(folder / "maze.toml", overrides=overrides)

"""Plans that fail when they are executed, each for a reason that was built in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import kinolab
from kinolab.analyze.execute.conditions import Conditions
from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Disk,
    Force,
    Mode,
    Rate,
    Sphere,
    System,
    Torque,
    Transition,
    Viscous,
    Wrench,
    angle,
    lag,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.trajectory import Trajectory
from tests.feedback_machines import cart_pole

STEP = 0.05  # [s]
AHEAD = np.repeat([[1.0], [-1.0]], 20, axis=0)  # pushed for a second, braked for a second: 1 m
SETTLED = np.vstack([AHEAD, np.zeros((20, 1))])  # and a second to correct
WALL = '[[world.obstacle]]\nname = "wall"\nbox = [0.1, 1.0, 2.0]\nposition = [{}, 0.0, 1.0]\n'


@dataclass(frozen=True)
class FailingPlan:
    """A plan, what differs from it, and how the reason must be named.

    Attributes:
        system: The machine.
        scenario: What follows ``[system]``.
        conditions: What differs.
        summary: What the summary must say.
        diagnosis: What the diagnosis must say; nothing if the summary says all.
        u: Inputs of the plan, one row per step.
        options: Of the executor.
    """

    system: System
    scenario: str
    conditions: Conditions
    summary: str
    diagnosis: str = ""
    u: Any = field(default_factory=lambda: SETTLED)
    options: dict[str, Any] = field(default_factory=dict)

    def made(self, folder: Path) -> tuple[PlanningTask, Trajectory]:
        """Return the problem, and the motion that its inputs lead to as planned."""
        (folder / "machine.json").write_text(machine_to_json(self.system))
        head = 'schema = 1\ntitle = "t"\n[system]\nfile = "machine.json"\n'
        tail = f"[integration]\nstep = {STEP}\n"
        (folder / "plan.toml").write_text(f"{head}{self.scenario}{tail}")
        problem = kinolab.load(folder / "plan.toml", check=False)
        return problem, resimulate(problem, STEP * np.arange(len(self.u) + 1), self.u)


def carriage(
    *, shape: object = None, height: object = 0.3, limit: float = 2.0, resting: bool = False
) -> System:
    """A box on rails along x, of 1 kg, with drag that a plan does not know."""
    x = length("x", speed=4.0)
    m, c, r = parameter("m", 1.0, "kg"), parameter("c", 0.0, "N s/m"), parameter("r", 0.3, "m")
    place = r if height == "r" else height
    size = Sphere(r) if shape == "r" else (shape or Box(0.4, 0.3, 0.2))
    box = Body("box", move(x, 0, place), mass=m, shape=size, touches_ground=resting)
    push = Force("push", on=box, along=move(x).x, limit=limit)
    return System("carriage", bodies=[box], inputs=[push], efforts=[Viscous(rate(x), c)])

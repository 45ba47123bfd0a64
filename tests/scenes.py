"""Small scenes: a machine in the open, or among a few boxes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from kinolab.problem import PlanningTask
from tests.support import OPEN, problem_of

Array = NDArray[np.float64]

CAR = """\
schema = 1
title = "A car on a yard"
[system]
name = "car"
[world]
bounds = { x = [-30, 30], y = [-30, 30] }
ground = "plane"
[start]
x = -5.0
[goal]
x = 5.0
y = 3.0
psi = 0.5
at_rest = true
tolerance = 0.2
[bounds]
phi_dot = [-5.0, 5.0]
[integration]
step = 0.1
[planner]
improve = 0
name = "prm"
time_limit = 20.0
"""

DRIVE = """\
schema = 1
title = "A robot in a yard"
[system]
name = "diff_drive"
[world]
bounds = { x = [-5, 5], y = [-5, 5] }
ground = "plane"
[start]
x = -2.0
[goal]
x = 2.0
y = 0.0
at_rest = true
tolerance = 0.1
[integration]
step = 0.1
[planner]
improve = 0
name = "prm"
time_limit = 20.0
"""

CRANE = """\
schema = 1
title = "A crane over an empty floor"
[system]
name = "crane"
[world]
bounds = { x = [1, 23], y = [1, 13] }
ground = "plane"
[start]
x = 3.0
y = 3.0
l = 5.0
[goal]
x = 12.0
y = 8.0
l = 6.0
theta_x = 0.0
theta_y = 0.0
at_rest = true
tolerance = 0.1
[integration]
step = 0.25
[planner]
improve = 0
name = "prm"
time_limit = 20.0
"""

PENDULUM = """\
schema = 1
title = "A pendulum"
[system]
name = "pendulum"
[goal]
theta = 3.141592653589793
at_rest = true
tolerance = 0.1
[integration]
step = 0.05
[planner]
improve = 0
name = "prm"
time_limit = 20.0
"""

TWO_CRANES = """\
schema = 1
title = "Two cranes in an empty hall"
[system]
name = "two_cranes"
[world]
bounds = { x = [0, 12], z = [0, 7] }
[start]
x_a = 1.5
l_a = 4.0
x_b = 10.5
l_b = 4.0
[goal]
x_a = 3.0
l_a = 4.0
sway_a = 0.0
x_b = 9.0
l_b = 4.0
sway_b = 0.0
at_rest = true
tolerance = 0.1
[integration]
step = 0.1
[planner]
improve = 0
name = "prm"
time_limit = 20.0
"""

SUBMARINE = """\
schema = 1
title = "A submarine in open water"
[system]
name = "submarine"
[world]
bounds = { x = [-10, 10], y = [-10, 10], z = [-10, 10] }
[start]
x = -2.0
[goal]
x = 2.0
R = [0, 0, 0, 1]
at_rest = true
tolerance = 0.2
[integration]
step = 0.2
[planner]
improve = 0
name = "prm"
time_limit = 20.0
"""

MADE = """\
schema = 1
title = "A machine made for a test"
[system]
file = "machines.py:{name}"
[goal]
x = 1.0
at_rest = true
tolerance = 0.1
[integration]
step = 0.1
[planner]
improve = 0
name = "prm"
time_limit = 20.0
"""

MACHINES = """\
from kinolab.dynamics import Body, Box, Cylinder, Force, PlaneCurves, Sphere, Spring, System
from kinolab.dynamics import Torque, angle, length, move, rot_z, toward

def cart():
    x = length("x", -10, 10, speed=5.0)
    frame = move(x)
    body = Body("cart", frame, mass=1.0, shape=Sphere(0.1))
    return System("cart", bodies=[body], inputs=[Force("push", on=body, along=frame.x, limit=1.0)])

def wagons():
    x, y = length("x", -10, 10, speed=5.0), length("y", -10, 10, speed=5.0)
    frames = move(x), move(y, 1)
    bodies = [Body(n, f, mass=m, shape=Sphere(0.1))
              for n, f, m in zip("ab", frames, (1.0, 2.0), strict=True)]
    return System("wagons", bodies=bodies, efforts=[Spring(between=frames, stiffness=3.0)],
                  inputs=[Force("push", on=bodies[0], along=frames[0].x, limit=5.0)])

def puck():
    x, y = length("x", -5, 5, speed=2.0), length("y", -5, 5, speed=2.0)
    psi = angle("psi", speed=3.0)
    hull = move(x, y) @ rot_z(psi)
    body = Body("puck", hull, mass=1.0, inertia=0.1, shape=Cylinder(0.2, 0.1))
    return System("puck", bodies=[body], inputs=[
        Force("thrust", on=body, along=hull.x, limit=1.0),
        Torque("turn", on=body, about=hull.z, limit=0.5)])

def lift(limit=20.0):
    x, z = length("x", -5, 5, speed=2.0), length("z", -5, 5, speed=2.0)
    frame = move(x, 0, z)
    body = Body("lift", frame, mass=1.0, shape=Sphere(0.1))
    return System("lift", bodies=[body], gravity=toward("-z", 10.0), inputs=[
        Force("aside", on=body, along=frame.x, limit=1.0),
        Force("up", on=body, along=frame.z, limit=limit)])

def weak_lift():
    return lift(10.1)

def stone():
    x, z = length("x", -5, 5, speed=2.0), length("z", -5, 5, speed=2.0)
    frame = move(x, 0, z)
    body = Body("stone", frame, mass=1.0, shape=Sphere(0.1))
    return System("stone", bodies=[body], gravity=toward("-z", 10.0), inputs=[
        Force("aside", on=body, along=frame.x, limit=1.0)])
"""

SCENES = {
    "car": CAR,
    "coin": OPEN,
    "crane": CRANE,
    "drive": DRIVE,
    "pendulum": PENDULUM,
    "submarine": SUBMARINE,
    "two_cranes": TWO_CRANES,
}


def scene(folder: Path, name: str, *overrides: str, text: str = "") -> PlanningTask:
    """Return one of the scenes, or one with a machine made here."""
    if name in SCENES:
        return problem_of(folder, SCENES[name] + text, *overrides)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "machines.py").write_text(MACHINES, encoding="utf-8")
    return problem_of(folder, MADE.format(name=name) + text, *overrides)


def true_states(problem: PlanningTask, x0: Array, u: Array) -> Array:
    """Return the states at the knots by SciPy's DOP853, shape (N+1, nx)."""
    states = [np.asarray(x0, dtype=float)]
    for held in u:
        found = solve_ivp(
            lambda _, x, held=held: problem.model.f(x, held),
            (0.0, problem.step),
            states[-1],
            "DOP853",
            rtol=1e-10,
            atol=1e-12,
        )
        states.append(found.y[:, -1])
    return np.array(states)


def apart(problem: PlanningTask, a: Array, b: Array) -> Array:
    """Return the differences of states in units of their scales, angles on the circle."""
    difference = np.asarray(a) - np.asarray(b)
    wrapped = (difference + np.pi) % (2 * np.pi) - np.pi
    return np.abs(np.where(problem.circular, wrapped, difference)) / problem.scales


WALL = """
[[world.obstacle]]
name = "wall"
box = [0.2, 3.0, 1.0]
position = [0.0, 0.0, 0.5]
"""

# A room without a door around the goal of DRIVE, 2 m wide.
ROOM = "".join(
    f"""
[[world.obstacle]]
name = "{name}"
box = {size}
position = {position}
"""
    for name, size, position in (
        ("west", [0.1, 2.0, 1.0], [1.0, 0.0, 0.5]),
        ("east", [0.1, 2.0, 1.0], [3.0, 0.0, 0.5]),
        ("south", [2.0, 0.1, 1.0], [2.0, -1.0, 0.5]),
        ("north", [2.0, 0.1, 1.0], [2.0, 1.0, 0.5]),
    )
)

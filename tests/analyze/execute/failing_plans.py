"""Plans that fail when they are executed, each for a reason that was built in."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import kinolab
from kinolab.analyze.execute.conditions import Conditions
from kinolab.dynamics import (
    Body,
    Box,
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
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    toward,
    zero,
)
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
        runs: How many; more where it takes two parameters to fail.
    """

    system: System
    scenario: str
    conditions: Conditions
    summary: str
    diagnosis: str = ""
    u: Any = field(default_factory=lambda: SETTLED)
    options: dict[str, Any] = field(default_factory=dict)
    runs: int = 12

    def made(self) -> tuple[PlanningTask, Trajectory]:
        """Return the problem, and the motion that its inputs lead to as planned."""
        table = tomllib.loads(f"[integration]\nstep = {STEP}\n{self.scenario}")
        problem = kinolab.load({"system": self.system, **table})
        return problem, resimulate(problem, STEP * np.arange(len(self.u) + 1), np.array(self.u))


def carriage(
    *, shape: object = None, height: object = 0.3, limit: float = 2.0, resting: bool = False
) -> System:
    """A box on rails along x, of 1 kg, with drag that a plan does not know."""
    x = length("x", -9.0, 9.0, speed=4.0)
    m, c, r = parameter("m", 1.0, "kg"), parameter("c", 0.0, "N s/m"), parameter("r", 0.3, "m")
    place = r if height == "r" else height
    size = Sphere(r) if shape == "r" else (shape or Box(0.4, 0.3, 0.2))
    box = Body("box", move(x, 0, place), mass=m, shape=size, touches_ground=resting)
    push = Force("push", on=box, along=move(x).x, limit=limit)
    return System("carriage", bodies=[box], inputs=[push], efforts=[Viscous(rate(x), c)])


def turret() -> System:
    """A telescope that turns about the vertical."""
    psi, J = angle("psi", -4.0, 4.0, speed=4.0), parameter("J", 1.0, "kg m^2")
    c = parameter("c", 0.0, "N m s/rad")
    frame = move(0, 0, 1) @ rot_z(psi)
    tube = Body("telescope", frame, mass=1.0, inertia=J, shape=Box(0.5, 0.1, 0.1))
    motor = Torque("motor", on=tube, about=frame.z, limit=2.0)
    return System("turret", bodies=[tube], inputs=[motor], efforts=[Viscous(rate(psi), c)])


def rolling() -> System:
    """A wheel whose speed of turning is commanded: no faster than 4 rad/s."""
    x, r = length("x", -9.0, 9.0, speed=4.0), parameter("r", 0.25, "m")
    wheel = Body("wheel", move(x, 0, r), shape=Disk(r, 0.05, axis="y"), touches_ground=True)
    return System("rolling", bodies=[wheel], inputs=[Rate("turning", on=rate(x) / r, limit=4.0)])


def bistable() -> System:
    """A carriage that is latched where it has gone far enough."""
    x, m, c = (
        length("x", -9.0, 9.0, speed=4.0),
        parameter("m", 1.0, "kg"),
        parameter("c", 0.0, "N s/m"),
    )
    box = Body("box", move(x, 0, 0.3), mass=m, shape=Box(0.4, 0.3, 0.2))
    return System(
        "bistable",
        bodies=[box],
        inputs=[Force("push", on=box, along=move(x).x, limit=1.05)],
        efforts=[Viscous(rate(x), c)],
        modes=[Mode("free"), Mode("latched", constraints=[zero(rate(x), "latched")])],
        transitions=[Transition("latch", "free", "latched", until=0.97 - x)],
    )


def escaping() -> System:
    """A mass that is pushed away the more the further it is: it escapes in finite time."""
    x, m, k = (
        length("x", -99.0, 99.0, speed=99.0),
        parameter("m", 1.0, "kg"),
        parameter("k", 1.0, "N/m^3"),
    )
    box = Body("box", move(x, 0, 0.3), mass=m)
    push = Force("push", on=box, along=move(x).x, limit=2.0)
    away = Wrench(on=box, force=(k * x**3, 0, 0))
    return System("escaping", bodies=[box], inputs=[push], efforts=[away])


def scissors() -> System:
    """Two arms on the same axle that may not touch each other."""
    a, b, J = angle("a", speed=4.0), angle("b", speed=4.0), parameter("J", 1.0, "kg m^2")
    arms = [
        Body(
            name,
            move(0, 0, 1) @ rot_z(q),
            mass=1.0,
            inertia=J,
            shape=Box(0.6, 0.1, 0.1, at=(0.4, 0, 0)),
        )
        for name, q in (("left arm", a), ("right arm", b))
    ]
    motor = Torque("motor", on=arms[0], about=move(0).z, limit=2.0)
    brake = Torque("brake", on=arms[1], about=move(0).z, limit=2.0)
    return System(
        "scissors", bodies=arms, inputs=[motor, brake], collisions=[("left arm", "right arm")]
    )


def sliding() -> System:
    """A box on a slope, which in the world has the angle that the plan knows."""
    x, slope = length("x", -9.0, 9.0, speed=4.0), parameter("slope", 0.1, "rad")
    box = Body("box", rot_y(-slope) @ move(x, 0, 0.3), mass=1.0, shape=Box(0.4, 0.3, 0.2))
    push = Force("push", on=box, along=rot_y(-slope).x, limit=2.0)
    return System("sliding", bodies=[box], inputs=[push])


def lifted() -> System:
    """A box whose height is the sum of two parameters."""
    x = length("x", -9.0, 9.0, speed=4.0)
    a, b = parameter("a", 0.15, "m"), parameter("b", 0.15, "m")
    box = Body("box", move(x, 0, a + b), mass=1.0, shape=Box(0.4, 0.3, 0.2))
    push = Force("push", on=box, along=move(x).x, limit=2.0)
    return System("lifted", bodies=[box], inputs=[push])


def pendulum() -> System:
    """A pendulum that is to be held upright without feedback of its own."""
    theta = angle("theta", speed=8.0)
    m, l, g = parameter("m", 1.0, "kg"), parameter("l", 1.0, "m"), parameter("g", 9.81, "m/s^2")  # noqa: E741
    joint = move(0, 0, 2) @ rot_y(theta)
    bob = Body("bob", joint @ move(0, 0, l), mass=m, shape=Sphere(0.1))
    motor = Torque("motor", on=bob, about=joint.y, limit=5.0)
    return System("pendulum", bodies=[bob], inputs=[motor], gravity=toward("-z", g))


GROUND = '[world]\nground = "plane"\n'
REST = "[goal]\nx = 1.0\nat_rest = true\ntolerance = {}\n"
STILL = np.zeros((60, 1))
CASES = {
    "a wheel is larger than its shape": FailingPlan(
        carriage(shape=Disk(0.3, 0.1, axis="y"), height="r", resting=True),
        GROUND + REST.format(0.2),
        Conditions(vary={"r": 0.1, "m": 0.01}),
        r"collided at the start: box – ground",
        r"--keep r\..*Cylinder\(r, …\)",
    ),
    "a radius lifts the body into a beam": FailingPlan(
        carriage(shape="r", height="r"),
        REST.format(0.2) + '[[world.obstacle]]\nname = "beam"\nbox = [0.1, 1.0, 0.1]\n'
        "position = [0.6, 0.0, 0.66]\n",
        Conditions(vary={"r": 0.1, "m": 0.01}),
        r"collided on the way: box – beam",
        r"--keep r",
    ),
    "a motor is too weak for the mass": FailingPlan(
        carriage(limit=1.02),
        REST.format(0.05),
        Conditions(vary={"m": 0.2}),
        r"missed the goal: x",
        r"times the limits of push.*more of push than there is",
        AHEAD,
        {"large": 0.05},
    ),
    "noise fells a balance": FailingPlan(
        cart_pole(),
        GROUND + "[goal]\nx = 0.0\ntolerance = 0.5\n[bounds]\nx = [-9, 9]\n",
        Conditions(noise=0.4),
        r"(collided|missed)",
        r"without --noise.*noise of the measurements",
        STILL,
    ),
    "gains are too soft": FailingPlan(
        carriage(),
        REST.format(0.05),
        Conditions(built={"c": 0.4}),
        r"missed the goal: x",
        r"--large 0.25 instead of 1",
        options={"large": 1.0},
    ),
    "a wall is too near": FailingPlan(
        carriage(),
        REST.format(0.1) + WALL.format(1.255),
        Conditions(vary={"m": 0.1}),
        r"collided on the way: box – wall",
        r"mm more room.*world\.clearance=0\.0",
        AHEAD,
    ),
    "a slope is not that of the world": FailingPlan(
        sliding(),  # the plank's top is 4 mm below the box
        REST.format(0.1) + '[[world.obstacle]]\nname = "plank"\nbox = [6.0, 1.0, 0.1]\n'
        "position = [0, 0, 0.1467]\nrpy = [0, -0.1, 0]\n",
        Conditions(vary={"slope": 0.2}),
        r"collided on the way: box – plank",
        r"--keep slope.*it is nearer to something than that",
    ),
    "two lengths lift the body into a beam": FailingPlan(
        lifted(),  # 15.5 mm below it: each lifts it by 15 mm at most
        REST.format(0.2) + '[[world.obstacle]]\nname = "beam"\nbox = [0.1, 1.0, 0.1]\n'
        "position = [0.6, 0.0, 0.4655]\n",
        Conditions(vary={"a": 0.1, "b": 0.1}),
        r"collided on the way: box – beam",
        r"So (a and b|b and a) decide alike: know them better",
        runs=60,
    ),
    "a speed is limited": FailingPlan(
        rolling(),
        "[goal]\nx = 1.0\ntolerance = 0.03\n",
        Conditions(built={"r": 0.2}),
        r"missed the goal: x",
        r"more of turning than there is",
        np.full((20, 1), 4.0),
    ),
    "the workspace ends": FailingPlan(
        carriage(),
        "[world]\nbounds = { x = [-1.0, 1.002] }\n" + REST.format(0.2),
        Conditions(vary={"m": 0.1}),
        r"x of box was above 1\.002 m, where the workspace ends",
        r"--keep m|no single change",
    ),
    "a telescope looks at the sun": FailingPlan(
        turret(),
        '[goal]\npsi = 1.0\nat_rest = true\ntolerance = 0.2\n[[keep_out]]\nbody = "telescope"\n'
        "axis = [1, 0, 0]\ndirection = [-0.5, 0.866, 0]\nhalf_angle = 1.09\n",
        Conditions(vary={"J": 0.1}),
        r"the axis of telescope looked into the forbidden cone",
    ),
    "a tolerance is too tight": FailingPlan(
        carriage(),
        REST.format(0.004),
        Conditions(noise=0.01),
        r"missed the goal: x",
        r"times the goal's tolerance|without --noise",
    ),
    "a mode never comes": FailingPlan(
        bistable(),
        "[goal]\nx = 0.98\nmode = 1\ntolerance = { x = 0.1, mode = 0.1 }\n",
        Conditions(built={"c": 0.3}),
        r"missed the goal: its mode was free, not latched",
        r"a transition did not take place",
    ),
    "motors are disturbed": FailingPlan(
        carriage(),
        REST.format(0.03),
        Conditions(disturbance=0.5, vary={"m": 0.001}),
        r"missed the goal: x",
        r"without --disturbance.*disturbance of the inputs",
    ),
    "the equations end": FailingPlan(
        escaping(),
        "[goal]\nx = 1.2\ntolerance = 0.5\n",
        Conditions(built={"k": 90.0}, tracked=False),
        r"could not be followed on the way",
        r"--set k",
        np.full((40, 1), 0.5),
    ),
    "the plan starts in contact": FailingPlan(
        carriage(),
        REST.format(0.2) + WALL.format(-0.2),
        Conditions(vary={"m": 0.05}),
        r"collided at the start: box – wall",
        r"the machine that was planned for fails, too",
    ),
    "nothing corrects": FailingPlan(
        pendulum(),
        "[start]\ntheta = 0.0\n[goal]\ntheta = 0.0\ntolerance = 0.2\n",
        Conditions(disturbance=0.02, tracked=False),
        r"missed the goal: theta",
        r"(without --untracked|--untracked out)|without --disturbance",
        STILL,
    ),
    "friction that the plan does not know": FailingPlan(
        carriage(),
        REST.format(0.05),
        Conditions(built={"c": 0.6}, tracked=False),
        r"missed the goal: x",
        r"without --set c.*plan does not know c",
    ),
    "arms touch each other": FailingPlan(
        scissors(),
        "[start]\nb = 1.931\n[goal]\na = 1.0\nat_rest = true\ntolerance = 0.1\n",
        Conditions(vary={"J": 0.1}),
        r"collided on the way: left arm – right arm",
        r"--keep J.*mm more room",
        np.hstack([AHEAD, 0 * AHEAD]),
    ),
    "a plan is cut short": FailingPlan(
        carriage(),
        REST.format(0.1),
        Conditions(noise=0.001),
        r"missed the goal: x",
        r"the machine that was planned for fails, too",
        AHEAD[:10],
    ),
}

"""Each word for a force or an input pushes two bodies as a drawing of it says, in numbers.

Both derivations read the definition of a force from its class, so that neither proves it. Here it
stands a second time: forces and torques on two bodies that float freely, by vectors of numpy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinolab.dynamics import (
    Body,
    Buoyancy,
    Coulomb,
    Force,
    Load,
    Potential,
    Pull,
    Rope,
    SlidingFriction,
    Spring,
    System,
    Torque,
    Viscous,
    Wrench,
    length,
    move,
    orient,
    rotation,
    toward,
    velocity,
)

Array = NDArray[np.float64]

MASSES, INERTIAS = (2.0, 3.0), np.array([(0.2, 0.3, 0.4), (0.5, 0.4, 0.3)])  # [kg], [kg m^2]
GRAVITY = 9.81
HOOKS = np.array([(0.3, -0.1, 0.2), (-0.2, 0.4, 0.1)])  # of the bodies, in their own axes
FLOATS = [
    move(*(length(f"{axis}_{name}") for axis in "xyz")) @ orient(rotation(f"R_{name}"))
    for name in "ab"
]
A, B = (
    Body(name, frame, mass=mass, inertia=tuple(inertia))
    for name, frame, mass, inertia in zip("ab", FLOATS, MASSES, INERTIAS.tolist(), strict=True)
)
ENDS = FLOATS[0] @ move(*HOOKS[0].tolist()), FLOATS[1] @ move(*HOOKS[1].tolist())
V = velocity(FLOATS[0])
INPUT = 0.7  # of the one input, in its unit


class Floating(NamedTuple):
    """A body by numbers: place, attitude (3, 3), velocity in the world, spin in its own axes."""

    p: Array
    R: Array
    v: Array
    w: Array

    def point(self, at: Array) -> Array:
        """Where a point of it is in the world."""
        return self.p + self.R @ at

    def speed(self, at: Array) -> Array:
        """The velocity of a point of it in the world."""
        return self.v + self.R @ np.cross(self.w, at)


class Push(NamedTuple):
    """A force at a point and a torque on the first (0) or second body (1), in the world."""

    on: int
    force: Array
    point: Array
    torque: Array = np.zeros(3)


def pull(a: Floating, b: Floating, tension: Callable[[float, float], float]) -> list[Push]:
    """Draw both hooks together, by a tension that depends on their distance and its change."""
    one, other = a.point(HOOKS[0]), b.point(HOOKS[1])
    path = other - one
    d = float(np.linalg.norm(path))
    n = path / d
    force = tension(d, float(n @ (b.speed(HOOKS[1]) - a.speed(HOOKS[0])))) * n
    return [Push(0, force, one), Push(1, -force, other)]


def wrench(a: Floating, _: Floating) -> list[Push]:
    at = a.point(HOOKS[0])
    force, torque = a.R @ (1.0, -2.0, 3.0), a.R @ (0.4, 0.5, -0.6)
    return [Push(0, force, at, torque), Push(1, -force, at, -torque)]


def sliding(a: Floating, _: Floating) -> list[Push]:
    vx, vy, _ = a.R.T @ a.v
    size = np.sqrt(vx**2 + vy**2 + 0.1**2)
    return [Push(0, a.R @ (-1.5 * vx / size, -1.5 * vy / size, 0), a.p)]


def rope(length: float) -> Callable[[float, float], float]:
    return lambda d, d_dot: max(0.0, 50.0 * (d - length) + 4.0 * d_dot) if d > length else 0.0


Drawing = Callable[[Floating, Floating], list[Push]]
NONE = np.zeros(3)
Z = np.array([0.0, 0.0, 1.0])
WORDS: dict[str, tuple[Any, Drawing]] = {
    "Potential": (
        Potential(3.0 * FLOATS[0].motions[0].by[0] ** 2 / 2),
        lambda a, _: [Push(0, np.array([-3.0 * a.p[0], 0, 0]), a.p)],
    ),
    "Load": (
        Load(2.0 * V.y, V.z),
        lambda a, _: [Push(0, a.R @ (0, 0, 2.0 * (a.R.T @ a.v)[1]), a.p)],
    ),
    "Spring": (
        Spring(between=ENDS, stiffness=40.0, length=0.5),
        lambda a, b: pull(a, b, lambda d, _: 40.0 * (d - 0.5)),
    ),
    "Spring of no length": (
        Spring(between=ENDS, stiffness=40.0),
        lambda a, b: pull(a, b, lambda d, _: 40.0 * d),
    ),
    "taut Rope": (
        Rope(between=ENDS, stiffness=50.0, length=0.1, damping=4.0),
        lambda a, b: pull(a, b, rope(0.1)),
    ),
    "slack Rope": (
        Rope(between=ENDS, stiffness=50.0, length=90.0, damping=4.0),
        lambda a, b: pull(a, b, rope(90.0)),
    ),
    "Buoyancy": (
        Buoyancy(on=A, lift=12.0, at=tuple(HOOKS[0].tolist())),
        lambda a, _: [Push(0, 12.0 * Z, a.point(HOOKS[0]))],
    ),
    "Viscous": (
        Viscous(V.x, 1.2),
        lambda a, _: [Push(0, a.R @ (-1.2 * (a.R.T @ a.v)[0], 0, 0), a.p)],
    ),
    "Coulomb": (
        Coulomb(V.wy, 0.8, 0.5),
        lambda a, _: [Push(0, NONE, a.p, a.R @ (0, -0.8 * np.tanh(a.w[1] / 0.5), 0))],
    ),
    "SlidingFriction": (SlidingFriction((V.x, V.y), 1.5, 0.1), sliding),
    "Wrench": (
        Wrench(
            on=A,
            force=(1.0, -2.0, 3.0),
            torque=(0.4, 0.5, -0.6),
            at=tuple(HOOKS[0].tolist()),
            reacts_on=B,
        ),
        wrench,
    ),
    "Torque": (
        Torque("u", on=A, about=ENDS[1].z, limit=1.0, reacts_on=B),
        lambda a, b: [
            Push(0, NONE, a.p, INPUT * b.R @ Z),
            Push(1, NONE, b.p, -INPUT * b.R @ Z),
        ],
    ),
    "Force": (
        Force("u", on=A, along=FLOATS[1].z, limit=1.0, reacts_on=B),
        lambda a, b: [Push(0, INPUT * b.R @ Z, a.p), Push(1, -INPUT * b.R @ Z, a.p)],
    ),
    "Pull": (
        Pull("u", between=ENDS, limit=1.0),
        lambda a, b: pull(a, b, lambda *_: INPUT),
    ),
}


def floating(x: Array, k: int) -> Floating:
    q, v = x[7 * k : 7 * k + 7], x[14 + 6 * k : 20 + 6 * k]
    return Floating(q[:3], Rotation.from_quat(q[3:]).as_matrix(), v[:3], v[3:])


def by_hand(x: Array, drawing: Drawing) -> Array:
    """Newton and Euler's accelerations of both bodies, shape (12,)."""
    bodies = floating(x, 0), floating(x, 1)
    forces = [np.array([0, 0, -GRAVITY * mass]) for mass in MASSES]
    torques = [np.zeros(3), np.zeros(3)]
    for push in drawing(*bodies):
        forces[push.on] = forces[push.on] + push.force
        lever = np.cross(push.point - bodies[push.on].p, push.force)
        torques[push.on] = torques[push.on] + push.torque + lever
    found = []
    for body, mass, inertia, force, torque in zip(
        bodies, MASSES, INERTIAS, forces, torques, strict=True
    ):
        found.append(force / mass)
        found.append((body.R.T @ torque - np.cross(body.w, inertia * body.w)) / inertia)
    return np.concatenate(found)


@pytest.mark.parametrize("word", WORDS)
def test_a_word_pushes_as_it_is_drawn(word: str) -> None:
    said, drawing = WORDS[word]
    driven = hasattr(said, "symbol")
    system = System(
        "pair",
        bodies=[A, B],
        inputs=[said] if driven else [],
        efforts=[] if driven else [said],
        gravity=toward("-z", GRAVITY),
    )
    model, random = system.model(), np.random.default_rng(3)
    u = [INPUT] if driven else []
    for k in range(4):
        turns = Rotation.random(2, random_state=k).as_quat()
        places, speeds = random.uniform(-1, 1, (2, 3)), random.uniform(-1, 1, 12)
        x = np.concatenate([places[0], turns[0], places[1], turns[1], speeds])
        np.testing.assert_allclose(model.f(x, u)[14:], by_hand(x, drawing), rtol=1e-11, atol=1e-11)


def test_a_slack_rope_whose_ends_meet_pulls_nothing() -> None:
    """Nothing is divided by their distance."""
    x, z = length("x"), length("z")
    ball = Body("ball", move(x, 0, z), mass=1.0)
    slack = Rope(between=(move(), ball.frame), stiffness=50.0, length=1.0, damping=4.0)
    model = System("ball", bodies=[ball], efforts=[slack]).model()
    assert model.f(np.array([0.0, 0.0, 0.3, -0.2])).tolist() == [0.3, -0.2, 0.0, 0.0]

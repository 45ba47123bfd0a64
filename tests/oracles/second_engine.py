"""Some machines of tests/machines.py a second time: typed in by hand for Pinocchio.

Only numbers are shared: where joints sit, where masses sit, what they weigh. The mass matrix comes
from the composite rigid body algorithm, accelerations from the articulated body algorithm, those of
a loop from Pinocchio's constrained dynamics in proximal form. SI units throughout.

Where Pinocchio's conventions are those of kinolab: quaternions are x, y, z, w; the velocity of a
ball joint is the angular velocity in the body's axes. Where they are not: the linear velocity of a
free flyer is in the body's axes too.

Sources:
    Carpentier, Saurel, Buondonno, Mirabel, Lamiraux, Stasse, Mansard, The Pinocchio C++ library,
        IEEE/SICE SII 2019.
    Carpentier, Budhiraja, Mansard, Proximal and sparse resolution of constrained dynamic equations,
        RSS 2021.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pin: Any = pytest.importorskip("pinocchio", reason="the second engine is not installed")

Array = NDArray[np.float64]
# Force in [N] at the joint's origin and moment in [N m], world axes, by the body's joint.
Wrenches = dict[int, Array]
Pushes = Callable[[Sequence[Array], Array], Wrenches]

STANDARD = 9.81  # [m/s^2]
# A planar loop needs no force along z, so its compliance is singular and some step is needed; steps
# from 1e-12 to 1e-4 give the same accelerations to 1e-13 of their size.
PROXIMAL_STEP = 1e-8
PROXIMAL_ACCURACY = 1e-14  # relative; three iterations reach it
PROXIMAL_ITERATIONS = 20


@dataclass(frozen=True)
class Engine:
    """A machine in Pinocchio.

    Attributes:
        model: The tree of joints.
        pushes: What inputs do, from the joints' rotation matrices and u.
        loops: Points of two bodies that stay together.
    """

    model: Any
    pushes: Pushes
    loops: Any

    def mass_matrix(self, q: Array) -> Array:
        """Return M(q), shape (nv, nv)."""
        upper = np.triu(pin.crba(self.model, self.model.createData(), q))
        return np.asarray(upper + np.triu(upper, 1).T)

    def bias(self, q: Array, v: Array) -> Array:
        """Return what M v_dot lacks of zero without inputs and loops, shape (nv,)."""
        return np.array(pin.nonLinearEffects(self.model, self.model.createData(), q, v))

    def forces(self, q: Array, u: Array) -> Array:
        """Return the generalised forces of the inputs by virtual work, shape (nv,)."""
        data = self.model.createData()
        pin.computeJointJacobians(self.model, data, q)
        turned = [np.array(place.rotation) for place in data.oMi]
        total = np.zeros(self.model.nv)
        for joint, wrench in self.pushes(turned, u).items():
            frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            total += pin.getJointJacobian(self.model, data, joint, frame).T @ wrench
        return total

    def accelerations(self, q: Array, v: Array, u: Array) -> Array:
        """Return v_dot of a machine without loops, shape (nv,)."""
        return np.array(pin.aba(self.model, self.model.createData(), q, v, self.forces(q, u)))

    def loop_dynamics(self, q: Array, v: Array, u: Array) -> tuple[Array, Array]:
        """Return v_dot, shape (nv,), and the force on the first loop's first body, shape (3,).

        The force is in [N] and world axes.
        """
        data, kept = self.model.createData(), pin.StdVec_RigidConstraintData()
        kept.extend([loop.createData() for loop in self.loops])
        pin.initConstraintDynamics(self.model, data, self.loops, kept)
        settings = pin.ProximalSettings(PROXIMAL_ACCURACY, PROXIMAL_STEP, PROXIMAL_ITERATIONS)
        tau = self.forces(q, u)
        v_dot = pin.constraintDynamics(self.model, data, q, v, tau, self.loops, kept, settings)
        turned = data.oMi[self.loops[0].joint1_id].rotation
        return np.array(v_dot), np.array(turned @ kept[0].contact_force.linear)

    def change(self, q: Array, v: Array) -> Array:
        """Return q_dot by differences along the engine's own exponential, shape (nq,).

        The central difference of fourth order misses by (|omega| h)^4 / 30 of its size, 2e-11 for
        5 rad/s, and by rounding / h, 1e-13 per second.
        """
        h = 1e-3  # [s]
        at = {s: np.array(pin.integrate(self.model, q, s * h * v)) for s in (-2, -1, 1, 2)}
        return np.asarray((8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * h))


def double_pendulum_3d() -> Engine:
    """Two rods of 1 m, each on a joint about x that carries one about y."""
    model = _world(0, 0, -STANDARD)
    cross = _joint(model, 0, "RX")
    one = _joint(model, cross, "RY")
    _mass(model, one, 1.2, (0, 0, -0.5), np.diag([0.1, 0.11, 0.01]))
    other = _joint(model, one, "RX", (0, 0, -1))
    two = _joint(model, other, "RY")
    _mass(model, two, 0.8, (0, 0, -0.5), np.diag([0.09, 0.1, 0.02]))

    def pushes(turned: Sequence[Array], u: Array) -> Wrenches:
        elbow = _moment(u[1] * turned[one][:, 0])
        return {one: _moment((u[0], 0, 0)) - elbow, two: elbow}

    return _engine(model, pushes)


def arm() -> Engine:
    """Six hinges about x, y, z, x, y, z of the link before; the last two links are pushed."""
    model, link = _world(0, 0, -STANDARD), 0
    inertia = np.array([[0.05, 0.003, -0.002], [0.003, 0.06, 0.001], [-0.002, 0.001, 0.03]])
    for i in range(6):
        link = _joint(model, link, ("RX", "RY", "RZ")[i % 3], (0, 0.02, 0.3))
        _mass(model, link, 1 + 0.1 * i, (0.01, 0, 0.15), inertia)

    def pushes(turned: Sequence[Array], u: Array) -> Wrenches:
        return {joint: _moment(u[joint - 5] * turned[joint][:, 2]) for joint in (5, 6)}

    return _engine(model, pushes)


def wheeled_hull() -> Engine:
    """A hull on a ball joint at its centre, with three wheels whose centres are off it."""
    model = _world(0, 0, 0)
    hull = _joint(model, 0, "Spherical")
    _mass(model, hull, 20, (0, 0, 0), np.diag([10.0, 12.0, 8.0]))
    wheels = []
    for i, distance in enumerate((0.2, 0.3, 0.4)):
        axis = np.eye(3)[i]
        wheel = _joint(model, hull, ("RX", "RY", "RZ")[i], distance * axis)
        _mass(model, wheel, 1, (0, 0, 0), np.diag(0.006 + 0.004 * axis))
        wheels.append(wheel)

    def pushes(turned: Sequence[Array], u: Array) -> Wrenches:
        torques = (u * turned[hull]).T  # a row per wheel, along the hull's axis
        on_wheels = {wheel: _moment(torques[i]) for i, wheel in enumerate(wheels)}
        return on_wheels | {hull: _moment(-torques.sum(axis=0))}

    return _engine(model, pushes)


def floating_satellite() -> Engine:
    """One body that flies freely; Pinocchio's velocities are all in its axes."""
    model = _world(0, 1.6, 0)
    hull = _joint(model, 0, "FreeFlyer")
    inertia = np.array([[10.0, 0.3, -0.2], [0.3, 12.0, 0.1], [-0.2, 0.1, 8.0]])
    _mass(model, hull, 20, (0, 0, 0), inertia)

    def pushes(turned: Sequence[Array], u: Array) -> Wrenches:
        return {hull: np.concatenate([u[0] * turned[hull][:, 0], np.zeros(3)])}

    return _engine(model, pushes)


def space_telescope(axes: Sequence[int]) -> Engine:
    """A bus that flies freely, with reaction wheels about some of its axes at its centre.

    The bus has what is left of 10, 12 and 8 kg m^2 beside the wheels' 0.01 along and 0.005 across.
    """
    model = _world(0, 0, 0)
    hull = _joint(model, 0, "FreeFlyer")
    wheels = {i: _joint(model, hull, ("RX", "RY", "RZ")[i]) for i in axes}
    rest = np.array([10.0, 12.0, 8.0])
    for i, wheel in wheels.items():
        moments = 0.005 + 0.005 * np.eye(3)[i]
        rest -= moments
        _mass(model, wheel, 0, (0, 0, 0), np.diag(moments))
    _mass(model, hull, 100, (0, 0, 0), np.diag(rest))

    def pushes(turned: Sequence[Array], u: Array) -> Wrenches:
        torques = [torque * turned[hull][:, i] for i, torque in zip(wheels, u, strict=True)]
        on_wheels = dict(zip(wheels.values(), map(_moment, torques), strict=True))
        return on_wheels | {hull: _moment(-np.sum(torques, axis=0))}

    return _engine(model, pushes)


def helicopter() -> Engine:
    """One body of 8.2 kg with a force 0.235 m above it and one 0.91 m behind it."""
    model = _world(0, 0, -STANDARD)
    hull = _joint(model, 0, "FreeFlyer")
    _mass(model, hull, 8.2, (0, 0, 0), np.diag([0.18, 0.34, 0.28]))

    def pushes(turned: Sequence[Array], u: Array) -> Wrenches:
        T, T_t, a, b = u
        axis = np.array([-np.sin(a), -np.sin(b), np.cos(a) * np.cos(b)])
        main, tail = T * axis, np.array([0.0, T_t, 0.0])
        moment = np.cross([0, 0, 0.235], main) + np.cross([-0.91, 0, 0.08], tail)
        moment += (0.004452 * T**1.5 + 0.6304) * axis + 54.0 * np.array([b, -a, 0.0])
        R = turned[hull]
        return {hull: np.concatenate([R @ (main + tail), R @ moment])}

    return _engine(model, pushes)


def four_bar() -> Engine:
    """A crank of 0.4 m with a coupler of 1 m, pinned to a rocker of 0.8 m that turns at x = 1 m."""
    model = _world(0, -STANDARD, 0)
    crank = _joint(model, 0, "RZ")
    _mass(model, crank, 0.5, (0.2, 0, 0), np.diag([0.001, 0.01, 0.01]))
    coupler = _joint(model, crank, "RZ", (0.4, 0, 0))
    _mass(model, coupler, 1.0, (0.5, 0, 0), np.diag([0.001, 0.08, 0.08]))
    rocker = _joint(model, 0, "RZ", (1, 0, 0))
    _mass(model, rocker, 0.8, (0.4, 0, 0), np.diag([0.001, 0.05, 0.05]))
    point = pin.ContactType.CONTACT_3D
    ends = (coupler, _shifted((1, 0, 0)), rocker, _shifted((0.8, 0, 0)))
    loop = pin.RigidConstraintModel(point, model, *ends, pin.ReferenceFrame.LOCAL)
    return _engine(model, lambda _turned, u: {crank: _moment((0, 0, u[0]))}, [loop])


def four_bar_state(a: float, a_dot: float, side: int) -> tuple[Array, Array]:
    """Return q and v of the closed loop, each shape (3,), in closed form.

    The crank turns all the way round: the way from its tip to the rocker's pivot is 0.6 to 1.4 m,
    always between 1 - 0.8 and 1 + 0.8.

    Args:
        a: Angle of the crank in [rad].
        a_dot: Its rate in [rad/s].
        side: 1 or -1, on which side of that way the coupler goes.
    """
    way = 1 - 0.4 * np.exp(1j * a)  # in the complex plane, [m]
    corner = np.arccos((1 + abs(way) ** 2 - 0.8**2) / (2 * abs(way)))  # law of cosines
    coupler = np.angle(way) + side * corner
    c = np.angle(np.exp(1j * coupler) - way)
    # 0.4 a_dot e^(ia) + coupler_dot e^(i coupler) = 0.8 c_dot e^(ic), seen across c and coupler.
    coupler_dot = -0.4 * a_dot * np.sin(a - c) / np.sin(coupler - c)
    c_dot = 0.4 * a_dot * np.sin(a - coupler) / (0.8 * np.sin(c - coupler))
    return np.array([a, coupler - a, c]), np.array([a_dot, coupler_dot - a_dot, c_dot])


def _world(*gravity: float) -> Any:
    model = pin.Model()
    model.gravity.linear = np.array(gravity, dtype=float)
    return model


def _joint(model: Any, parent: int, kind: str, at: Any = (0, 0, 0)) -> int:
    """Add a joint at a point of its parent's joint frame, with axes parallel to it."""
    made = getattr(pin, f"JointModel{kind}")()
    return int(model.addJoint(parent, made, _shifted(at), f"joint{model.njoints}"))


def _mass(model: Any, joint: int, mass: float, centre: Any, inertia: Array) -> None:
    """Add a rigid body, its inertia about its own centre of mass along the joint's axes."""
    body = pin.Inertia(mass, np.array(centre, dtype=float), np.array(inertia, dtype=float))
    model.appendBodyToJoint(joint, body, pin.SE3.Identity())


def _shifted(by: Any) -> Any:
    return pin.SE3(np.eye(3), np.array(by, dtype=float))


def _moment(moment: Any) -> Array:
    return np.concatenate([np.zeros(3), moment])


def _engine(model: Any, pushes: Pushes, loops: Sequence[Any] = ()) -> Engine:
    kept = pin.StdVec_RigidConstraintModel()
    kept.extend(list(loops))
    return Engine(model, pushes, kept)

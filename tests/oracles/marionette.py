"""A puppet on strings, a limb on one string and a stone on a slack string, by hand; SI units.

World and torso frame: x ahead, y to the left, z up. Configuration of the puppet, shape (23,):
q = (x, y, z, q_x, q_y, q_z, q_w, then four angles per limb), the torso's place and its attitude as
a unit quaternion that takes torso vectors to the world. A limb's first three angles turn its upper
link one after the other about axes that go along, in the order that its ``axes`` name; the fourth
turns its lower link about its ``hinge``. Links hang along -z where all angles are zero.

Velocity, shape (22,): v = (torso's x_dot, y_dot, z_dot in the world, its angular velocity in its
own frame, rates of the limbs' angles). Derivatives are complex steps of where the bodies are,
exact to rounding.

A string holds |hook - spindle| <= L, and pulls where it is taut.

Sources:
    Johnson, Murphey, Dynamic modeling and motion planning for marionettes: rigid bodies articulated
        by massless strings, ICRA 2007: torso, limbs, strings.
    Squire, Trapp, Using complex variables to estimate derivatives of real functions, SIAM Review
        40(1), 1998.
    Nocedal, Wright, Numerical Optimization, 2nd ed., 2006, section 12.3: what multipliers tell.
    Kane, Levinson, Dynamics: Theory and Applications, 1985: inertia forces times partial
        velocities.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, nnls

Array = NDArray[np.float64]
Field = NDArray[Any]  # real, or complex in a complex step
Triple = tuple[float, float, float]

STEP = 1e-30  # of complex steps: nothing cancels, so it may be as small as it likes
NUDGE = 1e-4  # [s] of central differences in time: their error is its square


# The puppet


@dataclass(frozen=True)
class Lump:
    """A rigid body: mass in [kg], centre of mass in its frame in [m], inertia in [kg m^2].

    The inertia is about the centre of mass and along the frame's axes.
    """

    mass: float
    place: Triple
    inertia: Triple


@dataclass(frozen=True)
class Limb:
    """An upper and a lower link.

    Attributes:
        name: The links' frames are ``upper_name`` and ``lower_name``.
        root: Where the upper link is jointed, in the torso frame in [m].
        elbow: Where the lower link is jointed, in the upper frame in [m].
        upper: Body of the upper link, its frame at the root.
        lower: Body of the lower link, its frame at the elbow.
        axes: Axes of the root's three turns, outermost first.
        hinge: Axis of the elbow's turn.
    """

    name: str
    root: Triple
    elbow: Triple
    upper: Lump
    lower: Lump
    axes: str = "xyz"
    hinge: str = "y"


@dataclass(frozen=True)
class Puppet:
    """A torso with a head that does not turn, and limbs.

    Attributes:
        torso: Body in the torso frame.
        head: Another one in the torso frame.
        limbs: Their angles follow the torso's coordinates, in this order.
        g: Gravity in [m/s^2].
        damping: Of every angle of a limb, in [N m s].
    """

    torso: Lump
    head: Lump
    limbs: tuple[Limb, ...]
    g: float = 9.81
    damping: float = 0.1

    @property
    def bodies(self) -> tuple[tuple[str, Lump], ...]:
        """All bodies and the names of their frames."""
        links = [
            (f"{part}_{limb.name}", lump)
            for limb in self.limbs
            for part, lump in (("upper", limb.upper), ("lower", limb.lower))
        ]
        return (("torso", self.torso), ("torso", self.head), *links)

    @property
    def mass(self) -> float:
        """The whole in [kg]."""
        return sum(lump.mass for _, lump in self.bodies)

    @property
    def speeds(self) -> int:
        """Length of v."""
        return 6 + 4 * len(self.limbs)


@dataclass(frozen=True)
class String:
    """A string of a ``length`` in [m] from a ``spindle`` in the world to a ``hook`` on a body.

    Attributes:
        body: Name of a frame.
        hook: In that frame in [m].
        spindle: In the world in [m].
        length: The most that hook and spindle may be apart in [m].
    """

    body: str
    hook: Triple
    spindle: Triple
    length: float


def example_puppet(
    shoulder: Triple = (0, 1.2, 1.2),
    hip: Triple = (0, 0.6, -1.5),
    head: Triple = (0, 0, 2.2),
    arm: tuple[float, float] = (1.5, 1.5),
    leg: tuple[float, float] = (2.0, 2.0),
    axes: str = "xyz",
    hinge: str = "y",
) -> Puppet:
    """Return torso 50 kg, head 10 kg, four limbs of 5 and 4 kg, all inertias 1 kg m^2.

    Args:
        shoulder: The left one in the torso frame; the right one is its mirror image.
        hip: The left one.
        head: The head's centre of mass.
        arm: Lengths of upper and lower arm in [m], centres of mass midway.
        leg: Lengths of thigh and shank.
        axes: Of all roots.
        hinge: Of all elbows and knees.
    """
    round_body = (1.0, 1.0, 1.0)

    def limb(name: str, root: Triple, side: int, lengths: tuple[float, float]) -> Limb:
        upper, lower = (
            Lump(mass, (0, 0, -length / 2), round_body)
            for mass, length in zip((5.0, 4.0), lengths, strict=True)
        )
        mirrored = (root[0], side * root[1], root[2])
        return Limb(name, mirrored, (0, 0, -lengths[0]), upper, lower, axes, hinge)

    limbs = [
        limb(f"{part}_{letter}", root, side, lengths)
        for part, root, lengths in (("arm", shoulder, arm), ("leg", hip, leg))
        for letter, side in (("l", 1), ("r", -1))
    ]
    return Puppet(Lump(50.0, (0, 0, 0), round_body), Lump(10.0, head, round_body), tuple(limbs))


def example_strings(
    torso: Triple = (0, 1.0, 1.5),
    hand: Triple = (0, 0, -1.5),
    knee: Triple = (0, 0, -2.0),
    torso_spindle: Triple = (0, 1.0, 14),
    hand_spindle: Triple = (2.0, 1.6, 14),
    knee_spindle: Triple = (5.0, 0.8, 14),
    lengths: tuple[float, ...] = (13.4, 13.4, 15.4, 15.5, 18.6, 18.6),
) -> tuple[String, ...]:
    """Return six strings: torso, hands and knees, left before right, spindles 14 m high.

    Hooks are in the frames of torso, lower arms and thighs; the right ones are mirror images.
    """
    places = [
        (body.format(letter), side, hook, spindle)
        for body, hook, spindle in (
            ("torso", torso, torso_spindle),
            ("lower_arm_{}", hand, hand_spindle),
            ("upper_leg_{}", knee, knee_spindle),
        )
        for letter, side in (("l", 1), ("r", -1))
    ]
    return tuple(
        String(body, (a[0], side * a[1], a[2]), (b[0], side * b[1], b[2]), length)
        for (body, side, a, b), length in zip(places, lengths, strict=True)
    )


# Where everything is


def about(axis: str, angle: Field) -> Field:
    """Return the right-handed turn about x, y or z, shape (..., 3, 3)."""
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    R = np.zeros((*np.shape(angle), 3, 3), dtype=np.result_type(angle))
    R[..., i, i] = 1
    R[..., j, j] = R[..., k, k] = np.cos(angle)
    R[..., k, j] = np.sin(angle)
    R[..., j, k] = -R[..., k, j]
    return R


def attitude(quaternion: Field) -> Field:
    """Return R of (x, y, z, w), shape (..., 3, 3), from w^2 - a.a, a a^T and w [a]x.

    The quaternion is scaled to length one, by a square root that complex steps pass through.
    """
    q = quaternion / np.sqrt((quaternion * quaternion).sum(axis=-1))[..., None]
    a, w = q[..., :3], q[..., 3][..., None, None]
    square = (a * a).sum(axis=-1)[..., None, None]
    outer = a[..., :, None] * a[..., None, :]
    return np.asarray((w * w - square) * np.eye(3) + 2 * outer + 2 * w * hat(a))


def hat(a: Field) -> Field:
    """Return the matrix of a x, shape (..., 3, 3)."""
    x, y, z = (a[..., i] for i in range(3))
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def shifted(q: Field, change: Field) -> Field:
    """Return q moved by ``change``, shape (..., 22), as far as v points in unit time.

    The attitude is multiplied from the right by the quaternion (turn / 2, 1), scaled: equal to the
    turn up to third order.
    """
    half = change[..., 3:6] / 2
    a, w = q[..., 3:6], q[..., 6:7]
    turned = a + w * half + np.cross(a, half)
    real = w - (a * half).sum(axis=-1)[..., None]
    quaternion = np.concatenate([turned, real], axis=-1)
    quaternion = quaternion / np.sqrt((quaternion * quaternion).sum(axis=-1))[..., None]
    parts = [q[..., :3] + change[..., :3], quaternion, q[..., 7:] + change[..., 6:]]
    return np.concatenate(parts, axis=-1)


def frames(q: Field, puppet: Puppet) -> dict[str, tuple[Field, Field]]:
    """Return every frame's attitude and origin in the world, shapes (..., 3, 3) and (..., 3)."""
    R, p = attitude(q[..., 3:7]), q[..., :3]
    found = {"torso": (R, p)}
    for n, limb in enumerate(puppet.limbs):
        angles = q[..., 7 + 4 * n : 11 + 4 * n]
        upper, root = R, p + R @ np.array(limb.root)
        for k, axis in enumerate(limb.axes):
            upper = upper @ about(axis, angles[..., k])
        elbow = root + upper @ np.array(limb.elbow)
        found[f"upper_{limb.name}"] = (upper, root)
        found[f"lower_{limb.name}"] = (upper @ about(limb.hinge, angles[..., 3]), elbow)
    return found


def centres(q: Field, puppet: Puppet) -> Field:
    """Return the bodies' centres of mass in the world in [m], shape (..., bodies, 3)."""
    at = frames(q, puppet)
    places = [at[name][1] + at[name][0] @ np.array(lump.place) for name, lump in puppet.bodies]
    return np.stack(places, axis=-2)


def attitudes(q: Field, puppet: Puppet) -> Field:
    """Return the bodies' attitudes, shape (..., bodies, 3, 3)."""
    at = frames(q, puppet)
    return np.stack([at[name][0] for name, _ in puppet.bodies], axis=-3)


def masses(puppet: Puppet) -> Array:
    """Return the bodies' masses in [kg], shape (bodies,)."""
    return np.array([lump.mass for _, lump in puppet.bodies])


def inertias(puppet: Puppet) -> Array:
    """Return the bodies' inertias in [kg m^2], shape (bodies, 3)."""
    return np.array([lump.inertia for _, lump in puppet.bodies])


def potential_energy(q: Field, puppet: Puppet) -> Any:
    """Return V in [J], shape (...), zero where all is at height zero."""
    return puppet.g * (centres(q, puppet)[..., 2] @ masses(puppet))


def string_lengths(q: Field, strings: tuple[String, ...], puppet: Puppet) -> Field:
    """Return how far hooks and spindles are apart in [m], shape (..., strings)."""
    at = frames(q, puppet)
    spans = [
        at[s.body][1] + at[s.body][0] @ np.array(s.hook) - np.array(s.spindle) for s in strings
    ]
    return np.stack([np.sqrt((span * span).sum(axis=-1)) for span in spans], axis=-1)


# How fast


def partial_velocities(q: Array, puppet: Puppet) -> tuple[Array, Array]:
    """Return by what v moves and turns each body, both of shape (bodies, 3, 22).

    Velocities of the centres of mass in the world, angular velocities in the bodies' own frames,
    from R^T R_dot.
    """
    steps = shifted(np.broadcast_to(q, (puppet.speeds, len(q))), 1j * STEP * np.eye(puppet.speeds))
    moving = centres(steps, puppet).imag / STEP
    R, turning = attitudes(q, puppet), attitudes(steps, puppet).imag / STEP
    spins = np.swapaxes(R, -1, -2) @ turning
    turns = np.stack([spins[..., 2, 1], spins[..., 0, 2], spins[..., 1, 0]], axis=-1)
    return np.moveaxis(moving, 0, -1), np.moveaxis(turns, 0, -1)


def mass_matrix(q: Array, puppet: Puppet) -> Array:
    """Return M of T = v M v / 2, shape (22, 22)."""
    moves, turns = partial_velocities(q, puppet)
    moving = np.einsum("b,bia,bic->ac", masses(puppet), moves, moves)
    return np.asarray(moving + np.einsum("bi,bia,bic->ac", inertias(puppet), turns, turns))


def kinetic_energy(q: Array, v: Array, puppet: Puppet) -> float:
    """Return T in [J], from the velocities of all bodies along one complex step."""
    step = shifted(q.astype(np.complex128), 1j * STEP * v)
    speeds = centres(step, puppet).imag / STEP
    spins = np.swapaxes(attitudes(q, puppet), -1, -2) @ (attitudes(step, puppet).imag / STEP)
    turns = np.stack([spins[..., 2, 1], spins[..., 0, 2], spins[..., 1, 0]], axis=-1)
    turning = (inertias(puppet) * turns**2).sum()
    return float(masses(puppet) @ (speeds**2).sum(axis=1) + turning) / 2


def in_world(q: Array, v: Array) -> Array:
    """Return v, shape (22,), of one whose torso velocity is given in the torso's own frame."""
    return np.concatenate([attitude(q[3:7]) @ v[:3], v[3:]])


def damping_forces(v: Array, puppet: Puppet) -> Array:
    """Return what damps the limbs' angles in [N m], shape (22,); their power is never positive."""
    return -puppet.damping * np.concatenate([np.zeros(6), v[6:]])


def inverse_dynamics(q: Array, v: Array, v_dot: Array, puppet: Puppet) -> Array:
    """Return M v_dot + c + dV, shape (22,): what forces along v the motion asks for.

    Newton and Euler for each body, times its partial velocities. Accelerations are central
    differences of velocities along the motion, right to about eight digits.
    """

    def velocities(t: float) -> tuple[Array, Array]:
        there = shifted(q, t * v + t**2 * v_dot / 2)
        moves, turns = partial_velocities(there, puppet)
        return moves @ (v + t * v_dot), turns @ (v + t * v_dot)

    (before, spin_before), (after, spin_after) = velocities(-NUDGE), velocities(NUDGE)
    moves, turns = partial_velocities(q, puppet)
    I, spin = inertias(puppet), turns @ v  # noqa: E741
    forces = (after - before) / (2 * NUDGE) + np.array([0, 0, puppet.g])
    moments = I * (spin_after - spin_before) / (2 * NUDGE) + np.cross(spin, I * spin)
    moving = np.einsum("b,bi,bia->a", masses(puppet), forces, moves)
    return np.asarray(moving + np.einsum("bi,bia->a", moments, turns))


# At rest


@dataclass(frozen=True)
class StaticPose:
    """Where the puppet hangs still.

    Attributes:
        q: Configuration, shape (23,).
        V: Potential energy in [J].
        tensions: Of the strings in [N], shape (strings,).
        slack: What the strings are too long in [m], shape (strings,).
        imbalance: Largest force or moment that weights and tensions leave, in [N] or [N m].
    """

    q: Array
    V: float
    tensions: Array
    slack: Array
    imbalance: float


def gradients(q: Array, strings: tuple[String, ...], puppet: Puppet) -> tuple[Array, Array]:
    """Return dV, shape (22,), and d lengths, shape (strings, 22), along v."""
    steps = shifted(np.broadcast_to(q, (puppet.speeds, len(q))), 1j * STEP * np.eye(puppet.speeds))
    lengths = string_lengths(steps, strings, puppet).imag.T
    return np.asarray(potential_energy(steps, puppet).imag / STEP), np.asarray(lengths / STEP)


def static_pose(
    start: Array,
    strings: tuple[String, ...],
    puppet: Puppet,
    taut: bool = False,
    rounds: int = 3,
    tolerance: float = 1e-6,
) -> StaticPose:
    """Return argmin V with no string longer than it is, near ``start``, by SLSQP.

    Tensions are the multipliers, dV + sum tension d length = 0: found by non-negative least squares
    over the strings that are within ``tolerance`` in [m] of taut.

    Args:
        taut: Whether all strings shall be taut; tensions of either sign then tell whether they
            would be.
        rounds: How often SLSQP starts anew from where it ended, its model of the curvature
            forgotten.
    """
    limits, weight = np.array([s.length for s in strings]), puppet.mass * puppet.g
    q = start
    for _ in range(rounds):
        origin = q

        def at(change: Array, origin: Array = origin) -> Array:
            return np.asarray(shifted(origin, change))

        def slopes(change: Array, origin: Array = origin) -> tuple[Array, Array]:
            steps = change + 1j * STEP * np.eye(puppet.speeds)
            there = shifted(np.broadcast_to(origin, (puppet.speeds, len(origin))), steps)
            lengths = string_lengths(there, strings, puppet).imag.T
            return potential_energy(there, puppet).imag / STEP, lengths / STEP

        found = minimize(
            lambda d, at=at: float(potential_energy(at(d), puppet)) / weight,
            np.zeros(puppet.speeds),
            jac=lambda d, slopes=slopes: slopes(d)[0] / weight,
            method="SLSQP",
            constraints={
                "type": "eq" if taut else "ineq",
                "fun": lambda d, at=at: limits - string_lengths(at(d), strings, puppet),
                "jac": lambda d, slopes=slopes: -slopes(d)[1],
            },
            options={"maxiter": 300, "ftol": 1e-15},
        )
        q = at(found.x)
    return _weighed(q, strings, puppet, taut, tolerance)


def _weighed(
    q: Array, strings: tuple[String, ...], puppet: Puppet, taut: bool, tolerance: float
) -> StaticPose:
    """Return the pose with what its strings pull."""
    slack = np.array([s.length for s in strings]) - string_lengths(q, strings, puppet)
    dV, pulls = gradients(q, strings, puppet)
    pulling = np.ones(len(strings), dtype=bool) if taut else slack < tolerance
    tensions: Array = np.zeros(len(strings))
    if taut:
        tensions = np.asarray(np.linalg.lstsq(pulls.T, -dV, rcond=None)[0], dtype=np.float64)
    elif pulling.any():
        tensions[pulling] = nnls(pulls[pulling].T, -dV)[0]
    imbalance = float(np.abs(dV + tensions @ pulls).max())
    return StaticPose(q, float(potential_energy(q, puppet)), tensions, slack, imbalance)


def elastic_pose(
    start: Array, strings: tuple[String, ...], puppet: Puppet, stiffness: float, rounds: int = 3
) -> StaticPose:
    """Return where it hangs on strings that give by tension / stiffness, by BFGS alone.

    V + stiffness / 2 sum max(0, length - L)^2 has no constraints; its minimum comes near that of
    strings that do not give as 1 / stiffness.

    Args:
        stiffness: In [N/m].
        rounds: How often BFGS starts anew from where it ended.
    """
    limits, weight = np.array([s.length for s in strings]), puppet.mass * puppet.g

    def value(change: Array, origin: Array) -> tuple[float, Array]:
        steps = change + 1j * STEP * np.eye(puppet.speeds)
        there = shifted(np.broadcast_to(origin, (puppet.speeds, len(origin))), steps)
        stretch = string_lengths(there, strings, puppet) - limits
        stretch = np.where(stretch.real > 0, stretch, 0)
        total = potential_energy(there, puppet) + stiffness / 2 * (stretch**2).sum(axis=-1)
        return float(total[0].real) / weight, total.imag / STEP / weight

    q = start
    for _ in range(rounds):
        found = minimize(
            value, np.zeros(puppet.speeds), args=(q,), jac=True, method="BFGS",
            options={"gtol": 1e-10, "maxiter": 2000},
        )  # fmt: skip
        q = np.asarray(shifted(q, found.x))
    slack = limits - string_lengths(q, strings, puppet)
    dV, pulls = gradients(q, strings, puppet)
    tensions = stiffness * np.maximum(-slack, 0)
    imbalance = float(np.abs(dV + tensions @ pulls).max())
    return StaticPose(q, float(potential_energy(q, puppet)), tensions, slack, imbalance)


# A limb on one string, in a vertical plane


@dataclass(frozen=True)
class Link:
    """A link of a chain: lengths in [m] to the next joint and to its centre of mass.

    ``mass`` in [kg], ``inertia`` about the centre of mass in [kg m^2]. A string is a link without
    either.
    """

    length: float
    centre: float = 0.0
    mass: float = 0.0
    inertia: float = 0.0


@dataclass(frozen=True)
class HangingChain:
    """Links that hang from a spindle; state (angles from hanging down, their rates), 2 n numbers.

    Link i points along e_i = (sin theta_i, -cos theta_i), across and up. With r_ki the length of
    link i before body k, or its centre's, the kinetic energy's products are
    A_ij = sum_k m_k r_ki r_kj + I_i delta_ij, times cos(theta_i - theta_j).
    """

    links: tuple[Link, ...]
    g: float = 9.81

    @property
    def arms(self) -> Array:
        """Return r, shape (bodies, links)."""
        n = len(self.links)
        arms = np.tril(np.tile([link.length for link in self.links], (n, 1)), -1)
        return np.asarray(arms + np.diag([link.centre for link in self.links]))

    @property
    def masses(self) -> Array:
        """Return the links' masses in [kg], shape (n,)."""
        return np.array([link.mass for link in self.links])

    @property
    def products(self) -> Array:
        """Return A in [kg m^2], shape (n, n)."""
        turning = np.diag([link.inertia for link in self.links])
        return np.asarray(self.arms.T * self.masses @ self.arms + turning)

    def mass_matrix(self, angles: Array) -> Array:
        """Return M, shape (n, n)."""
        return np.asarray(self.products * np.cos(np.subtract.outer(angles, angles)))

    def bias(self, x: Array, lift: Array | None = None) -> Array:
        """Return c + dV of M theta_ddot + c + dV = 0 in [N m], shape (n,).

        Args:
            x: State, shape (2 n,).
            lift: Acceleration of the spindle across and up in [m/s^2], shape (2,); none if absent.
        """
        angles, rates = np.split(x, 2)
        across, up = np.zeros(2) if lift is None else lift
        turning = self.products * np.sin(np.subtract.outer(angles, angles)) @ rates**2
        weight = (self.g + up) * np.sin(angles) + across * np.cos(angles)
        return np.asarray(turning + self.masses @ self.arms * weight)

    def rate(self, x: Array, lift: Array | None = None) -> Array:
        """Return x_dot, shape (2 n,)."""
        angles, rates = np.split(x, 2)
        pull = np.linalg.solve(self.mass_matrix(angles), -self.bias(x, lift))
        return np.concatenate([rates, pull])

    def energy(self, x: Array) -> float:
        """Return T + V in [J], V measured from the spindle."""
        angles, rates = np.split(x, 2)
        V = -self.g * self.masses @ self.arms @ np.cos(angles)
        return float(rates @ self.mass_matrix(angles) @ rates / 2 + V)

    def spindle_force(self, x: Array, lift: Array | None = None) -> Array:
        """Return what the spindle pulls with in [N], across and up, shape (2,).

        The sum of m (acceleration - gravity); along the first link if that is a string.
        """
        angles, rates = np.split(x, 2)
        turns = self.rate(x, lift)[len(angles) :]
        e = np.stack([np.sin(angles), -np.cos(angles)], axis=1)
        ahead = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        accelerations = self.arms @ (turns[:, None] * ahead - (rates**2)[:, None] * e)
        spindle = np.zeros(2) if lift is None else lift
        return np.asarray(self.masses @ (accelerations + spindle + np.array([0, self.g])))

    def tension(self, x: Array, lift: Array | None = None) -> float:
        """Return the pull along the first link in [N]; a string goes slack below zero."""
        return float(self.spindle_force(x, lift) @ [-np.sin(x[0]), np.cos(x[0])])


# A stone on a slack string, in a vertical plane, the spindle at the origin


@dataclass(frozen=True)
class SlackStone:
    """A point of mass ``m`` in [kg] on a string of length ``L`` in [m].

    Taut states are (angle from hanging down, its rate), flying ones (place, velocity) across and
    up, shapes (2,) each.
    """

    m: float = 1.0
    L: float = 1.0
    g: float = 9.81

    @property
    def gravity(self) -> Array:
        """Return (0, -g)."""
        return np.array([0.0, -self.g])

    def tension(self, angle: float, rate: float) -> float:
        """Return m (L rate^2 + g cos(angle)) in [N]."""
        return float(self.m * (self.L * rate**2 + self.g * np.cos(angle)))

    def slack_angle(self, angle: float, rate: float) -> float | None:
        """Return the angle in (0, pi), on either side, where the swing goes slack; None if nowhere.

        With the energy of (angle, rate) the tension vanishes at
        cos = (2 g cos(angle) - L rate^2) / (3 g). Above the spindle only: with less energy the
        stone turns back first, with more it goes round.
        """
        cosine = (2 * np.cos(angle) - self.L * rate**2 / self.g) / 3
        return float(np.arccos(cosine)) if -1 < cosine < 0 else None

    def flying(self, angle: float, rate: float) -> tuple[Array, Array]:
        """Return place and velocity of a taut state."""
        place = self.L * np.array([np.sin(angle), -np.cos(angle)])
        return place, self.L * rate * np.array([np.cos(angle), np.sin(angle)])

    def flight(self, place: Array, velocity: Array, t: float) -> tuple[Array, Array]:
        """Return place and velocity after ``t`` in [s] of free fall."""
        fallen = place + velocity * t + self.gravity * t**2 / 2
        return fallen, velocity + self.gravity * t

    def taut_time(self, place: Array, velocity: Array) -> float:
        """Return after which free fall the string is taut in [s]: the least root of a quartic.

        |r|^2 - L^2 with r = place + velocity t + gravity t^2 / 2; a stone that starts at |r| = L
        must move inwards. Where it went slack by itself, use ``arc_time``.
        """
        g = self.gravity
        quartic = [
            g @ g / 4,
            velocity @ g,
            velocity @ velocity + place @ g,
            2 * place @ velocity,
            place @ place - self.L**2,
        ]
        roots = np.roots(quartic)
        real = roots.real[np.abs(roots.imag) < 1e-9 * (1 + np.abs(roots.real))]
        return float(real[real > 1e-9].min())

    def arc_time(self, velocity: Array) -> float:
        """Return how long a stone flies in [s] that left its circle as the tension vanished.

        There r . v = 0 and v^2 + r . g = 0, so that the quartic is t^3 (v . g + g^2 t / 4).
        """
        return float(4 * velocity[1] / self.g)

    def tighten(self, place: Array, velocity: Array) -> tuple[Array, float]:
        """Return the velocity after an inelastic jerk, shape (2,), and the impulse in [N s].

        Only what points outwards is lost: the stone keeps its moment of momentum.
        """
        outwards = place / np.linalg.norm(place)
        speed = max(float(velocity @ outwards), 0.0)
        return velocity - speed * outwards, self.m * speed

    def swinging(self, place: Array, velocity: Array) -> tuple[float, float]:
        """Return angle and rate of a taut state, from place and a velocity across the string."""
        moment = place[0] * velocity[1] - place[1] * velocity[0]
        return float(np.arctan2(place[0], -place[1])), float(moment / (place @ place))

    def energy(self, place: Array, velocity: Array) -> float:
        """Return T + V in [J], V measured from the spindle."""
        return float(self.m * (velocity @ velocity / 2 + self.g * place[1]))

"""The puppet's oracle against recursion, balance and closed forms."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from tests.oracles.marionette import (
    Array,
    HangingChain,
    Limb,
    Link,
    Lump,
    Puppet,
    SlackStone,
    StaticPose,
    about,
    attitude,
    centres,
    damping_forces,
    elastic_pose,
    example_puppet,
    example_strings,
    frames,
    gradients,
    in_world,
    inverse_dynamics,
    kinetic_energy,
    mass_matrix,
    potential_energy,
    shifted,
    static_pose,
    string_lengths,
)

PUPPET, STRINGS = example_puppet(axes="zyx"), example_strings()
HALF = HangingChain((Link(2.0), Link(1.5, 0.7, 5.0, 0.4), Link(1.0, 0.6, 4.0, 0.3)))
LUMPS = (Lump(5.0, (0, 0, -0.7), (0.4, 0.4, 0.1)), Lump(4.0, (0, 0, -0.6), (0.3, 0.3, 0.1)))


def random_state(seed: int) -> tuple[Array, Array, Array]:
    random = np.random.default_rng(seed)
    q = random.uniform(-1, 1, 23)
    q[3:7] /= np.linalg.norm(q[3:7])
    return q, random.uniform(-1, 1, 22), random.uniform(-1, 1, 22)


@cache
def hanging() -> tuple[Puppet, Array, StaticPose]:
    puppet, start = example_puppet(), np.zeros(23)
    start[2], start[6] = -1, 1
    start[7:] = np.tile([0.05, -0.3, 0.02, -0.2], 4)
    return puppet, start, static_pose(start, STRINGS, puppet, rounds=1)


# The puppet


def test_attitude_turns_about_its_axis() -> None:
    """A quaternion (axis sin(angle / 2), cos(angle / 2)) turns as the axis' own turn does."""
    for i, axis in enumerate("xyz"):
        quaternion = np.append(np.sin(0.35) * np.eye(3)[i], np.cos(0.35))
        assert attitude(quaternion) == pytest.approx(about(axis, np.array(0.7)), abs=1e-15)
    assert about("z", np.array(np.pi / 2)) @ np.eye(3)[0] == pytest.approx([0, 1, 0])


def test_links_are_as_far_apart_as_their_joints() -> None:
    q, _, _ = random_state(0)
    at = frames(q, PUPPET)
    knee, hip = at["lower_leg_l"][1], at["upper_leg_l"][1]
    assert np.linalg.norm(knee - hip) == pytest.approx(2.0)
    assert knee - hip == pytest.approx(-2 * at["upper_leg_l"][0][:, 2])


@pytest.mark.parametrize("seed", range(2))
def test_kinetic_energy_is_that_of_velocities_added_up_from_the_torso(seed: int) -> None:
    """Outwards, link by link: each turn adds its axis times its rate."""
    q, v, _ = random_state(seed)
    at = frames(q, PUPPET)
    R, p = at["torso"]

    def energy(lump: Lump, R: Array, velocity: Array, spin: Array) -> float:
        moving = velocity + np.cross(spin, R @ np.array(lump.place))
        own = R.T @ spin
        return float(lump.mass * moving @ moving + np.array(lump.inertia) @ own**2) / 2

    spin = R @ v[3:6]
    T = energy(PUPPET.torso, R, v[:3], spin) + energy(PUPPET.head, R, v[:3], spin)
    for n, limb in enumerate(PUPPET.limbs):
        rates, angles = v[6 + 4 * n : 10 + 4 * n], q[7 + 4 * n : 11 + 4 * n]
        (upper, root), (lower, elbow) = (at[f"{part}_{limb.name}"] for part in ("upper", "lower"))
        turned, turning = R, spin
        for k, axis in enumerate(limb.axes):
            turning = turning + rates[k] * turned[:, "xyz".index(axis)]
            turned = turned @ about(axis, angles[k])
        velocity = v[:3] + np.cross(spin, root - p)
        T += energy(limb.upper, upper, velocity, turning)
        velocity = velocity + np.cross(turning, elbow - root)
        turning = turning + rates[3] * upper[:, "xyz".index(limb.hinge)]
        T += energy(limb.lower, lower, velocity, turning)
    assert kinetic_energy(q, v, PUPPET) == pytest.approx(T, rel=1e-12)
    M = mass_matrix(q, PUPPET)
    assert v @ M @ v / 2 == pytest.approx(T, rel=1e-12)
    assert np.linalg.eigvalsh(M).min() > 0


def test_gradients_are_differences() -> None:
    q, v, _ = random_state(1)
    h, (dV, pulls) = 1e-6, gradients(q, STRINGS, PUPPET)
    ahead, behind = shifted(q, h * v), shifted(q, -h * v)
    V = potential_energy(ahead, PUPPET) - potential_energy(behind, PUPPET)
    lengths = string_lengths(ahead, STRINGS, PUPPET) - string_lengths(behind, STRINGS, PUPPET)
    assert V / (2 * h) == pytest.approx(dV @ v, rel=1e-8)
    assert lengths / (2 * h) == pytest.approx(pulls @ v, abs=1e-8)


@pytest.mark.parametrize("seed", range(2))
def test_inverse_dynamics_takes_the_power_that_energy_gains(seed: int) -> None:
    q, v, v_dot = random_state(seed)
    h = 1e-4

    def energy(t: float) -> float:
        there = shifted(q, t * v + t**2 * v_dot / 2)
        return float(kinetic_energy(there, v + t * v_dot, PUPPET) + potential_energy(there, PUPPET))

    gained = (energy(h) - energy(-h)) / (2 * h)
    power = inverse_dynamics(q, v, v_dot, PUPPET) @ v
    assert power == pytest.approx(gained, abs=1e-4)  # [W] of some hundred; h^2
    assert damping_forces(v, PUPPET) @ v == pytest.approx(-0.1 * v[6:] @ v[6:])


def test_inverse_dynamics_is_linear_in_accelerations_with_the_mass_matrix() -> None:
    q, v, v_dot = random_state(3)
    difference = inverse_dynamics(q, v, v_dot, PUPPET) - inverse_dynamics(q, v, 0 * v, PUPPET)
    assert difference == pytest.approx(mass_matrix(q, PUPPET) @ v_dot, abs=1e-5)


def test_free_fall_asks_for_no_force() -> None:
    q, v, _ = random_state(4)
    fall = np.zeros(22)
    fall[2] = -PUPPET.g
    assert inverse_dynamics(q, 0 * v, fall, PUPPET) == pytest.approx(np.zeros(22), abs=1e-5)
    along_x = np.zeros(22)
    along_x[0] = 2
    in_torso = in_world(q, along_x)
    assert in_torso[:3] == pytest.approx(2 * attitude(q[3:7])[:, 0])


def test_planar_limb_is_a_chain_of_two_links() -> None:
    """Turns about y, their sum being the lower link's angle, the other way round as the chain's."""
    limb = Limb("arm", (0, 0, 0), (0, 0, -1.5), *LUMPS, axes="xzy")
    torso = Lump(1.0, (0, 0, 0), (1.0, 1.0, 1.0))
    puppet = Puppet(torso, torso, (limb,))
    chain = HangingChain(HALF.links[1:])
    a, rates, turns = np.array([0.4, -0.9]), np.array([1.2, -0.5]), np.array([0.7, 2.0])
    q, v, v_dot = np.zeros(11), np.zeros(10), np.zeros(10)
    q[6] = 1
    q[9:], v[8:], v_dot[8:] = -a, -rates, -turns
    angles, spins, bends = np.cumsum(a), np.cumsum(rates), np.cumsum(turns)
    moments = chain.mass_matrix(angles) @ bends + chain.bias(np.concatenate([angles, spins]))
    found = inverse_dynamics(q, v, v_dot, puppet)[8:]
    assert -found == pytest.approx([moments.sum(), moments[1]], abs=1e-6)


# At rest


def test_strings_carry_the_weight() -> None:
    puppet, _, pose = hanging()
    assert pose.imbalance < 1e-3  # [N] of 1000
    assert pose.slack.min() > -1e-9
    assert pose.tensions.min() > 1  # [N]; all six pull
    at = frames(pose.q, puppet)
    hooks = [at[s.body][1] + at[s.body][0] @ np.array(s.hook) for s in STRINGS]
    up = [(np.array(s.spindle) - hook) / s.length for s, hook in zip(STRINGS, hooks, strict=True)]
    weight = np.array([0, 0, puppet.mass * puppet.g])
    assert pose.tensions @ np.array(up) == pytest.approx(weight, abs=1e-3)


def test_pose_is_that_of_strings_that_hardly_give() -> None:
    puppet, start, pose = hanging()
    elastic = elastic_pose(start, STRINGS, puppet, stiffness=1e5, rounds=1)
    assert elastic.imbalance < 1e-2  # [N]
    assert elastic.tensions == pytest.approx(pose.tensions, abs=0.5)
    assert centres(elastic.q, puppet) == pytest.approx(centres(pose.q, puppet), abs=2e-2)
    # To first order V sinks by tension^2 / stiffness, the strings holding half of it.
    sunk = float(pose.tensions @ pose.tensions) / 1e5
    assert abs(pose.V - elastic.V - sunk) < 1e-2 * sunk


def test_loose_strings_do_not_pull() -> None:
    """On its torso's strings alone the puppet hangs straight, both carry half of it."""
    puppet, start, _ = hanging()
    loose = example_strings(lengths=(13.4, 13.4, 20, 20, 25, 25))
    pose = static_pose(start, loose, puppet, rounds=1)
    half = puppet.mass * puppet.g / 2
    assert list(pose.tensions) == pytest.approx([half, half, 0, 0, 0, 0], abs=1e-3)
    assert pose.slack[2:].min() > 0.1
    limbs = [pair[1] for pair in frames(pose.q, puppet).items() if pair[0] != "torso"]
    assert [R[2, 2] for R, _ in limbs] == pytest.approx([1.0] * 8, abs=1e-6)


# A limb on one string


def test_single_link_is_a_pendulum() -> None:
    chain = HangingChain((Link(0.8, 0.8, 2.0),))
    quarter = np.sqrt(0.8 / chain.g) * ellipk(np.sin(0.6) ** 2)
    run = solve_ivp(
        lambda _, x: chain.rate(x), (0, quarter), [1.2, 0.0], "DOP853", rtol=1e-11, atol=1e-12
    )
    assert run.y[0, -1] == pytest.approx(0, abs=1e-9)


def test_limb_on_a_string_keeps_its_energy_and_pulls_along_the_string() -> None:
    start = np.array([0.5, -0.4, 0.9, 0.0, 0.3, -0.6])
    run = solve_ivp(lambda _, x: HALF.rate(x), (0, 1), start, "DOP853", rtol=1e-10, atol=1e-12)
    for x in run.y.T[::5]:
        assert HALF.energy(x) == pytest.approx(HALF.energy(start), abs=1e-6)
        pull = HALF.spindle_force(x)
        assert pull @ [np.cos(x[0]), np.sin(x[0])] == pytest.approx(0, abs=1e-9)
        assert np.linalg.norm(pull) == pytest.approx(abs(HALF.tension(x)), abs=1e-9)


def test_body_on_a_string_obeys_the_textbook_double_pendulum() -> None:
    L, d, m, inertia = 2.0, 0.7, 5.0, 0.4
    chain = HangingChain((Link(L), Link(1.5, d, m, inertia)))
    (a, b), (v, w) = angles, rates = np.array([[0.5, -0.4], [1.1, 0.8]])
    a_ddot, b_ddot = chain.rate(np.concatenate([angles, rates]))[2:]
    c, s = np.cos(a - b), np.sin(a - b)
    swing = L * a_ddot + d * c * b_ddot + d * s * w**2 + chain.g * np.sin(a)
    turn = m * d * (L * c * a_ddot - L * s * v**2 + chain.g * np.sin(b))
    assert swing == pytest.approx(0, abs=1e-12)
    assert turn + (inertia + m * d**2) * b_ddot == pytest.approx(0, abs=1e-12)


def test_spindle_that_falls_leaves_the_string_slack() -> None:
    x = np.array([0.5, -0.4, 0.9, 0.0, 0.0, 0.0])
    lift = np.array([0.0, -HALF.g])
    assert HALF.rate(x, lift) == pytest.approx(np.zeros(6), abs=1e-12)
    assert HALF.spindle_force(x, lift) == pytest.approx(np.zeros(2), abs=1e-12)
    still = np.zeros(6)
    assert HALF.tension(still, np.array([0.0, 2.0])) == pytest.approx(9 * (HALF.g + 2))


# A stone on a slack string


def test_swing_goes_slack_where_its_tension_vanishes() -> None:
    stone, start = SlackStone(m=2.0, L=1.3), (0.0, 5.2)
    angle = stone.slack_angle(*start)
    assert angle is not None
    fall = stone.g / stone.L * (np.cos(start[0]) - np.cos(angle))
    rate = np.sqrt(start[1] ** 2 - 2 * fall)
    assert stone.tension(angle, rate) == pytest.approx(0, abs=1e-12)
    assert stone.slack_angle(0.0, 3.0) is None  # turns back below the spindle
    assert stone.slack_angle(0.0, 6.1) is not None
    assert stone.slack_angle(0.0, 6.2) is None  # goes round, past sqrt(5 g / L) = 6.14
    place, velocity = stone.flying(angle, float(rate))
    t = stone.arc_time(velocity)
    landed, falling = stone.flight(place, velocity, t)
    assert np.linalg.norm(landed) == pytest.approx(stone.L, abs=1e-12)
    inside = [np.linalg.norm(stone.flight(place, velocity, s * t)[0]) for s in (0.1, 0.5, 0.9)]
    assert max(inside) < stone.L
    assert stone.energy(landed, falling) == pytest.approx(
        stone.energy(*stone.flying(*start)), abs=1e-10
    )


def test_tight_string_keeps_the_moment_of_momentum() -> None:
    stone = SlackStone(m=2.0, L=1.3)
    place, velocity = np.array([0.4, 0.5]), np.array([1.0, 0.3])
    t = stone.taut_time(place, velocity)
    landed, falling = stone.flight(place, velocity, t)
    assert np.linalg.norm(landed) == pytest.approx(stone.L, abs=1e-12)
    steps = np.linspace(0, t, 50)[:-1]
    assert max(np.linalg.norm(stone.flight(place, velocity, s)[0]) for s in steps) < stone.L
    after, impulse = stone.tighten(landed, falling)
    assert landed @ after == pytest.approx(0, abs=1e-12)
    assert np.cross([*landed, 0], [*after, 0])[2] == pytest.approx(
        np.cross([*landed, 0], [*falling, 0])[2]
    )
    lost = stone.energy(landed, falling) - stone.energy(landed, after)
    assert lost == pytest.approx(impulse**2 / (2 * stone.m))
    again, swung = stone.flying(*stone.swinging(landed, after))
    assert again == pytest.approx(landed)
    assert swung == pytest.approx(after)

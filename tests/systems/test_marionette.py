"""The puppet on strings that stretch, and on strings that do not, against its oracle."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import root

import kinolab
from kinolab import systems
from kinolab.dynamics import (
    WORLD,
    Body,
    Force,
    Frame,
    Model,
    Rope,
    System,
    angle,
    closed,
    force_of,
    homogeneous,
    length,
    move,
    parameter,
    require,
    rot_y,
    toward,
)
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.systems._puppet import puppet_body
from kinolab.systems.marionette import LIFT, STRIDE
from kinolab.verification import verify
from tests.oracles.marionette import (
    HangingChain,
    Link,
    StaticPose,
    String,
    centres,
    damping_forces,
    elastic_pose,
    example_puppet,
    example_strings,
    frames,
    gradients,
    inverse_dynamics,
    kinetic_energy,
    mass_matrix,
    potential_energy,
    shifted,
    static_pose,
    string_lengths,
)
from tests.support import detail, failed

Array = NDArray[np.float64]

PUPPET = example_puppet(axes="yxz")
STRINGS = example_strings()
K, D = 2e4, 200.0  # [N/m], [N s/m]
LIFTED = (None, None, 0, 1, 2, 3)  # which lift shortens each string
HANGING = np.zeros(23)
HANGING[[2, 6]] = -1.0, 1.0
HANGING[7:] = np.tile([-0.3, 0.05, 0.02, -0.2], 4)


@cache
def model() -> Model:
    """The machine without its puppeteer."""
    return systems.get("marionette").with_feedback(None).model()


@cache
def still() -> StaticPose:
    """Where it hangs on strings that do not stretch, to some 1e-4 N."""
    return static_pose(HANGING, STRINGS, PUPPET)


def state(q: Array, v: Array, rig: Array, moving: Array) -> Array:
    """The model's state of a puppet and a rig: bar_x, bar_y and four lifts, and their rates."""
    return np.concatenate([q, rig, v, moving])


def strings_at(rig: Array) -> tuple[String, ...]:
    """The strings below a bar that has moved, some of them reeled in."""
    return tuple(
        replace(
            s,
            spindle=(s.spindle[0] + rig[0], s.spindle[1] + rig[1], s.spindle[2]),
            length=s.length - (0.0 if lift is None else rig[2 + lift]),
        )
        for s, lift in zip(STRINGS, LIFTED, strict=True)
    )


def stretches(q: Array, v: Array, rig: Array, moving: Array) -> tuple[Array, Array, Array, Array]:
    """Stretch and its rate of each string, the slopes of its length, and where it points.

    Of the unit vectors from spindles to hooks, shape (6, 3), the rate is that of the hook less that
    of the spindle.
    """
    strings = strings_at(rig)
    at = frames(q, PUPPET)
    hooks = np.array([at[s.body][1] + at[s.body][0] @ np.array(s.hook) for s in strings])
    lines = hooks - np.array([s.spindle for s in strings])
    unit = lines / np.linalg.norm(lines, axis=1)[:, None]
    _, slopes = gradients(q, strings, PUPPET)
    stretch = string_lengths(q, strings, PUPPET) - np.array([s.length for s in strings])
    reeled = np.array([0.0 if lift is None else moving[2 + lift] for lift in LIFTED])
    rates = slopes @ v - unit[:, :2] @ moving[:2] + reeled
    return stretch, rates, slopes, unit


def tensions(stretch: Array, rates: Array) -> Array:
    return np.where(stretch > 0, np.maximum(0.0, K * stretch + D * rates), 0.0)


def random_states(count: int) -> list[tuple[Array, Array, Array, Array]]:
    """States near where it hangs: some strings are taut and some are slack."""
    rng, found = np.random.default_rng(11), []
    for _ in range(count):
        q = shifted(still().q, rng.uniform(-0.1, 0.1, 22))
        rig = rng.uniform(-0.1, 0.1, 6)
        found.append((q, rng.uniform(-1, 1, 22), rig, rng.uniform(-0.5, 0.5, 6)))
    return found


# What it is


def test_state_begins_as_the_oracles_configuration() -> None:
    names = model().state_names
    assert names[:7] == ("x", "y", "z", "R_x", "R_y", "R_z", "R_w")
    limbs = ("arm_l", "arm_r", "leg_l", "leg_r")
    turns = ("swing", "spread", "twist", "bend")
    assert names[7:23] == tuple(f"{limb}_{turn}" for limb in limbs for turn in turns)
    assert names[23:25] == ("bar_x", "bar_y")
    assert model().nx == 29 + 28


def test_bodies_are_where_the_oracle_has_them() -> None:
    own = {body.name: k for k, body in enumerate(model().system.bodies)}
    order = ["torso", "head"]
    order += [f"{p} {limb.name}" for limb in PUPPET.limbs for p in ("upper", "lower")]
    for q, v, rig, moving in random_states(3):
        poses = model().frames(state(q, v, rig, moving)).reshape(-1, 3, 4)
        found = poses[[own[name] for name in order], :, 3]
        np.testing.assert_allclose(found, centres(q, PUPPET), atol=1e-12)


def test_mass_matrix_is_the_oracles() -> None:
    for q, v, rig, moving in random_states(3):
        M = model().mass_matrix(state(q, v, rig, moving))
        np.testing.assert_allclose(M[:22, :22], mass_matrix(q, PUPPET), rtol=0, atol=1e-10)
        np.testing.assert_allclose(M[:22, 22:], 0.0, atol=1e-12)  # strings are all that joins them


def test_motions_ask_for_the_forces_of_strings_and_joints_alone() -> None:
    """The oracle's inverse dynamics of kinolab's accelerations, strings taut and slack."""
    taut = []
    for q, v, rig, moving in random_states(6):
        u = np.linspace(-0.5, 0.5, 6)
        slope = model().f(state(q, v, rig, moving), u)
        stretch, rates, slopes, _ = stretches(q, v, rig, moving)
        pulls = -tensions(stretch, rates) @ slopes + damping_forces(v, PUPPET)
        # The oracle's differences in time lose digits to accelerations of 600 /s^2: its M is exact.
        asked = mass_matrix(q, PUPPET) @ slope[29:51] + inverse_dynamics(q, v, 0 * v, PUPPET)
        np.testing.assert_allclose(asked, pulls, rtol=0, atol=1e-5)  # [N], [N m] of some 2000
        np.testing.assert_array_equal(slope[51:], u)
        taut += list(stretch > 0)
    assert 6 < sum(taut) < 30


def test_energy_changes_by_what_joints_and_strings_take_and_the_rig_gives() -> None:
    """dE/dt = -c sum of squared rates - d sum of squared stretch rates + power at the spindles."""
    q = still().q
    start = state(q, np.zeros(22), np.zeros(6), np.zeros(6))
    u = np.array([0.4, -0.2, 0.3, -0.1, 0.2, 0.1])

    def parts(x: Array) -> tuple[Array, Array, Array, Array]:
        return x[:23], x[29:51], x[23:29], x[51:]

    def power(x: Array) -> float:
        q, v, rig, moving = parts(x)
        stretch, rates, _, unit = stretches(q, v, rig, moving)
        pulls = tensions(stretch, rates)
        elastic = np.where(stretch > 0, K * stretch, 0.0)
        reeled = np.array([0.0 if lift is None else moving[2 + lift] for lift in LIFTED])
        given = pulls @ (reeled - unit[:, :2] @ moving[:2])
        return float(given - (pulls - elastic) @ rates + damping_forces(v, PUPPET) @ v)

    def energy(x: Array) -> float:
        q, v, rig, moving = parts(x)
        stretch = np.maximum(stretches(q, v, rig, moving)[0], 0.0)
        stored = K / 2 * float(stretch @ stretch)
        return kinetic_energy(q, v, PUPPET) + float(potential_energy(q, PUPPET)) + stored

    solved = solve_ivp(
        lambda _, both: np.append(model().f(both[:-1], u), power(both[:-1])),
        (0.0, 0.5),
        np.append(start, 0.0),
        "DOP853",
        rtol=1e-9,
        atol=1e-9,
    )
    end = solved.y[:-1, -1]
    assert energy(end) - energy(start) == pytest.approx(solved.y[-1, -1], abs=1e-5)  # [J]
    assert abs(solved.y[-1, -1]) > 1.0


# Where it hangs


@cache
def own_poses() -> dict[float, Array]:
    """Where the machine rests on stiffer and stiffer strings, from its accelerations alone."""
    poses, near = {}, still().q - np.eye(23)[2] * 0.03  # [m]: lower, for every string to be taut
    for k in (2e4, 5e4, 1e5, 2e5, 5e5, 1e6, 2e6):

        def residual(change: Array, near: Array = near, k: float = k) -> Array:
            x = state(shifted(near, change), np.zeros(22), np.zeros(6), np.zeros(6))
            return model().f(x, np.zeros(6), k=k)[29:51]

        found = root(residual, np.zeros(22), tol=1e-13)
        assert np.abs(found.fun).max() < 1e-6  # [m/s^2]
        near = poses[k] = np.asarray(shifted(near, found.x))
    return poses


def test_pose_on_elastic_strings_tends_to_that_on_strings_that_do_not_stretch() -> None:
    """It sags in inverse proportion to the stiffness."""
    fixed = centres(still().q, PUPPET)
    sags = [np.abs(centres(own_poses()[k], PUPPET) - fixed).max() for k in (2e4, 2e5, 2e6)]
    assert sags[0] < 0.05  # [m] of 13
    assert sags[0] / sags[1] == pytest.approx(10, rel=0.02)
    assert sags[1] / sags[2] == pytest.approx(10, rel=0.002)


def test_pose_on_elastic_strings_is_the_least_energy() -> None:
    """Found by BFGS on the oracle's energies."""
    elastic = elastic_pose(still().q, STRINGS, PUPPET, K)
    found = centres(own_poses()[K], PUPPET)
    np.testing.assert_allclose(found, centres(elastic.q, PUPPET), rtol=0, atol=1e-5)  # [m]


@pytest.mark.parametrize(
    ("method", "order", "steps"), [("euler", 1, 1000), ("rosenbrock", 2, 80), ("rk4", 4, 80)]
)
def test_steps_have_their_order_while_all_strings_are_taut(
    method: str, order: int, steps: int
) -> None:
    """From where it hangs, in a gentle motion: halving the step divides the error by 2^order."""
    v = np.random.default_rng(5).uniform(-0.02, 0.02, 22)
    start, u = state(own_poses()[K], v, np.zeros(6), np.zeros(6)), np.full(6, 0.05)
    exact = solve_ivp(
        lambda _, x: model().f(x, u), (0, 0.2), start, "DOP853", rtol=1e-13, atol=1e-13
    ).y[:, -1]
    assert (stretches(exact[:23], exact[29:51], exact[23:29], exact[51:])[0] > 0).all()

    def error(steps: int) -> float:
        x = start
        for _ in range(steps):
            x = model().step(x, u, 0.2 / steps, method=method)
        return float(np.abs(x - exact).max())

    assert np.log2(error(steps) / error(2 * steps)) == pytest.approx(order, abs=0.25)


# The puppeteer


def led(machine: Model, start: Array, u: Array, seconds: float) -> Array:
    """States every tenth of a second, shape (steps + 1, nx)."""
    path = [start]
    for _ in range(round(10 * seconds)):
        path.append(machine.step(path[-1], u, 0.1, substeps=16))
    return np.array(path)


def test_puppeteer_brings_a_swing_to_rest_that_lasts_without_one() -> None:
    v = np.zeros(22)
    v[:2] = 0.3, 0.2  # [m/s] of the torso, the limbs along
    start = state(own_poses()[K], v, np.zeros(6), np.zeros(6))
    led_by, left_alone = (
        np.abs(led(machine, start, np.zeros(machine.nu), 25.0)[-75:, 29:31]).max()
        for machine in (systems.get("marionette").model(), model())
    )
    assert led_by < 0.1 * 0.3  # [m/s] in the last period of 7.5 s; the limbs still swing
    assert left_alone > 0.8 * 0.3


def test_knees_are_lifted_in_turn_as_the_puppet_is_led_along() -> None:
    """Never both at once, the left one first, and once for each stride of the bar."""
    made = systems.get("marionette").model()
    start = state(own_poses()[K], np.zeros(22), np.zeros(6), np.zeros(6))
    path = led(made, start, np.array([0.5, 0.0, 0.0, 0.0, 0.0]), 15.0)
    left, right = (path[:, made.state_names.index(f"lift_knee_{side}")] > LIFT / 2 for side in "lr")
    assert not (left & right).any()
    assert 0 < left.argmax() < right.argmax()
    steps = np.count_nonzero(np.diff(left.astype(int)) == 1)
    assert steps + np.count_nonzero(np.diff(right.astype(int)) == 1) == np.ceil(
        path[-1, 23] / STRIDE
    )
    assert path[-1, 23] > 3 * STRIDE  # [m]


# A limb on one string


def limb_on_a_rope(k: float) -> Model:
    """An arm in a vertical plane, its root on a rope of 2 m from the origin."""
    x, z, a, b = length("x"), length("z"), angle("a"), angle("b")
    shoulder = move(x, 0, z)
    upper = shoulder @ rot_y(-a)
    lower = upper @ move(0, 0, -1.5) @ rot_y(-b)
    links = [
        Body(name, joint @ move(0, 0, -0.75), mass=mass, inertia=1.0)
        for name, joint, mass in (("upper", upper, 5.0), ("lower", lower, 4.0))
    ]
    rope = Rope(between=(WORLD, shoulder), stiffness=k, length=2.0, damping=np.sqrt(9.0 * k))
    return System("limb", bodies=links, gravity=toward("-z", 9.81), efforts=[rope]).model()


@pytest.mark.parametrize(("k", "error"), [(1e5, 1e-2), (1e7, 1e-3)])
def test_limb_on_a_rope_is_a_pendulum_of_three_links(k: float, error: float) -> None:
    """Closer with sqrt(k): the rope bounces at first, at a speed of tension / damping."""
    chain = HangingChain((Link(2.0), Link(1.5, 0.75, 5.0, 1.0), Link(1.5, 0.75, 4.0, 1.0)))
    begin, t = np.array([0.5, -0.4, 0.9, 0.0, 0.0, 0.0]), (0.0, 1.0)
    taut = 2.0 + chain.tension(begin) / k
    start = [taut * np.sin(0.5), -taut * np.cos(0.5), -0.4, 1.3, 0.0, 0.0, 0.0, 0.0]
    limb = limb_on_a_rope(k)
    assert limb.state_names[:4] == ("x", "z", "a", "b")
    found = solve_ivp(lambda _, x: limb.f(x), t, start, "DOP853", rtol=1e-9, atol=1e-10).y[:, -1]
    swung = solve_ivp(lambda _, x: chain.rate(x), t, begin, "DOP853", rtol=1e-10, atol=1e-11)
    string, upper, lower = swung.y[:3, -1]
    place = 2.0 * np.sin(string), -2.0 * np.cos(string)
    np.testing.assert_allclose(found[:4], [*place, upper, lower - upper], rtol=0, atol=error)


# On strings that do not stretch


BUST = replace(PUPPET, limbs=PUPPET.limbs[:1])
BUST_STRINGS = STRINGS[:3]


@cache
def still_bust() -> StaticPose:
    """Where it hangs with its left arm alone, to some 1e-4 N."""
    return static_pose(HANGING[:11], BUST_STRINGS, BUST)


def taut_marionette() -> System:
    """The same puppet on strings that do not stretch; a hand below may lift its torso.

    Its left arm is its only limb: the others and their strings would be more of the same, and the
    whole puppet's equations take five times as long.
    """
    puppet = puppet_body()
    held = [
        closed(s.length - _span(move(*s.spindle), hook), f"string {name}")
        for s, (name, hook) in zip(BUST_STRINGS, puppet.hooks.items(), strict=False)
    ]
    others = ("arm_r", "hand_r", "leg_", "shoe_")
    one_armed = [body for body in puppet.bodies if not any(n in body.name for n in others)]
    return System(
        "taut_marionette",
        bodies=one_armed,
        gravity=toward("-z", parameter("g", 9.81, "m/s^2")),
        constraints=held,
        requirements=[require(force_of(string), f"{string.name} pulls") for string in held],
        inputs=[Force("lift", on=puppet.bodies[0], along=WORLD.z, limit=2000.0)],
        efforts=puppet.joints[: 4 * len(BUST.limbs)],
        velocities="all",  # a choice that serves where it hangs does not serve everywhere
    )


def _span(spindle: Frame, hook: Frame) -> sympy.Expr:
    line = (homogeneous(hook) - homogeneous(spindle))[:3, 3]
    return sympy.sqrt(line.dot(line))


@cache
def taut_model() -> Model:
    return taut_marionette().model()


def at_rest() -> Array:
    """The state of the puppet where it hangs still."""
    return np.concatenate([still_bust().q, np.zeros(taut_model().nx - 11)])


def test_pose_on_strings_is_the_least_potential_energy_that_they_allow() -> None:
    """SLSQP's minimum is at rest, all strings are as long as they are, and pull as it says."""
    x = at_rest()
    assert still_bust().slack.min() > -1e-9
    np.testing.assert_allclose(taut_model().constraint_residual(x), 0.0, atol=1e-8)
    np.testing.assert_allclose(taut_model().f(x, [0.0]), 0.0, atol=1e-6)  # [m/s^2]
    found = taut_model().constraint_forces(x, [0.0])
    assert found == pytest.approx(still_bust().tensions, abs=1e-4)  # [N] of 680 in all
    assert found.min() > 1.0
    np.testing.assert_allclose(taut_model().requirements(x, [0.0]), found, rtol=1e-12)


def test_tensions_are_in_proportion_to_gravity() -> None:
    found = taut_model().constraint_forces(at_rest(), [0.0], g=1.62)
    assert found == pytest.approx(still_bust().tensions * 1.62 / 9.81, abs=1e-4)


def hanging_problem(model: Model) -> PlanningTask:
    """From where it hangs to wherever it gets."""
    start = dict(zip(model.coordinate_names, still_bust().q, strict=True))
    attitude = [start.pop(f"R_{entry}") for entry in "xyzw"]
    return kinolab.load(
        {
            "system": model.system,
            "world": {"bounds": {axis: [-30, 30] for axis in "xyz"}},
            "start": {**start, "R": attitude},
            "goal": {"x": 0.0, "tolerance": 5.0},
            "integration": {"step": 0.05},
        }
    )


@pytest.mark.parametrize(("lift", "wrong"), [(300.0, set()), (1500.0, {"requirements"})])
def test_a_motion_in_which_strings_would_have_to_push_is_refused(
    lift: float, wrong: set[str]
) -> None:
    """It weighs 677 N: lifted by more, it leaves its strings."""
    problem = hanging_problem(taut_model())
    t, u = np.linspace(0, 0.2, 5), np.full((4, 1), lift)
    certificate = verify(problem, resimulate(problem, t, u))
    assert failed(certificate) == wrong
    if wrong:
        assert "pulls" in detail(certificate, "requirements")

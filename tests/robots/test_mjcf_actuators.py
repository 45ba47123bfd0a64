"""Servos, filters, tendons, borne weight and springs of balls move as MuJoCo says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.robots import read_mjcf

mujoco: Any = pytest.importorskip("mujoco")
spelled: Any = pytest.importorskip("tests.robots.against_pinocchio").spelled

AGREE = 1e-9  # relative to the largest acceleration
STATES = 60


class Twins:
    """kinolab's machine of a file, and MuJoCo's, which clips forces and controls as it does.

    Args:
        file: The file.
        locked: Positions of joints that do not move, by name.
    """

    def __init__(self, file: Path, locked: Mapping[str, float] | None = None) -> None:
        self.system = read_mjcf(file, locked=locked, servo_commands=True)
        self.own, self.locked = self.system.model(), locked or {}
        self.model: Any = mujoco.MjModel.from_xml_path(str(file))
        bits = mujoco.mjtDisableBit
        self.model.opt.disableflags |= int(bits.mjDSBL_LIMIT) | int(bits.mjDSBL_CONTACT)
        self.data = mujoco.MjData(self.model)
        self.x, self.u = np.array(self.own.rest()), np.zeros(self.own.nu)
        self.moving: dict[int, int] = {}  # kinolab's entry of a state by MuJoCo's velocity

    def draw(self, generator: np.random.Generator, spread: float = 1.0) -> None:
        """Draw a state, and commands within their limits; angles of balls are up to ``spread``."""
        names, low_high = list(self.own.state_names), self.own.control_bounds
        for j in range(self.model.njnt):
            self._draw_joint(generator, j, spread)
        self.u[:] = generator.uniform(*low_high.T)
        for k in range(self.model.nu):
            name = self.model.actuator(k).name
            self.data.ctrl[k] = self.u[self.own.control_names.index(name)]
            if f"{name}_act" in names:
                at = names.index(f"{name}_act")
                ends = np.clip(self.own.state_bounds[at], -2.0, 2.0)
                self.x[at] = generator.uniform(*ends)
                self.data.act[self.model.actuator_actadr[k]] = self.x[at]
        mujoco.mj_forward(self.model, self.data)

    def _draw_joint(self, generator: np.random.Generator, j: int, spread: float) -> None:
        model, data, names = self.model, self.data, list(self.own.state_names)
        name, kind = spelled(model.joint(j).name), mujoco.mjtJoint(int(model.jnt_type[j]))
        q, v = int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])
        if name in self.locked:
            data.qpos[q] = self.locked[name]
            return
        places, turns = [f"{name}_at_{k}" for k in "xyz"], [f"{name}_w{k}" for k in "xyz"]
        rates = [f"{place}_dot" for place in places] + turns
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            data.qpos[q : q + 3] = generator.normal(size=3)
            self.x[[names.index(place) for place in places]] = data.qpos[q : q + 3]
            q += 3
        elif kind == mujoco.mjtJoint.mjJNT_BALL:
            rates = turns
        else:
            data.qpos[q] = self.x[names.index(name)] = spread * generator.normal()
            rates = [f"{name}_dot"]
        if rates[-1] == turns[-1]:
            axis, half = generator.normal(size=3), spread * generator.uniform(-0.5, 0.5)
            axis *= math.sin(half) / np.linalg.norm(axis)
            data.qpos[q : q + 4] = math.cos(half), *axis
            first = self.own.attitudes[name]
            self.x[first : first + 4] = *axis, math.cos(half)
        data.qvel[v : v + len(rates)] = generator.normal(size=len(rates))
        entries = [names.index(rate) for rate in rates]
        self.x[entries] = data.qvel[v : v + len(rates)]
        self.moving |= dict(enumerate(entries, v))

    @property
    def clipped(self) -> bool:
        """Whether MuJoCo clips a force, by what it is with wider limits."""
        data, model = self.data, self.model
        given = np.array(data.qfrc_actuator)
        limits = model.actuator_forcelimited, model.jnt_actfrclimited, model.tendon_actfrclimited
        before = [np.array(one) for one in limits]
        for one in limits:
            one[...] = 0
        mujoco.mj_forward(model, data)
        free = np.array(data.qfrc_actuator)
        for one, own in zip(limits, before, strict=True):
            one[...] = own
        mujoco.mj_forward(model, data)
        return bool(np.abs(free - given).max(initial=0.0) > 0.0)

    def difference(self) -> float:
        """Return by how much accelerations and rates of filters differ, beside the largest one."""
        model, data = self.model, self.data
        M = np.zeros((model.nv, model.nv))
        for row, unit in zip(M, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        free = np.eye(model.nv)[:, sorted(self.moving)]
        pushed = free.T @ (data.qfrc_passive + data.qfrc_actuator - data.qfrc_bias)
        theirs = np.concatenate([np.linalg.solve(free.T @ M @ free, pushed), data.act_dot])
        entries = [self.moving[v] for v in sorted(self.moving)]
        entries += range(self.own.nx - model.na, self.own.nx)
        ours = np.array(self.own.f(self.x, self.u))[entries]
        return float(np.abs(ours - theirs).max() / max(1.0, np.abs(theirs).max()))


def agree(twins: Twins, *, spread: float = 1.0, seed: int = 1) -> None:
    """Compare at random states with random commands, where MuJoCo clips nothing.

    Requirements hold just where it does not.
    """
    generator, clipped, compared = np.random.default_rng(seed), 0, 0
    while compared < STATES:
        twins.draw(generator, spread)
        margins = twins.own.requirements(twins.x, twins.u)
        assert twins.clipped == bool((margins < 0.0).any()), (margins, twins.x, twins.u)
        if twins.clipped:
            clipped += 1
            continue
        compared += 1
        assert twins.difference() <= AGREE
    assert (clipped > 0) == bool(len(twins.system.requirements))


ARM = """<mujoco model="arm">
  <compiler angle="radian"/>
  <option gravity="0.4 0 -9.81"/>
  <worldbody>
    <body name="upper" pos="0 0 1" {upper}>
      <joint name="shoulder" axis="0 1 0" damping="0.2" armature="0.05" ref="0.3" {shoulder}/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0.1" size="0.03" mass="1"/>
      <body name="lower" pos="0.4 0 0.1" {lower}>
        <joint name="elbow" axis="0 1 0.2" pos="0.02 0 0" {elbow}/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="0.5"/>
        <body name="hand" pos="0.3 0 0" euler="0.2 0.3 0" {hand}>
          <geom type="box" size="0.05 0.02 0.04" pos="0.02 0.01 0" mass="0.3"/>
          <body name="finger" pos="0.05 0 0">
            <joint name="grip" type="slide" axis="1 0 0.3" stiffness="3"/>
            <geom size="0.02" mass="0.1"/>
            <site name="tip" pos="0.01 0 0" euler="0.1 0 0"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  {after}
</mujoco>"""
PARTS = dict.fromkeys(("upper", "shoulder", "lower", "elbow", "hand", "after"), "")
TENDON = """<tendon><fixed name="cord" {}><joint joint="elbow" coef="0.5"/>
  <joint joint="grip" coef="-2"/></fixed></tendon>"""


def twins(
    tmp_path: Path, actuators: str = "", locked: Mapping[str, float] | None = None, **parts: str
) -> Twins:
    """Return an arm with actuators, and with parts in its elements."""
    after = f"{parts.pop('after', '')}<actuator>{actuators}</actuator>"
    file = tmp_path / "arm.xml"
    file.write_text(ARM.format(**PARTS | parts | {"after": after}))
    return Twins(file, locked)


COMMANDS = 'ctrlrange="-0.4 1.5"'
LAW = 'biastype="affine" gainprm="9" biasprm="3 -4 -0.5"'
SERVOS = {
    "positions": (
        f'<position name="a" joint="shoulder" kp="30" kv="2" {COMMANDS}/>'
        f'<position name="b" joint="elbow" kp="20" dampratio="0.7" gear="-1.5" {COMMANDS}/>'
    ),
    "a position with a limit": (
        f'<position name="a" joint="shoulder" kp="30" kv="2" forcerange="-20 35" {COMMANDS}/>'
    ),
    "a velocity with a limit": (
        f'<velocity name="a" joint="grip" kv="12" gear="0.5" forcerange="-9 8" {COMMANDS}/>'
    ),
    "any law": (
        f'<general name="a" joint="shoulder" {LAW} {COMMANDS}/>'
        f'<general name="b" jointinparent="elbow" {LAW} gear="-2" forcerange="-6 12" {COMMANDS}/>'
    ),
    "of a tendon": (
        '<position name="a" tendon="cord" kp="30" kv="2" gear="1.5" forcerange="-30 25" '
        f"{COMMANDS}/>"
    ),
    "with a gain that changes": (
        f'<general name="a" joint="elbow" gaintype="affine" gainprm="2 -3 0.5" {COMMANDS}/>'
        '<damper name="b" joint="shoulder" kv="3" ctrlrange="0.2 1"/>'
    ),
    "beside a motor": (
        f'<position name="a" joint="elbow" kp="30" {COMMANDS}/>'
        '<motor name="b" joint="elbow" ctrlrange="-3 2"/>'
    ),
}


@pytest.mark.parametrize("name", SERVOS)
def test_a_servo_takes_its_command(name: str, tmp_path: Path) -> None:
    """Its input is MuJoCo's ctrl; a plan keeps its force from where MuJoCo would clip it."""
    agree(twins(tmp_path, SERVOS[name], after=TENDON.format("")))


def test_a_joint_limits_the_force_of_its_servo(tmp_path: Path) -> None:
    servo = f'<position name="a" joint="elbow" kp="30" kv="2" gear="2" {COMMANDS}/>'
    agree(twins(tmp_path, servo, elbow='actuatorfrcrange="-20 40"'))


def test_a_tendon_limits_the_force_of_its_servo(tmp_path: Path) -> None:
    servo = f'<position name="a" tendon="cord" kp="30" gear="2" forcerange="-15 60" {COMMANDS}/>'
    agree(twins(tmp_path, servo, after=TENDON.format('actuatorfrcrange="-20 30"')))


FILTERED = {
    "a motor": '<general name="a" joint="elbow" dyntype="{}" dynprm="0.2" gainprm="4" {}/>',
    "a motor with a limit": (
        '<general name="a" joint="elbow" dyntype="{}" dynprm="0.2" gainprm="4" '
        'forcerange="-1 3" gear="-2" {}/>'
    ),
    "a motor of a tendon": (
        '<general name="a" tendon="cord" dyntype="{}" dynprm="0.2" gainprm="4" gear="3" {}/>'
    ),
    "a thruster": (
        '<general name="a" site="tip" dyntype="{}" dynprm="0.2" gainprm="4" '
        'gear="1 2 0 0 0.3 0.1" forcerange="-1 30" {}/>'
    ),
    "a servo with a limit": (
        '<general name="a" joint="shoulder" dyntype="{}" dynprm="0.3" forcerange="-20 35" '
        'biastype="affine" gainprm="30" biasprm="1 -30 -2" {}/>'
    ),
}


@pytest.mark.parametrize("kind", ["integrator", "filter", "filterexact"])
@pytest.mark.parametrize("name", FILTERED)
def test_a_filter_is_a_state(name: str, kind: str, tmp_path: Path) -> None:
    limits = f'{COMMANDS} actlimited="true" actrange="-0.3 1.2"'
    agree(twins(tmp_path, FILTERED[name].format(kind, limits), after=TENDON.format("")))


@pytest.mark.parametrize(
    ("actuator", "limits"),
    [
        (f'<position name="a" joint="elbow" kp="5" timeconst="0.3" {COMMANDS}/>', (-0.4, 1.5)),
        (f'<cylinder name="a" joint="elbow" area="2" bias="1 -2 -3" {COMMANDS}/>', (-0.4, 1.5)),
        (f'<intvelocity name="a" joint="elbow" kp="5" actrange="-1 2" {COMMANDS}/>', (-1.0, 2.0)),
        ('<general name="a" joint="elbow" dyntype="filter" ctrlrange="1 2"/>', (0.0, 2.0)),
        ('<general name="a" joint="elbow" dyntype="integrator" ctrlrange="1 2"/>',
         (-math.inf, math.inf)),
        ('<general name="a" joint="elbow" dyntype="filter" gainprm="-4" forcerange="-1 2" '
         'ctrlrange="-1 1"/>', (-0.5, 0.25)),
    ],
)  # fmt: skip
def test_the_state_of_a_filter_has_limits(
    actuator: str, limits: tuple[float, float], tmp_path: Path
) -> None:
    """A lag never leaves what its commands span with 0, where it begins in MuJoCo."""
    found = twins(tmp_path, actuator)
    (state,) = found.system.states
    assert (state.name, state.limits) == ("a_act", limits)
    agree(found)


def test_a_command_is_told_with_its_unit(tmp_path: Path) -> None:
    actuators = (
        f'<position name="angle" joint="elbow" kp="5" {COMMANDS}/>'
        f'<velocity name="speed" joint="grip" kv="5" {COMMANDS}/>'
        f'<intvelocity name="rate" joint="elbow" kp="5" actrange="-1 2" {COMMANDS}/>'
        f'<position name="either" tendon="cord" kp="5" {COMMANDS}/>'
        f'<general name="law" joint="elbow" {LAW} {COMMANDS}/>'
        f'<general name="slow" joint="elbow" dyntype="filter" {COMMANDS}/>'
    )
    found = twins(tmp_path, actuators, after=TENDON.format("")).system
    units = {entry.name: entry.unit for entry in found.inputs}
    assert units == {
        **{"angle": "rad", "speed": "m/s", "rate": "rad/s"},
        **{"either": "", "law": "", "slow": ""},
    }
    assert {entry.name: entry.unit for entry in found.states} == {"rate_act": "rad", "slow_act": ""}


def test_a_filter_that_acts_a_step_early_is_told(tmp_path: Path) -> None:
    """Steps of time are not of the machine; a note says what is not read."""
    early = f'<general name="a" joint="elbow" dyntype="filter" actearly="true" {COMMANDS}/>'
    (note,) = twins(tmp_path, early).system.notes
    assert note[1].endswith("actearly is a matter of time steps, and is not read: a.")


def test_weight_is_borne_at_centres_of_mass(tmp_path: Path) -> None:
    """Of bodies that move and one that is fixed to such a one; more than 1 lifts."""
    parts = {"upper": 'gravcomp="1"', "lower": 'gravcomp="0.4"', "hand": 'gravcomp="1.7"'}
    agree(twins(tmp_path, **parts))
    agree(twins(tmp_path, locked={"elbow": 0.4}, **parts))


def test_an_arm_that_bears_its_weight_stays_where_it_is(tmp_path: Path) -> None:
    file = tmp_path / "arm.xml"
    body = '<body gravcomp="1"><joint name="{0}" axis="0 1 0"/><geom size="0.1" pos="1 0 0"/>{1}'
    inner = body.format("b", "</body>")
    file.write_text(f"<mujoco><worldbody>{body.format('a', inner)}</body></worldbody></mujoco>")
    model = read_mjcf(file).model()
    assert np.abs(model.f([0.3, 0.7, 0.0, 0.0], [])).max() < 1e-13


def test_weight_that_actuators_bear_is_borne(tmp_path: Path) -> None:
    """A limit of what all of them push would clip it."""
    parts = {"upper": 'gravcomp="1"', "hand": 'gravcomp="0.5"'}
    servo = f'<position name="a" joint="shoulder" kp="30" {COMMANDS}/>'
    agree(twins(tmp_path, servo, shoulder='actuatorgravcomp="true"', **parts))
    limited = 'actuatorgravcomp="true" actuatorfrcrange="-50 50"'
    with pytest.raises(InputError, match="joint shoulder has actuatorgravcomp, and a limit"):
        twins(tmp_path, servo, shoulder=limited, **parts)


@pytest.mark.parametrize(
    "attributes",
    [
        'stiffness="4" springlength="0.2"',
        'stiffness="4" springlength="-0.3 0.6"',
        'stiffness="4 3 10" springlength="-0.3 0.6" damping="0.5 0.3 0.2"',
        'damping="0.7" armature="0.6"',
    ],
)
def test_a_fixed_tendon_resists(attributes: str, tmp_path: Path) -> None:
    """Its spring is slack between two lengths; its armature is felt by its length alone."""
    agree(twins(tmp_path, after=TENDON.format(attributes)))


def test_a_finger_is_pulled_by_a_tendon(tmp_path: Path) -> None:
    joints = "".join(
        f'<body pos="0.{4 * bool(k)} 0 0"><joint name="j{k}" axis="0 1 0" stiffness="0.05" '
        'damping="0.01"/><geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05" mass="0.02"/>'
        for k in range(3)
    )
    arms = "".join(f'<joint joint="j{k}" coef="{0.9 - 0.2 * k}"/>' for k in range(3))
    file = tmp_path / "finger.xml"
    file.write_text(
        f"""<mujoco><worldbody>{joints}</body></body></body></worldbody>
        <tendon><fixed name="flexor" stiffness="0.2" damping="0.03" springlength="0 0.5">{arms}
        </fixed></tendon><actuator><general name="pull" tendon="flexor" dyntype="filterexact"
        dynprm="0.04" gainprm="-2" ctrlrange="0 1"/></actuator></mujoco>"""
    )
    agree(Twins(file))


def test_commands_of_a_gripper_move_both_of_its_fingers(tmp_path: Path) -> None:
    """Fingers of 0.1 kg, of which one follows the other: 0.2 q'' = F = 10 (u - q) - 2 q'."""
    fingers = "".join(
        f'<body name="{k}" pos="0 {k} 0"><joint name="f{k}" type="slide" axis="0 {1 - 2 * k} 0"/>'
        '<geom size="0.05" mass="0.1"/></body>'
        for k in range(2)
    )
    file = tmp_path / "hand.xml"
    file.write_text(f"""<mujoco><worldbody>{fingers}</worldbody>
      <tendon><fixed name="t"><joint joint="f0" coef="0.5"/><joint joint="f1" coef="0.5"/></fixed>
      </tendon><equality><joint joint1="f1" joint2="f0"/></equality><actuator><position name="grip"
      tendon="t" kp="10" kv="2" ctrlrange="0 1" forcerange="-3 3"/></actuator></mujoco>""")
    model = read_mjcf(file, servo_commands=True).model()
    assert model.f([0.1, 0.3], [0.25])[1] == pytest.approx((10 * 0.15 - 2 * 0.3) / 0.2, rel=1e-12)
    assert model.requirements([0.1, 0.3], [0.25]) == pytest.approx((3 - 0.9, 3 + 0.9), rel=1e-12)


def test_a_tendon_with_a_locked_joint_is_as_long_as_that_makes_it(tmp_path: Path) -> None:
    servo = f'<position name="a" tendon="cord" kp="30" kv="2" forcerange="-30 25" {COMMANDS}/>'
    cord = TENDON.format('stiffness="4" springlength="0.2"')
    agree(twins(tmp_path, servo, locked={"grip": 0.1}, after=cord))


def test_the_length_of_a_tendon_has_limits(tmp_path: Path) -> None:
    cord = TENDON.format('range="-0.5 0.8" limited="true"')
    own = twins(tmp_path, after=cord).own
    x = np.array(own.rest())
    for elbow, grip, margins in ((1.2, 0.1, (0.4, 0.9)), (1.2, -0.3, (-0.4, 1.7))):
        x[[own.state_names.index(name) for name in ("elbow", "grip")]] = elbow, grip
        assert own.requirements(x, []) == pytest.approx(margins, abs=1e-12)


def test_dry_friction_of_a_tendon_slows_its_length(tmp_path: Path) -> None:
    """-f tanh(L_dot / 0.01) along L = 2 q, on an inertia of 0.5 kg m^2."""
    file = tmp_path / "wheel.xml"
    file.write_text("""<mujoco><option gravity="0 0 0"/><worldbody><body><joint name="q"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.5 0.5 0.5"/></body></worldbody>
      <tendon><fixed frictionloss="0.3"><joint joint="q" coef="2"/></fixed></tendon></mujoco>""")
    slope = read_mjcf(file).model().f([0.0, 0.004], [])[1]
    assert slope == pytest.approx(-0.3 * math.tanh(0.8) * 2 / 0.5, rel=1e-12)


BALL = """<mujoco><option gravity="0.3 0 -9.81"/><worldbody>
  <body pos="0 0 1" quat="1 0.2 -0.4 0.3">
    <joint name="socket" type="{}" {}/>
    <inertial pos="0.1 0.05 0" quat="1 0.2 0 0" mass="1.2" diaginertia="0.2 0.3 0.25"/>
    <body pos="0 0 -0.3"><joint name="knee" axis="1 0 0"/><geom size="0.1" mass="0.4"/></body>
  </body></worldbody></mujoco>"""


@pytest.mark.parametrize("spread", [1e-7, 1e-3, 1.0, 2 * math.pi])
@pytest.mark.parametrize("kind", ["ball", "free"])
@pytest.mark.parametrize("stiffness", ["7", "-2 0 5"])
def test_a_ball_joint_has_a_spring(
    stiffness: str, kind: str, spread: float, tmp_path: Path
) -> None:
    """Along the axis of the shorter turn from where it is at rest, also next to that."""
    file = tmp_path / "ball.xml"
    file.write_text(BALL.format(kind, f'stiffness="{stiffness}" damping="0.3 0.1"'))
    agree(Twins(file), spread=spread)


def test_a_ball_joint_s_spring_keeps_energy_and_is_linear_at_rest(tmp_path: Path) -> None:
    """A ball of 0.2 kg m^2 with 7 N m/rad swings with w^2 = 35 at rest; V = k angle^2 / 2."""
    file = tmp_path / "ball.xml"
    file.write_text("""<mujoco><option gravity="0 0 0"/><worldbody><body>
      <joint name="socket" type="ball" stiffness="7"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.2 0.2 0.2"/></body></worldbody></mujoco>""")
    model = read_mjcf(file).model()
    x = np.array(model.rest())
    first, rates = model.attitudes["socket"], [*model.state_names].index("socket_wx")
    A, _ = model.jacobian(x, [])
    # the vector part of the quaternion is half the angle
    assert np.allclose(A[rates : rates + 3, first : first + 3], -2 * 35 * np.eye(3), atol=1e-9)
    for angle in (0.3, 3.0, -3.1):
        x[first : first + 4] = (
            0.6 * math.sin(angle / 2),
            0,
            0.8 * math.sin(angle / 2),
            math.cos(angle / 2),
        )
        assert model.energy(x)[1] == pytest.approx(7 * angle**2 / 2, rel=1e-12)


def test_a_spring_of_a_ball_with_a_kink_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "ball.xml"
    file.write_text(BALL.format("ball", 'stiffness="7 2 1"'))
    with pytest.raises(InputError, match="coefficient 2 of the square of an angle"):
        read_mjcf(file)


SERVO_ARM = """<mujoco model="arm">
  <compiler angle="radian"/>
  <option integrator="RK4"/>
  <worldbody>
    <body name="upper" pos="0 0 1" gravcomp="1">
      <joint name="shoulder" axis="0 1 0" range="-2 2"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="1"/>
      <body name="lower" pos="0.4 0 0" gravcomp="0.9">
        <joint name="elbow" axis="0 1 0" range="-2.5 2.5"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="0.5"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="lift" joint="shoulder" kp="40" kv="6" ctrlrange="-2 2" forcerange="-12 12"/>
    <position name="bend" joint="elbow" kp="10" kv="1.5" ctrlrange="-2.5 2.5" forcerange="-3 3"/>
  </actuator>
</mujoco>"""
SCENARIO = """schema = 1
title = "Commands of servos move an arm that bears most of its weight"
[system]
file = "arm.xml"
servo_commands = true
[bounds]
shoulder_dot = [-4, 4]
elbow_dot = [-4, 4]
[start]
shoulder = 0.6
[goal]
shoulder = -0.6
elbow = 0.8
tolerance = 0.1
at_rest = true
[planner]
improve = 0
"""


def test_commands_of_a_plan_move_mujoco_s_arm_to_the_goal(tmp_path: Path) -> None:
    """From the file to a verified plan, whose commands MuJoCo holds for a step each."""
    (tmp_path / "arm.xml").write_text(SERVO_ARM)
    (tmp_path / "arm.toml").write_text(SCENARIO)
    problem = kinolab.load(tmp_path / "arm.toml")
    plan = problem.solve(seed=1)
    assert plan.certificate.passed
    model: Any = mujoco.MjModel.from_xml_string(SERVO_ARM)
    data, way, most = mujoco.MjData(model), plan.trajectory, 0.0
    data.qpos[:], data.qvel[:] = way.x[0, :2], way.x[0, 2:]
    for held, command in zip(np.diff(way.t), way.u, strict=True):
        model.opt.timestep, data.ctrl[:] = held / 50, command
        for _ in range(50):
            mujoco.mj_step(model, data)
            most = max(most, float(np.abs(data.actuator_force / [12.0, 3.0]).max()))
    assert np.abs(np.concatenate([data.qpos, data.qvel]) - way.x[-1]).max() < 1e-6
    assert np.abs(data.qpos - [-0.6, 0.8]).max() <= 0.1 + 1e-6
    assert 0.5 < most < 1.0  # the servos work hard, and nothing is clipped

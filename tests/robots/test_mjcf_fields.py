"""What a model of MuJoCo's says counts, or is refused by name: forces, limits, flags, actuators."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinolab.dynamics.language.inputs import bounds_of
from kinolab.errors import InputError
from kinolab.robots import read_mjcf
from kinolab.robots.mjcf import mjcf_fields

mujoco: Any = pytest.importorskip("mujoco")

AGREE = 1e-9  # relative to the largest acceleration
ARM = """<mujoco>
  <compiler angle="radian"/>
  <option gravity="0.5 0 -9.81">{option}</option>
  {extra}
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="hip" axis="0 1 0" {hip}/>
      <geom name="bone" type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="1" {bone}/>
      <body name="shin" pos="0.4 0 0" {shin}>
        <joint name="knee" type="slide" axis="1 0 0.2" {knee}/>
        <geom type="box" size="0.1 0.05 0.05" mass="0.7"/>
        <site name="tip" pos="0.1 0 0"/>
      </body>
    </body>
    <site name="base"/>
    {world}
  </worldbody>
  {after}
</mujoco>"""
PARTS = dict.fromkeys(("option", "extra", "hip", "knee", "bone", "shin", "world", "after"), "")
SPRINGS = {
    "hip": 'stiffness="4 3 10" damping="0.5 0.3 0.2" springref="0.2"',
    "knee": 'stiffness="-2 0 6" damping="0.1" ref="0.1"',
}


def written(tmp_path: Path, **parts: str) -> Path:
    """Return a file with an arm, and parts of it."""
    file = tmp_path / "arm.xml"
    file.write_text(ARM.format(**PARTS | parts))
    return file


def agree(file: Path) -> None:
    """Compare accelerations with MuJoCo's at random states, both without inputs."""
    own = read_mjcf(file).model()
    model: Any = mujoco.MjModel.from_xml_path(str(file))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
    data, generator = mujoco.MjData(model), np.random.default_rng(2)
    for _ in range(5):
        data.qpos[:], data.qvel[:] = generator.normal(size=(2, model.nv))
        mujoco.mj_forward(model, data)
        ours = own.f(np.concatenate([data.qpos, data.qvel]), np.zeros(own.nu))[model.nv :]
        theirs = np.array(data.qacc)
        assert np.abs(ours - theirs).max() <= AGREE * max(1.0, np.abs(theirs).max())


def refused(file: Path, *words: str, **options: Any) -> None:
    """Check that a file is refused with some words, and read without them."""
    with pytest.raises(InputError) as caught:
        read_mjcf(file, **options)
    said = str(caught.value)
    assert all(word in said for word in words), said


def test_springs_and_friction_of_higher_powers(tmp_path: Path) -> None:
    """A negative stiffness, which an unstable joint has, counts like any other."""
    agree(written(tmp_path, **SPRINGS))


def test_a_stiffening_spring_as_calculated_by_hand(tmp_path: Path) -> None:
    """-(4 q + 10 q^3) - (0.5 + 0.3 |v|) v at q = 0.5, v = 1 and an inertia of 1 kg m^2."""
    file = tmp_path / "arm.xml"
    file.write_text("""<mujoco><option gravity="0 0 0"/><worldbody><body>
      <joint name="hip" axis="0 1 0" stiffness="4 0 10" damping="0.5 0.3"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>""")
    model = read_mjcf(file).model()
    assert abs(model.f([0.5, 1.0], [])[1] + 4.05) < 1e-12
    assert abs(model.f([0.5, -1.0], [])[1] + 2.45) < 1e-12  # friction is odd in the rate


@pytest.mark.parametrize(
    "flags",
    ['gravity="disable"', 'spring="disable"', 'damper="disable"',
     'spring="disable" damper="disable"', 'gravity="disable" damper="disable"',
     'warmstart="disable" energy="enable" island="disable"'],
)  # fmt: skip
def test_flags_disable_forces_as_in_mujoco(tmp_path: Path, flags: str) -> None:
    agree(written(tmp_path, option=f"<flag {flags}/>", **SPRINGS))


MOTOR = '<actuator><motor name="m" joint="hip" group="3" ctrlrange="-2 2"/></actuator>'


@pytest.mark.parametrize("flag", ["limit", "constraint"])
def test_a_flag_disables_limits(tmp_path: Path, flag: str) -> None:
    option = f'<flag {flag}="disable"/>'
    file = written(tmp_path, option=option, hip='range="-1 1" frictionloss="3"')
    hip = read_mjcf(file).coordinates[0]
    assert (hip.lower, hip.upper) == (-math.inf, math.inf)


@pytest.mark.parametrize("flag", ["frictionloss", "constraint"])
def test_a_flag_disables_dry_friction(tmp_path: Path, flag: str) -> None:
    with_it = read_mjcf(written(tmp_path, hip='frictionloss="3"'))
    assert len(with_it.efforts) == 1
    option = f'<flag {flag}="disable"/>'
    without = written(tmp_path, option=option, hip='frictionloss="3"')
    assert not read_mjcf(without).efforts


@pytest.mark.parametrize(
    ("attributes", "option", "count"),
    [("", "", 1), ("", '<flag actuation="disable"/>', 0), ('actuatorgroupdisable="3"', "", 0),
     ('actuatorgroupdisable="0 2"', "", 1)],
)  # fmt: skip
def test_actuators_are_disabled_by_flag_and_group(
    tmp_path: Path, attributes: str, option: str, count: int
) -> None:
    file = written(tmp_path, option=option, after=MOTOR)
    file.write_text(file.read_text().replace("<option ", f"<option {attributes} "))
    assert len(read_mjcf(file).inputs) == count


def test_a_motor_whose_control_is_not_clamped_has_no_limit(tmp_path: Path) -> None:
    file = written(tmp_path, option='<flag clampctrl="disable"/>', after=MOTOR)
    refused(file, "actuator m has no limit of its force")


@pytest.mark.parametrize("flag", ["contact", "constraint"])
def test_solids_keep_apart_where_contacts_push_nothing(tmp_path: Path, flag: str) -> None:
    """kinolab's own files disable contacts, since no contact is among its equations of motion."""
    option, wall = f'<flag {flag}="disable"/>', '<geom name="wall" size="0.1" pos="0 3 0"/>'
    system = read_mjcf(written(tmp_path, option=option, world=wall))
    assert ("world wall", "arm") in system.collisions


LIMITED = 'actuatorfrcrange="-5 8"'


@pytest.mark.parametrize(
    ("actuators", "limits"),
    [
        ('<motor name="a" joint="hip" ctrlrange="-20 20"/>', [(-5.0, 8.0)]),
        ('<motor name="a" joint="hip" gear="-2" ctrlrange="-1 20"/>', [(-5.0, 2.0)]),
        ('<motor name="a" joint="hip"/>', [(-5.0, 8.0)]),
        ('<position name="a" joint="hip" kp="100" kv="3"/>', [(-5.0, 8.0)]),
        ('<velocity name="a" joint="hip" kv="4" forcerange="-6 6"/>', [(-5.0, 6.0)]),
        ('<motor joint="hip" ctrlrange="-2 3"/><motor joint="hip" ctrlrange="-3 4"/>',
         [(-2.0, 3.0), (-3.0, 4.0)]),
        ('<position name="a" joint="hip" kp="0" forcerange="-6 6"/>', []),
    ],
)  # fmt: skip
def test_a_joint_limits_the_force_of_its_actuators(
    tmp_path: Path, actuators: str, limits: list[tuple[float, float]]
) -> None:
    file = written(tmp_path, hip=LIMITED, after=f"<actuator>{actuators}</actuator>")
    assert [entry.limit for entry in read_mjcf(file).inputs] == limits


def test_a_limit_of_a_sum_of_forces_is_refused(tmp_path: Path) -> None:
    two = '<motor joint="hip" ctrlrange="-4 4"/><motor joint="hip" ctrlrange="-3 3"/>'
    file = written(tmp_path, hip=LIMITED, after=f"<actuator>{two}</actuator>")
    refused(file, "joint hip has actuatorfrcrange -5 8", "sum of several actuators")
    jet = '<motor name="jet" site="tip" gear="0 0 1 0 0 0" ctrlrange="0 3"/>'
    file = written(tmp_path, hip=LIMITED, after=f"<actuator>{jet}</actuator>")
    refused(file, "actuator jet is no thruster", "joint hip has actuatorfrcrange")


@pytest.mark.parametrize("limits", ['kp="3"', 'kp="3" ctrlrange="-1 1"'])
def test_a_servo_needs_a_limit(tmp_path: Path, limits: str) -> None:
    servo = f'<position name="s" joint="hip" {limits}/>'
    if "range" not in limits:
        words = "actuator s", "Give it a ctrlrange or a forcerange, or its joint an"
        refused(written(tmp_path, after=f"<actuator>{servo}</actuator>"), *words)
    (only,) = read_mjcf(
        written(tmp_path, hip=LIMITED, after=f"<actuator>{servo}</actuator>")
    ).inputs
    assert only.limit == (-5.0, 8.0)


def test_actuators_whose_sum_is_within_their_joint_s_limit_keep_their_own(tmp_path: Path) -> None:
    """MuJoCo limits the sum, from 3 - 8 to 10 - 2, which here it never has to."""
    motors = """<actuator><motor name="up" joint="hip" ctrlrange="3 10"/>
      <motor name="down" joint="hip" ctrlrange="-8 -2"/></actuator>"""
    file = written(tmp_path, hip='actuatorfrcrange="-8 8"', after=motors)
    model: Any = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    for ends in ((3, -8), (10, -2)):
        data.ctrl[:] = ends
        mujoco.mj_forward(model, data)
        assert data.qfrc_actuator[0] == sum(ends)
    assert [bounds_of(entry) for entry in read_mjcf(file).inputs] == [(3, 10), (-8, -2)]


def test_hinges_have_one_axis_in_both_bodies(tmp_path: Path) -> None:
    motor = '<motor name="m" jointinparent="hip" gear="2" ctrlrange="-1 3"/>'
    (only,) = read_mjcf(written(tmp_path, after=f"<actuator>{motor}</actuator>")).inputs
    assert only.limit == (-2.0, 6.0)


LIMITS = 'ctrlrange="-1 1" forcerange="-1 1"'


@pytest.mark.parametrize(
    ("actuator", "why"),
    [
        (f'<muscle name="a" joint="hip" lengthrange="0 1" {LIMITS}/>', "muscle"),
        ('<position name="a" joint="hip" kp="3" timeconst="0.1" forcerange="-1 1"/>',
         "no limit of its command"),
        (f'<general name="a" joint="hip" dyntype="filter" dynprm="0" {LIMITS}/>', "constant 0"),
        (f'<general name="a" joint="hip" dyntype="filter" gainprm="0" {LIMITS}/>', "gain is 0"),
        (f'<general name="a" joint="hip" gainprm="0" biastype="affine" biasprm="0 0 -3" {LIMITS}/>',
         "gain is 0"),
        ('<general name="a" joint="hip" gaintype="affine" gainprm="1 2" forcerange="-1 1"/>',
         "no limit of its command"),
        (f'<general name="a" site="tip" dyntype="filter" biastype="affine" biasprm="1" {LIMITS}/>',
         "whatever its control is"),
        ('<dcmotor name="a" joint="hip" motorconst="1" resistance="1"/>', "dcmotor"),
        (f'<motor name="a" joint="hip" delay="0.1" nsample="9" {LIMITS}/>', "delay"),
        (f'<motor name="a" joint="hip" damping="0.1" {LIMITS}/>', "damping"),
        (f'<motor name="a" joint="hip" armature="0.1" {LIMITS}/>', "armature"),
        ('<motor name="a" joint="hip" ctrlrange="2 2.5" forcerange="-1 1"/>', "always"),
        ('<adhesion name="a" body="arm" ctrlrange="0 1"/>', "does not act on a joint"),
    ],
)  # fmt: skip
def test_actuators_that_are_no_motors_are_refused(tmp_path: Path, actuator: str, why: str) -> None:
    refused(written(tmp_path, after=f"<actuator>{actuator}</actuator>"), "actuator a ", why)


PID = """<extension><plugin plugin="mujoco.pid"><instance name="p"><config key="kp" value="4"/>
  </instance></plugin></extension>"""
TORUS = """<extension><plugin plugin="mujoco.sdf.torus"><instance name="t"/></plugin></extension>
  <asset><mesh name="m"><plugin instance="t"/></mesh></asset>"""


def test_a_controller_that_is_a_plugin_is_refused(tmp_path: Path) -> None:
    after = f'<actuator><plugin name="a" joint="hip" instance="p" {LIMITS}/></actuator>'
    refused(written(tmp_path, extra=PID, after=after), "actuator a has plugin", "code of its own")


def test_a_shape_that_is_a_plugin_is_refused(tmp_path: Path) -> None:
    """A torus, by the distance from it."""
    world = '<geom name="ring" type="sdf" mesh="m"><plugin instance="t"/></geom>'
    refused(written(tmp_path, extra=TORUS, world=world), "geom ring has plugin", "code of its own")


@pytest.mark.parametrize(
    ("parts", "owner"),
    [
        ({"hip": 'range="1 -1"'}, "joint hip has range 1 -1"),
        ({"knee": 'actuatorfrcrange="5 -5"'}, "joint knee has actuatorfrcrange 5 -5"),
        (
            {"after": '<actuator><motor name="m" joint="hip" ctrlrange="2 -2"/></actuator>'},
            "actuator m has ctrlrange 2 -2",
        ),
        (
            {"after": '<actuator><position name="m" joint="hip" forcerange="2 -2"/></actuator>'},
            "actuator m has forcerange 2 -2",
        ),
    ],
)
def test_a_range_that_is_turned_round_is_refused(
    tmp_path: Path, parts: dict[str, str], owner: str
) -> None:
    """MuJoCo takes it for none."""
    refused(written(tmp_path, **parts), f"{owner}, which ends below where it begins")


def test_a_urdf_file_of_another_name_is_refused(tmp_path: Path) -> None:
    """MuJoCo reads it, too, without its motors."""
    file = tmp_path / "arm.xml"
    file.write_text('<?xml version="1.0"?><!-- an arm --><robot name="a"><link name="b"/></robot>')
    refused(file, "begins with <robot>", "ends with .urdf")


def test_what_stands_is_refused_once(tmp_path: Path) -> None:
    field = 'nrow="2" ncol="2" size="1 1 0.1 0.1" elevation="0 1 0 0"'
    extra = f'<asset><hfield name="h" {field}/></asset>'
    file = written(tmp_path, extra=extra, world='<geom name="hill" type="hfield" hfield="h"/>')
    with pytest.raises(InputError, match="geom hill has the type hfield") as caught:
        read_mjcf(file)
    assert len(caught.value.mistakes) == 1


BALL = '<body pos="0 0 3"><joint name="socket" type="ball" {}/><geom size="0.05"/></body>'


@pytest.mark.parametrize("degrees", [30.0, 170.0])
def test_a_ball_joint_turns_within_its_range(tmp_path: Path, degrees: float) -> None:
    """About any axis, to either side; q and -q are one attitude."""
    limit = f'range="0 {math.radians(degrees)}" limited="true"'
    (wanted,) = read_mjcf(written(tmp_path, world=BALL.format(limit))).requirements
    assert wanted.name == "socket range"
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    for angle, inside in (
        (degrees - 1e-3, True),
        (degrees + 1e-3, False),
        (-degrees - 1e-3, False),
    ):
        half = math.radians(angle) / 2.0
        turn = [*(math.sin(half) * axis), math.cos(half)]
        for sign in (1.0, -1.0):
            at = {f"socket_{name}": sign * e for name, e in zip("xyzw", turn, strict=True)}
            margin = wanted.margin.subs({s: at[s.name] for s in wanted.margin.free_symbols})
            assert (float(margin) >= 0.0) is inside


def test_dry_friction_of_a_ball_joint_slows_each_rate(tmp_path: Path) -> None:
    """-f tanh(w / 0.01) of each rate in the body's axes, with an inertia of 0.2 kg m^2."""
    file = tmp_path / "arm.xml"
    file.write_text("""<mujoco><option gravity="0 0 0"/><worldbody><body>
      <joint name="socket" type="ball" frictionloss="0.5"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.2 0.2 0.2"/></body></worldbody></mujoco>""")
    model = read_mjcf(file).model()
    state = np.array(model.rest())
    rates = [model.state_names.index(f"socket_w{axis}") for axis in "xyz"]
    state[rates] = w = np.array([0.01, -2.0, 0.004])
    expected = -0.5 * np.tanh(w / 0.01) / 0.2
    assert np.allclose(np.array(model.f(state, []))[rates], expected, rtol=1e-12)


SPATIAL = '<tendon><spatial name="cord" {}><site site="tip"/><site site="base"/></spatial></tendon>'
TENDON = '<tendon><fixed name="cord" {}><joint joint="hip" coef="1"/></fixed></tendon>'


@pytest.mark.parametrize(
    ("hip", "tendon", "actuator", "why"),
    [
        ("", "", f'<muscle name="a" tendon="cord" lengthrange="0 1" {LIMITS}/>', "muscle"),
        ("", "", '<motor name="a" tendon="cord"/>', "no limit of its force"),
        ('actuatorfrcrange="-5 8"', "", f'<motor name="a" tendon="cord" {LIMITS}/>', "joint hip"),
        ("", 'actuatorfrcrange="-5 8"',
         f'<motor name="a" tendon="cord" {LIMITS}/><motor tendon="cord" {LIMITS}/>', "its tendon"),
    ],
)  # fmt: skip
def test_actuators_of_tendons_that_are_no_motors_are_refused(
    tmp_path: Path, hip: str, tendon: str, actuator: str, why: str
) -> None:
    after = f"{TENDON.format(tendon)}<actuator>{actuator}</actuator>"
    refused(written(tmp_path, hip=hip, after=after), "actuator a ", why)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"hip": 'stiffness="1" springyield="0.3"'}, ("joint hip", "springyield")),
        ({"bone": 'adhesion="2"'}, ("geom bone", "adhesion 2")),
        ({"bone": 'surfacevel="1 0 0 0 0 0"'}, ("geom bone", "surfacevel 1")),
        ({"after": '<equality><joint name="stop" joint1="hip" polycoef="0.2 0 0 0 0"/></equality>'},
         ("equality constraint stop, joint, holds hip", "locked")),
        ({"after": SPATIAL.format('stiffness="3"')}, ("tendon cord", "stiffness 3", "no sum of")),
        ({"after": SPATIAL.format('stiffness="0 0 3"')}, ("tendon cord", "stiffness 0 0 3")),
        ({"after": SPATIAL.format('damping="2"')}, ("tendon cord", "damping 2")),
        ({"after": SPATIAL.format('range="-1 1"')}, ("tendon cord", "range -1 1")),
        ({"after": SPATIAL.format('frictionloss="1"')}, ("tendon cord", "frictionloss 1")),
        ({"after": SPATIAL.format('armature="1"')}, ("tendon cord", "armature 1")),
        ({"after": TENDON.format('stiffness="3" springyield="0.3"')}, ("cord", "springyield 0.3")),
        ({"extra": '<option wind="1 0 0"/>'}, ("option wind is 1 0 0, which makes a fluid push",)),
        ({"extra": '<option viscosity="0.1"/>'}, ("option viscosity is 0.1",)),
        ({"hip": 'pos="inf 0 0"'}, ("joint hip", "pos inf", "not finite")),
        ({"hip": 'range="-inf inf"'}, ("joint hip", "range -inf", "not finite")),
        ({"knee": 'stiffness="nan"'}, ("joint knee", "stiffness nan", "not finite")),
        ({"knee": 'armature="inf"'}, ("joint knee", "armature inf", "not finite")),
        ({"after": '<actuator><motor name="a" joint="hip" gear="inf"/></actuator>'},
         ("actuator a", "gear inf")),
        ({"after": '<actuator><motor name="a" joint="hip" ctrlrange="-inf 1"/></actuator>'},
         ("actuator a", "ctrlrange -inf 1")),
        ({"world": '<body name="hand" mocap="true"/>',
          "after": '<equality><weld name="grip" body1="hand" body2="shin"/></equality>'},
         ("equality constraint grip", "hand", "mocap")),
        ({"world": '<body name="hand" mocap="true"><body name="palm"/></body>',
          "after": '<equality><connect name="pin" body1="palm" body2="shin" anchor="0 0 0"/>'
          "</equality>"},
         ("equality constraint pin", "palm", "mocap")),
        ({"world": '<flexcomp name="rope" type="grid" count="4 1 1" spacing="1 1 1" dim="1"/>'},
         ("flex rope",)),
        ({"world": '<flexcomp name="cloth" type="grid" count="3 3 1" spacing="0.1 0.1 0.1"/>'},
         ("flex cloth",)),
        ({"after": '<equality><joint joint1="knee" joint2="hip"/><joint joint1="knee" joint2="hip" '
          'polycoef="0 2 0 0 0"/></equality>'}, ("joint knee follows two",)),
    ],
)  # fmt: skip
def test_what_has_no_counterpart_is_named(
    tmp_path: Path, parts: dict[str, str], words: tuple[str, ...]
) -> None:
    refused(written(tmp_path, **parts), *words)


def test_names_pictures_and_solvers_have_no_effect(tmp_path: Path) -> None:
    extra = """<option timestep="0.001" integrator="RK4" iterations="7" magnetic="0 1 0"/>
      <visual><map znear="0.1"/></visual><statistic extent="3"/><size nuser_jnt="1"/>
      <asset><texture name="t" type="2d" builtin="flat" width="4" height="4"/>
      <material name="m" texture="t" reflectance="0.3"/></asset>
      <custom><numeric name="n" data="1 2"/><text name="w" data="word"/></custom>"""
    world = '<camera pos="0 0 3"/><light pos="0 0 3"/>'
    after = """<sensor><jointpos joint="hip" noise="0.1"/></sensor>
      <keyframe><key qpos="0.3 0.1"/></keyframe>"""
    bone = 'friction="0.3" solref="0.01 1" material="m"'
    knee = 'user="3" solimplimit="0.8 0.9 0.001 0.5 2" group="2"'
    agree(written(tmp_path, extra=extra, world=world, after=after, bone=bone, knee=knee))


def test_a_field_that_nobody_has_looked_at_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As one would be that a later MuJoCo adds: here rotors and gear ratios stand for it."""
    later = {"dof_armature", "actuator_gear"}
    monkeypatch.setattr(mjcf_fields, "READ", mjcf_fields.READ - later)
    file = written(tmp_path, knee='armature="0.2"', after=MOTOR)
    refused(file, "joint knee", "armature 0.2", "actuator m", "gear 1")
    assert read_mjcf(file, partial=True).model().nv == 2


def test_inertia_without_mass_counts(tmp_path: Path) -> None:
    """Of a part that is fixed to one that moves, such as a flywheel's."""
    wheel = '<body><inertial pos="0 0 0" mass="0" diaginertia="0.2 0.3 0.1"/></body>'
    file = written(tmp_path, **SPRINGS)
    file.write_text(file.read_text().replace('<body name="shin"', f'{wheel}<body name="shin"'))
    agree(file)


def test_every_field_is_in_one_table() -> None:
    assert not mjcf_fields.READ & mjcf_fields.WITHOUT_EFFECT


def test_fields_without_effect_have_none_in_mujoco(tmp_path: Path) -> None:
    """MuJoCo's accelerations and forces do not change if such a number does."""
    after = f"""{TENDON.format("")}<actuator><motor joint="knee" ctrlrange="-2 2"/>
      <position joint="hip" kp="30" kv="1" forcerange="-3 3"/>
      <motor site="tip" gear="1 2 3 4 5 6" ctrlrange="-1 1"/></actuator>"""
    world = '<body pos="0 0 3"><freejoint/><geom type="box" size="0.1 0.2 0.3"/></body>'
    option = '<flag contact="disable"/>'
    file = written(tmp_path, option=option, world=world, after=after, **SPRINGS)

    def forces(model: Any) -> Any:
        data, generator = mujoco.MjData(model), np.random.default_rng(3)
        data.qpos[:2], data.ctrl[:] = generator.normal(size=2), generator.normal(size=3)
        data.qvel[:] = generator.normal(size=model.nv)
        mujoco.mj_forward(model, data)
        return np.concatenate([data.qacc, data.qfrc_passive, data.qfrc_bias, data.qfrc_actuator])

    unchanged = forces(mujoco.MjModel.from_xml_path(str(file)))
    for name in sorted(mjcf_fields.WITHOUT_EFFECT - {"dof_M0"}):  # dof_M0: of masses and armature
        model = mujoco.MjModel.from_xml_path(str(file))
        owner, own = (model.opt, name[4:]) if name.startswith("opt_") else (model, name)
        value = getattr(owner, own, None)
        if isinstance(value, float):
            setattr(owner, own, value + 0.37)
        elif isinstance(value, np.ndarray) and value.dtype.kind == "f":
            value += 0.37
        assert np.abs(forces(model) - unchanged).max() < 1e-9, name


@pytest.mark.parametrize("quat", ["1 0 0 0", "1 1e-9 0 0"])
@pytest.mark.parametrize("x", ["3e-9", "0.1"])
def test_what_is_off_by_rounding_is_where_mujoco_has_it(x: str, quat: str, tmp_path: Path) -> None:
    """Centres of mass of meshes are computed; in MuJoCo what they are off by moves nothing."""
    inertial = f'<inertial pos="{x} 0 -2e-9" quat="{quat}" mass="200" diaginertia="9 8 7"/>'
    top = f'<body name="top"><joint name="spin" axis="0.3 1 0"/>{inertial}</body>'
    file = tmp_path / "top.xml"
    file.write_text(f"<mujoco><worldbody>{top}</worldbody></mujoco>")
    agree(file)


AIMING = 'ctrlrange="-0.4 1" forcerange="-50 50"'
GENERAL = 'biastype="affine" gainprm="9" biasprm="3 -4 -0.5"'
SUM = """<tendon><fixed name="t"><joint joint="hip" coef="0.5"/><joint joint="knee" coef="-2"/>
  </fixed></tendon>"""
FOLLOWING = """<equality><joint joint1="knee" joint2="hip" polycoef="0.3 -0.5 0 0 0"/></equality>"""


@pytest.mark.parametrize(
    ("servo", "parts"),
    [
        (f'<position joint="hip" kp="0.1" {AIMING}/>', {}),
        (f'<position joint="hip" kp="30" kv="9" {AIMING}/>', {}),
        (f'<position joint="knee" kp="30" kv="2" gear="-3" {AIMING}/>', {}),
        (f'<velocity joint="hip" kv="40" gear="0.5" {AIMING}/>', {}),
        (f'<position jointinparent="hip" kp="7" {AIMING}/>', {}),
        (f'<position tendon="t" kp="30" kv="2" gear="1.5" {AIMING}/>', {"after": SUM}),
        (f'<position joint="knee" kp="50" kv="6" gear="2" {AIMING}/>', {"after": FOLLOWING}),
        (f'<position tendon="t" kp="30" kv="2" {AIMING}/>', {"after": FOLLOWING + SUM}),
        ('<position joint="hip" kp="30" inheritrange="0.5" forcerange="-9 5"/>',
         {"hip": 'range="-1 2"'}),
        (f'<position joint="hip" kp="30" kv="1" gear="2" {AIMING}/>',
         {"hip": 'actuatorfrcrange="-20 40"'}),
        (f'<general joint="hip" {GENERAL} {AIMING}/>', {}),
        (f'<general joint="hip" {GENERAL.replace("9", "-9")} gear="-2" {AIMING}/>', {}),
    ],
)  # fmt: skip
def test_a_servo_may_push_as_it_can_in_mujoco(
    servo: str, parts: dict[str, str], tmp_path: Path
) -> None:
    """Just those of the inputs within limits that are between MuJoCo's at the ends of ctrlrange."""
    after = f"{parts.get('after', '')}<actuator>{servo}</actuator>"
    file = written(tmp_path, **parts | {"after": after})
    system = read_mjcf(file)
    own, (low, high) = system.model(), bounds_of(system.inputs[0])
    model: Any = mujoco.MjModel.from_xml_path(str(file))
    data, generator = mujoco.MjData(model), np.random.default_rng(3)
    beyond, between = 0, 0
    for _ in range(200):
        x = generator.normal(size=own.nx)
        data.qpos[:], data.qvel[:] = x[: own.nv], x[own.nv :]
        if model.neq:  # the knee follows
            data.qpos[1], data.qvel[1] = 0.3 - 0.5 * x[0], -0.5 * x[1]
        ends = sorted(forced(model, data, end) for end in model.actuator_ctrlrange[0])
        for u in generator.uniform(low, high, size=10):
            can = ends[0] <= u <= ends[1]
            assert bool((own.requirements(x, [u]) >= 0.0).all()) == can
            between += can
            beyond += not can
        for u in ends:  # also where the force is at its limit, which may leave a margin
            margin, rounding = own.requirements(x, [u]).min(), 1e-12 * (high - low)
            assert low - rounding <= u <= high + rounding
            assert -rounding <= margin <= (rounding if low < u < high else math.inf)
    assert min(between, beyond) > 0


def forced(model: Any, data: Any, control: float) -> float:
    """Return the input of kinolab's that is MuJoCo's only actuator at a control."""
    data.ctrl[:] = control
    mujoco.mj_forward(model, data)
    tendon = int(model.actuator_trntype[0]) == int(mujoco.mjtTrn.mjTRN_TENDON)
    moved = int(model.actuator_trnid[0, 0])
    return float(data.actuator_force[0] if tendon else data.qfrc_actuator[moved])


@pytest.mark.parametrize(
    ("servo", "option"),
    [
        ('<position name="s" joint="hip" kp="3" ctrllimited="false" forcerange="-5 5"/>', ""),
        (f'<position name="s" joint="hip" kp="3" {AIMING}/>', '<flag clampctrl="disable"/>'),
        (f'<general name="s" joint="hip" {GENERAL} {AIMING}/>', '<flag clampctrl="disable"/>'),
    ],
)
def test_a_servo_that_may_aim_anywhere_has_its_full_force_everywhere(
    servo: str, option: str, tmp_path: Path
) -> None:
    file = written(tmp_path, option=option, after=f"<actuator>{servo}</actuator>")
    assert not read_mjcf(file).requirements


def test_a_constant_bias_shifts_what_a_motor_can_do(tmp_path: Path) -> None:
    motor = f'<general joint="hip" gainprm="9" biastype="affine" biasprm="3 0 0" {AIMING}/>'
    system = read_mjcf(written(tmp_path, after=f"<actuator>{motor}</actuator>"))
    assert bounds_of(system.inputs[0]) == pytest.approx((9 * -0.4 + 3, 9 + 3))
    assert not system.requirements


def test_a_servo_at_a_site_pushes_by_what_it_aims_at(tmp_path: Path) -> None:
    servo = f'<position name="s" site="tip" kp="3" gear="1 0 0 0 0 0" {AIMING}/>'
    (thrust,) = read_mjcf(written(tmp_path, after=f"<actuator>{servo}</actuator>")).inputs
    assert bounds_of(thrust) == pytest.approx((-1.2, 3.0))
    braking = servo.replace('kp="3"', 'kp="3" kv="1"')
    refused(written(tmp_path, after=f"<actuator>{braking}</actuator>"), "actuator s", "brakes")


def test_a_servo_beside_a_locked_joint_aims_from_where_that_is(tmp_path: Path) -> None:
    servo = f'<position name="s" tendon="t" kp="3" {AIMING}/>'
    file = written(tmp_path, after=f"{SUM}<actuator>{servo}</actuator>")
    model = read_mjcf(file, locked={"knee": 0.1}).model()
    # 3 (ctrl - (0.5 hip - 2 * 0.1)) at hip = 0.2 and the upper end of ctrl, 1
    assert model.requirements([0.2, 0.0], [3 * (1 - 0.1 + 0.2)])[0] == pytest.approx(0.0, abs=1e-9)
    assert not read_mjcf(file, locked={"knee": 0.1, "hip": 0.2}).requirements


def test_a_servo_of_a_locked_joint_demands_nothing(tmp_path: Path) -> None:
    servo = f'<position name="s" joint="hip" kp="3" {AIMING}/>'
    file = written(tmp_path, after=f"<actuator>{servo}</actuator>")
    assert not read_mjcf(file, locked={"hip": 0.2}).requirements


def test_what_a_servo_cannot_do_is_said_with_its_name(tmp_path: Path) -> None:
    servo = f'<position name="s" joint="hip" kp="3" {AIMING}/>'
    system = read_mjcf(written(tmp_path, after=f"<actuator>{servo}</actuator>"))
    assert [one.name for one in system.requirements] == [
        "s aims at no more than its ctrlrange allows",
        "s aims at no less than its ctrlrange allows",
    ]


@pytest.mark.parametrize("attribute", ["damping", "frictionloss", "armature"])
def test_a_negative_magnitude_is_refused_with_its_joint(attribute: str, tmp_path: Path) -> None:
    """MuJoCo passes over a negative frictionloss, and is driven by the others."""
    refused(written(tmp_path, hip=f'{attribute}="-1"'), "arm.xml joint 'hip'", "is -1, and no")

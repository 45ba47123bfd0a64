"""Loops that MJCF files close move as MuJoCo's own mass matrix and Jacobians say, without softness.

MuJoCo gives M, the forces tau without those of constraints, and J of its equality constraints;
a rigid loop has M a + J^T lambda = tau and J a = -dJ/dt v (Murray, Li, Sastry, 1994, 6.1).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import null_space

import kinolab
from kinolab.dynamics import Model, System
from kinolab.dynamics.analysis.consistent_states import constraint_violations
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.robots import read_mjcf
from kinolab.systems.five_bar import five_bar

mujoco: Any = pytest.importorskip("mujoco")

AGREE = 1e-9  # relative to the largest acceleration; dJ/dt is a finite difference
STEP = 2e-3  # [s] of it; the error is of the fourth order
FREE, BALL = mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL
SHIPPED = Path(mujoco.__file__).parent / "testdata" / "model.xml"


class RigidLimit:
    """MuJoCo's model of a file, whose equality constraints hold exactly."""

    def __init__(self, file: Path) -> None:
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(lambda _: None)  # else it writes a file where tests run
        self.model: Any = mujoco.MjModel.from_xml_path(str(file))
        mujoco.set_mju_user_warning(before)
        bits = mujoco.mjtDisableBit
        for bit in ("CONTACT", "LIMIT", "FRICTIONLOSS", "CLAMPCTRL"):
            self.model.opt.disableflags |= int(getattr(bits, f"mjDSBL_{bit}"))
        self.model.opt.jacobian = int(mujoco.mjtJacobian.mjJAC_DENSE)
        self.data: Any = mujoco.MjData(self.model)

    def joints(self) -> list[tuple[str, bool, int, int]]:
        """Return name, whether it is free or a ball, and its first entries of qpos and qvel."""
        model = self.model
        return [
            (spelled(model.joint(j).name or f"joint_{j + 1}"),
             int(model.jnt_type[j]) in (FREE, BALL),
             int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j]))
            for j in range(model.njnt)
        ]  # fmt: skip

    def gaps_and_rows(self, qpos: Array) -> tuple[Array, Array]:
        """Return the gaps of all loops and their Jacobian by qvel, shape (rows, nv)."""
        self.data.qpos[:] = qpos
        mujoco.mj_fwdPosition(self.model, self.data)
        rows = int(self.data.ne)
        return (
            np.array(self.data.efc_pos[:rows]),
            np.array(self.data.efc_J).reshape(-1, self.model.nv)[:rows],
        )

    def moved(self, qpos: Array, by: Array) -> Array:
        """Return a configuration after a step (nv,)."""
        after = np.array(qpos)
        mujoco.mj_integratePos(self.model, after, by, 1.0)
        return after

    def closed(self, qpos: Array) -> Array:
        """Return a configuration near another one in which all loops are closed."""
        for _ in range(100):
            gaps, rows = self.gaps_and_rows(qpos)
            if np.abs(gaps).max(initial=0.0) < 1e-14:
                break
            qpos = self.moved(qpos, -np.linalg.pinv(rows, rcond=1e-9) @ gaps)
        assert np.abs(self.gaps_and_rows(qpos)[0]).max(initial=0.0) < 1e-12
        return qpos

    def at(self, generator: np.random.Generator, spread: float) -> tuple[Array, Array]:
        """Return a random state near the file's own in which all loops are closed."""
        step = spread * generator.normal(size=self.model.nv)
        qpos = self.closed(self.moved(np.array(self.model.qpos0), step))
        rows = self.gaps_and_rows(qpos)[1]
        v = generator.normal(size=self.model.nv)
        return qpos, v - np.linalg.pinv(rows, rcond=1e-9) @ (rows @ v)

    def acceleration(self, qpos: Array, v: Array, ctrl: Array) -> Array:
        """Return the derivative of qvel."""
        model, data = self.model, self.data
        there = [self.gaps_and_rows(self.moved(qpos, k * STEP * v))[1] for k in (-2, -1, 1, 2)]
        far_back, back, ahead, far_ahead = there
        turning = (8 * (ahead - back) - (far_ahead - far_back)) / (12 * STEP)
        _, rows = self.gaps_and_rows(qpos)
        data.qvel[:], data.ctrl[:] = v, ctrl
        mujoco.mj_forward(model, data)
        nv, mass = model.nv, np.zeros((model.nv, model.nv))
        for k in range(nv):
            mujoco.mj_mulM(model, data, mass[k], np.eye(nv)[k])
        # the same equations along what J leaves free: redundant ones make the whole singular
        bending = -np.linalg.pinv(rows, rcond=1e-9) @ turning @ v
        free = null_space(rows, rcond=1e-9)
        force = free.T @ (data.qfrc_smooth - mass @ bending)
        return np.asarray(bending + free @ np.linalg.solve(free.T @ mass @ free, force))


def spelled(name: str) -> str:
    """Return a joint's name as a coordinate's."""
    return name.replace("-", "_")


def state_of(own: Model, engine: RigidLimit, qpos: Array, v: Array) -> Array:
    """Return a state of kinolab's; rates that are none of its states are left out."""
    found: dict[str, float] = {}
    for name, turns, q, dof in engine.joints():
        if not turns:
            found |= {name: qpos[q], f"{name}_dot": v[dof]}
            continue
        free = int(engine.model.jnt_type[engine.model.dof_jntid[dof]]) == FREE
        for k, axis in enumerate("xyz"):
            if free:
                found |= {f"{name}_at_{axis}": qpos[q + k], f"{name}_at_{axis}_dot": v[dof + k]}
            found |= {f"{name}_w{axis}": v[dof + 3 * free + k]}
        w, x, y, z = qpos[q + 3 * free : q + 3 * free + 4]
        found |= {f"{name}_x": x, f"{name}_y": y, f"{name}_z": z, f"{name}_w": w}
    return np.array([found[name] for name in own.state_names])


def by_name(own: Model, slope: Array) -> dict[str, float]:
    """Return kinolab's derivatives by what is differentiated."""
    return dict(zip(own.state_names, slope.tolist(), strict=True))


def agree(file: Path, system: System, *, spread: float = 0.3, change: Any = None) -> Model:
    """Compare a machine with the rigid limit of MuJoCo's model; return it."""
    own, engine, generator = system.model(), RigidLimit(file), np.random.default_rng(2)
    if change is not None:
        change(engine.model)
    rank = np.linalg.matrix_rank(engine.gaps_and_rows(engine.at(generator, spread)[0])[1], 1e-9)
    assert own.nv == engine.model.nv - rank
    for _ in range(6):
        qpos, v = engine.at(generator, spread)
        ctrl = generator.normal(size=engine.model.nu)
        x = state_of(own, engine, qpos, v)
        u = np.zeros(own.nu)
        for k, entry in enumerate(system.inputs):
            motor = entry.name.removesuffix("_torque").removesuffix("_force")
            u[k] = ctrl[engine.model.actuator(motor).id] * engine.model.actuator(motor).gear[0]
        theirs = engine.acceleration(qpos, v, ctrl)
        ours = by_name(own, own.f(x, u))
        assert not constraint_violations(own, x)
        for name, turns, _, dof in engine.joints():
            named = {name: v[dof], f"{name}_dot": theirs[dof]}
            if turns:
                free = int(engine.model.jnt_type[engine.model.dof_jntid[dof]]) == FREE
                named = {f"{name}_w{a}": theirs[dof + 3 * free + k] for k, a in enumerate("xyz")}
                if free:
                    named |= {f"{name}_at_{a}": v[dof + k] for k, a in enumerate("xyz")}
                    named |= {f"{name}_at_{a}_dot": theirs[dof + k] for k, a in enumerate("xyz")}
            for key, value in named.items():
                if key in ours:  # of dependent velocities the coordinates' rates are compared
                    size = max(1.0, np.abs(theirs).max())
                    assert abs(ours[key] - value) <= AGREE * size, (key, ours[key], value)
    return own


def written(tmp_path: Path, text: str) -> Path:
    """Return a file with a text."""
    file = tmp_path / "loop.xml"
    file.write_text(text)
    return file


# A crank, a coupler and a rocker about axes that are oblique to the world's.
FOUR_BAR = """<mujoco model="four bar">
  <compiler angle="radian"/>
  <worldbody>
    <body name="base" euler="0.4 -0.3 0.7">
      <body name="crank">
        <joint name="crank" axis="0 0 1" damping="0.05"/>
        <geom type="capsule" fromto="0 0 0 0 0.2 0" size="0.02" mass="0.4"/>
        <body name="coupler" pos="0 0.2 0.05">
          <joint name="coupler" axis="0 0 1"/>
          <geom type="capsule" fromto="0 0 0 0.6 0.2 0" size="0.02" mass="0.8"/>
        </body>
      </body>
      <body name="rocker" pos="0.5 0 0">
        <joint name="rocker" axis="0 0 1" stiffness="2" armature="0.01"/>
        <geom type="capsule" fromto="0 0 0 0.1 0.4 0" size="0.02" mass="0.6"/>
      </body>
    </body>
  </worldbody>
  <equality><connect name="pin" body1="coupler" body2="rocker" anchor="0.6 0.2 0"/></equality>
  <actuator><motor name="crank" joint="crank" gear="3" ctrlrange="-2 2"/></actuator>
</mujoco>"""


def test_a_four_bar_in_an_oblique_plane_has_one_degree_of_freedom(tmp_path: Path) -> None:
    """Of three equations of its pin one always holds, and is left out."""
    file = written(tmp_path, FOUR_BAR)
    system = read_mjcf(file)
    assert len(system.constraints) == 2
    own = agree(file, system)
    assert own.nv == 1
    assert not own.redundant


def test_bars_that_are_welded_keep_three_equations_of_six(tmp_path: Path) -> None:
    """In a plane, two along it and one about its normal; a rail gives back what the weld takes."""
    pin = '<connect name="pin" body1="coupler" body2="rocker" anchor="0.6 0.2 0"/>'
    weld = '<weld name="weld" body1="coupler" body2="rocker"/>'
    rail = '<joint name="rail" type="slide" axis="1 0 0"/><joint name="crank"'
    text = FOUR_BAR.replace(pin, weld).replace('<joint name="crank"', rail)
    file = written(tmp_path, text)
    system = read_mjcf(file)
    names = [constraint.name for constraint in system.constraints]
    assert names == ["weld along x", "weld along y", "weld about z"]
    assert agree(file, system).nv == 1


def test_the_five_bar_moves_as_kinolab_s_own(tmp_path: Path) -> None:
    """Written as a file, the parallel robot has the accelerations of the one in kinolab."""
    slender, across = 0.3 * 0.011**2 / 2, 0.3 * 0.25**2 / 12
    fore, fore_across = 0.15 * 0.011**2 / 2, 0.15 * 0.25**2 / 12
    tool, tool_long = 0.1 * 0.18**2 / 12, 0.1 * 0.01**2 / 2

    def arm(side: str, x: float, turn: float, hand: str = "") -> str:
        home, elbow = 90.0, turn - 90.0
        return f"""<body name="{side}" pos="{x} 0 0" euler="0 0 {home}">
          <joint name="a_{side}" axis="0 0 1"/>
          <inertial pos="0.125 0 0" mass="0.3" diaginertia="{slender} {across} {across}"/>
          <body name="{side}_fore" pos="0.25 0 0" euler="0 0 {elbow}">
            <joint name="f_{side}" axis="0 0 1"/>
            <inertial pos="0.125 0 0" mass="0.15" diaginertia="{fore} {fore_across} {fore_across}"/>
            {hand}
          </body></body>"""

    hand = f"""<body pos="0.25 0 0">
      <inertial pos="0 0 0" mass="0.1" diaginertia="{tool} {tool} {tool_long}"/></body>"""
    text = f"""<mujoco><worldbody>{arm("l", -0.125, 60, hand)}{arm("r", 0.125, 120)}</worldbody>
      <equality><connect body1="l_fore" body2="r_fore" anchor="0.25 0 0"/></equality>
      <actuator><motor name="left" joint="a_l" ctrlrange="-1 1"/>
      <motor name="right" joint="a_r" ctrlrange="-1 1"/></actuator></mujoco>"""
    file = written(tmp_path, text)
    system = read_mjcf(file)
    agree(file, system)
    joints = {entry.name: entry for entry in system.coordinates}
    own = system.changed(velocities=[joints["a_l"], joints["a_r"]]).model()
    other = five_bar().model()
    engine, generator = RigidLimit(file), np.random.default_rng(5)
    for _ in range(5):
        qpos, v = engine.at(generator, 0.2)
        x, u = state_of(own, engine, qpos, v), 0.1 * generator.normal(size=2)
        at = dict(zip(own.state_names, x.tolist(), strict=True))
        # a forearm's angle is relative to its upper arm in the file
        at |= {f"f_{side}": at[f"f_{side}"] + at[f"a_{side}"] for side in "lr"}
        theirs = other.f(np.array([at[name] for name in other.state_names]), u)
        ours, expected = by_name(own, own.f(x, u)), by_name(other, theirs)
        for name in ("a_l_dot", "a_r_dot"):
            assert abs(ours[name] - expected[name]) < 1e-9 * max(1.0, np.abs(theirs).max())


# A platform on three legs, each a hinge, a slide and a ball that a closure makes.
SPATIAL = """<mujoco model="three legs">
  <compiler angle="radian"/>
  <worldbody>
    {legs}
    <body name="platform" pos="0 0 0.5">
      <freejoint name="platform"/>
      <geom type="cylinder" size="0.15 0.02" mass="2"/>
      {sites}
    </body>
  </worldbody>
  <equality>{closures}</equality>
  <actuator>{motors}</actuator>
</mujoco>"""


def spatial() -> str:
    """Return a platform on three legs: 12 velocities and 9 equations."""
    legs, sites, closures, motors = [], [], [], []
    for k in range(3):
        angle = 2 * math.pi * k / 3
        x, y = 0.3 * math.cos(angle), 0.3 * math.sin(angle)
        legs.append(
            f'<body name="leg{k}" pos="{x} {y} 0" euler="0 0 {angle}">'
            f'<joint name="hip{k}" axis="0 1 0"/><geom size="0.03" pos="0 0 0.1" mass="0.3"/>'
            f'<body name="rod{k}"><joint name="lift{k}" type="slide" axis="-0.3 0 1"/>'
            f'<geom type="capsule" fromto="0 0 0.2 -0.15 0 0.5" size="0.02" mass="0.5"/>'
            f'<site name="top{k}" pos="-0.15 0 0.5"/></body></body>'
        )
        sites.append(f'<site name="seat{k}" pos="{x / 2} {y / 2} 0"/>')
        motors.append(f'<motor name="lift{k}" joint="lift{k}" gear="10" ctrlrange="-1 1"/>')
    closures = [
        '<connect name="ball0" body1="rod0" body2="platform" anchor="-0.15 0 0.5"/>',
        '<connect name="ball1" site1="top1" site2="seat1"/>',
        '<connect name="ball2" site1="seat2" site2="top2"/>',
    ]
    return SPATIAL.format(
        legs="".join(legs), sites="".join(sites), closures="".join(closures), motors="".join(motors)
    )


def test_a_platform_on_three_legs_moves_as_mujoco_says(tmp_path: Path) -> None:
    """Closed by bodies and by sites, about a freely moving body."""
    file = written(tmp_path, spatial())
    own = agree(file, read_mjcf(file), spread=0.1)
    assert own.nv == 3


def test_a_model_that_comes_with_mujoco_moves_as_mujoco_says(tmp_path: Path) -> None:
    """Its free cylinder is welded to the world; what kinolab leaves out is left out there, too."""

    def without_what_is_left_out(model: Any) -> None:
        model.opt.density = model.opt.viscosity = 0.0
        model.opt.wind[:] = 0.0
        joint = int(mujoco.mjtWrap.mjWRAP_JOINT)
        model.tendon_stiffness[model.wrap_type[model.tendon_adr] != joint] = 0.0

    spec = mujoco.MjSpec.from_file(str(SHIPPED))
    for actuator in list(spec.actuators):  # of which kinolab reads some, and names others
        spec.delete(actuator)
    for sensor in list(spec.sensors):
        spec.delete(sensor)
    for key in list(spec.keys):  # with inputs of actuators
        spec.delete(key)
    spec.meshdir = str(SHIPPED.parent / spec.meshdir)
    file = written(tmp_path, spec.to_xml())
    agree(
        file,
        read_mjcf(file, shapes=False, partial=True),
        spread=0.2,
        change=without_what_is_left_out,
    )


def test_a_loop_is_planned_for_from_the_file_s_own_position(tmp_path: Path) -> None:
    """MuJoCo takes anchors from where all joints are 0, where kinolab's motions start, too."""
    written(tmp_path, FOUR_BAR)
    (tmp_path / "turn.toml").write_text(
        'schema = 1\ntitle = "A crank is turned"\n[system]\nfile = "loop.xml"\n'
        "[goal]\ncrank = 0.8\nat_rest = true\ntolerance = 0.05\n"
        "[bounds]\ncoupler_dot = [-20, 20]\n"
    )
    plan = kinolab.load(tmp_path / "turn.toml").solve(seed=1, time_limit=30.0, improve=0.5)
    assert plan.status == "solved"
    assert plan.certificate.passed
    engine, names = RigidLimit(tmp_path / "loop.xml"), list(plan.problem.model.state_names)
    for x in plan.trajectory.x:
        qpos = np.array([x[names.index(name)] for name, *_ in engine.joints()])
        assert np.abs(engine.gaps_and_rows(qpos)[0]).max() < 1e-7  # [m], by MuJoCo's kinematics
    plan.save(tmp_path / "run")
    again = kinolab.read_run(tmp_path / "run").problem.model
    assert [constraint.name for constraint in again.system.constraints] == [
        "pin along x",
        "pin along y",
    ]


@pytest.mark.parametrize(
    "change",
    [
        ('anchor="0.6 0.2 0"', 'anchor="0.6 0.2 0" active="false"'),
        ("<equality>", '<option><flag equality="disable"/></option><equality>'),
    ],
)
def test_what_is_switched_off_closes_nothing(change: tuple[str, str], tmp_path: Path) -> None:
    assert not read_mjcf(written(tmp_path, FOUR_BAR.replace(*change))).constraints


def test_a_weld_without_torque_is_a_pin(tmp_path: Path) -> None:
    pin = "<connect"
    weld = '<weld torquescale="0"'
    system = read_mjcf(written(tmp_path, FOUR_BAR.replace(pin, weld)))
    assert [constraint.name for constraint in system.constraints] == ["pin along x", "pin along y"]


def test_loops_that_cannot_close_are_named(tmp_path: Path) -> None:
    """All at once: sites that are too far apart, and a joint that is locked with its loop open."""
    sites = """<connect name="far" site1="tip" site2="post"/></equality>"""
    text = FOUR_BAR.replace("</equality>", sites)
    text = text.replace(
        '<geom type="capsule" fromto="0 0 0 0 0.2 0"',
        '<site name="tip"/><geom type="capsule" fromto="0 0 0 0 0.2 0"',
    )
    text = text.replace("<worldbody>", '<worldbody><site name="post" pos="9 9 9"/>')
    with pytest.raises(InputError) as caught:
        read_mjcf(written(tmp_path, text))
    assert "no configuration was found in which far closes its loop" in str(caught.value)
    locked = {"crank": 0.5, "coupler": 0.0, "rocker": 0.0}
    with pytest.raises(InputError, match="pin holds parts together that cannot move"):
        read_mjcf(written(tmp_path, FOUR_BAR), locked=locked)
    still = dict.fromkeys(locked, 0.0) | {"crank": 0.0}
    text = FOUR_BAR.replace("</worldbody>", FALLING + "</worldbody>")
    assert not read_mjcf(written(tmp_path, text), locked=still).constraints


FALLING = '<body name="ball"><joint name="ball" type="slide"/><geom size="0.1" mass="1"/></body>'

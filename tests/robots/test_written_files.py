"""Machines that are written as MJCF and URDF files move there as they do in kinolab."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from kinolab import cli, systems
from kinolab.dynamics import (
    Attitude,
    Body,
    Box,
    Buoyancy,
    Capsule,
    Control,
    Coulomb,
    Cylinder,
    Drive,
    Force,
    Model,
    Potential,
    Sphere,
    Spring,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    length,
    move,
    orient,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    rotation,
    toward,
    zero,
)
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.robots import mjcf_text, read_mjcf, read_urdf, urdf_text
from kinolab.world.shapes.geometry import frame_in_world
from tests.robots.test_urdf import FOLDER
from tests.robots.written_files import (
    InMujoco,
    InPinocchio,
    accelerations,
    instants,
    largest_gap,
)

mujoco: Any = pytest.importorskip("mujoco")
gymnasium = pytest.importorskip("gymnasium")
ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"

AGREE = 1e-9  # relative to the largest acceleration
PLACED = 1e-12  # [m], and of entries of rotation matrices
FREE = {"R": ("x", "y", "z")}

TREES = (
    "acrobot_v0",
    "crane",
    "pendulum",
    "quad2d_v0",
    "quad2dpole_v0",
    "quad3d_omplapp",
    "quad3d_v0",
    "satellite",
    "satellite_two_wheels",
)
NO_TREES = {  # what keeps the others from being trees
    "biped": "it has modes",
    "car": "constraint 'rolling'",
    "car1_v0": "constraint 'no sideslip behind'",
    "diff_drive": "constraint 'left wheel rolls'",
    "falling_disk": "it has feedback",
    "five_bar": r"moves by l\*cos\(a_l\), which is not linear",
    "helicopter": "input 'tilt_back': its force is not constant times the input",
    "marionette": "rope",
    "motorcycle": "input 'steer': it is a Drive",
    "rolling_disk": "constraint 'no sideslip'",
    "slip_steered": "sliding friction",
    "snakeboard": "constraint 'back wheels roll'",
    "submarine": "it has added mass",
    "two_cranes": "input 'hoist_a': it is a Drive",
    "panda": "it has feedback",
    "unicycle": "it has feedback",
    "unicycle1_v0": "input 'v': it is a Rate",
    "unicycle1_v1": "input 'v': it is a Rate",
    "unicycle1_v2": "input 'v': it is a Rate",
    "unicycle2_v0": "state 'v': it has a differential equation",
    "whipple": "constraint 'the rear wheel rolls'",
}
NO_URDF = {  # and which trees URDF has no words for
    "crane": "input 'hoist': its limits are 8810 and 10810",
    "quad2d_v0": "input 'f1': it pushes a body",
    "quad2dpole_v0": "input 'f2': it pushes a body",
    "quad3d_omplapp": "input 'tx': it pushes a body",
    "quad3d_v0": "input 'f4': it pushes a body",
    "satellite": "rotation 'R'",
    "satellite_two_wheels": "gravity: it is 0 m/s",
}


@cache
def model_of(name: str) -> Model:
    return systems.get(name).model()


def test_every_machine_is_a_tree_or_refused_for_a_reason() -> None:
    assert sorted((*TREES, *NO_TREES)) == sorted(systems.names())
    for name in systems.names():
        system, reason = systems.get(name), NO_TREES.get(name)
        if reason is None:
            mjcf_text(system)
            reason = NO_URDF.get(name)
        else:
            with pytest.raises(InputError, match=reason):
                mjcf_text(system)
        if reason is None:
            urdf_text(system)
        else:
            with pytest.raises(InputError, match=reason):
                urdf_text(system)


def same_in_mujoco(system: System, model: Model, engine: InMujoco) -> None:
    """Compare accelerations and poses of bodies in several states."""
    names = [entry.name for entry in system.inputs]
    for given, x, u in instants(system, model, 5):
        theirs = engine.accelerations(given, dict(zip(names, u, strict=True)))
        assert largest_gap(accelerations(system, model, model.f(x, u)), theirs) <= AGREE
        for body, row in zip(system.bodies, model.frames(x), strict=True):
            pose = row.reshape(3, 4)
            there = engine.data.body(body.name)
            assert np.abs(there.xpos - pose[:, 3]).max() <= PLACED
            assert np.abs(there.xmat.reshape(3, 3) - pose[:, :3]).max() <= PLACED


@pytest.mark.parametrize("name", TREES)
def test_machines_move_in_mujoco_as_they_do_here(name: str) -> None:
    system = systems.get(name)
    same_in_mujoco(system, model_of(name), InMujoco(mjcf_text(system), FREE))


@pytest.mark.parametrize("name", TREES)
def test_shapes_are_where_they_are_here(name: str) -> None:
    system, model = systems.get(name), model_of(name)
    engine = InMujoco(mjcf_text(system), FREE)
    (given, x, _), *_ = instants(system, model, 1)
    engine.put(given)
    mujoco.mj_kinematics(engine.model, engine.data)
    for body, row in zip(system.bodies, model.frames(x), strict=True):
        own = engine.model.body(body.name)
        shapes = system.resolved_shapes(body)
        assert own.geomnum[0] == len(shapes)
        for k, shape in enumerate(shapes):
            geom = int(own.geomadr[0]) + k
            axes, centre = frame_in_world(shape, row.reshape(3, 4))
            assert np.abs(engine.data.geom_xpos[geom] - centre).max() <= PLACED
            turn = engine.data.geom_xmat[geom].reshape(3, 3)
            assert np.abs(np.abs(turn) - np.abs(axes)).max() <= PLACED


@pytest.mark.parametrize("name", TREES)
def test_names_and_limits_survive_in_mujoco(name: str) -> None:
    system = systems.get(name)
    model: Any = mujoco.MjModel.from_xml_string(mjcf_text(system))
    assert {body.name for body in system.bodies} < {model.body(k).name for k in range(model.nbody)}
    for entry, (low, high) in zip(system.inputs, model_of(name).control_bounds, strict=True):
        assert model.actuator(entry.name).ctrlrange.tolist() == [low, high]
    joints = {model.joint(k).name for k in range(model.njnt)}
    free = {"x", "y", "z"} if model.joint(0).type[0] == mujoco.mjtJoint.mjJNT_FREE else set()
    assert joints == {c.name for c in system.coordinates} - free
    for c in system.coordinates:
        if not isinstance(c, Attitude) and np.isfinite(c.lower):
            assert model.joint(c.name).range.tolist() == [c.lower, c.upper]


def renamed(given: dict[str, Array], system: System) -> dict[str, Array]:
    """Return what is given by the names of a machine that was read from a file."""
    known = {c.name for c in system.coordinates}
    return {name if name in known else f"R_at_{name}": value for name, value in given.items()}


def state_of(given: dict[str, Array], system: System, model: Model) -> Array:
    """Return the state with positions and velocities by name."""
    x, names = np.zeros(model.nx), list(model.state_names)
    for name, value in renamed(given, system).items():
        if len(value) == 7:
            first = model.attitudes[name]
            x[first : first + 4] = value[:4]
            for axis, part in zip("xyz", value[4:], strict=True):
                x[names.index(f"{name}_w{axis}")] = part
        else:
            x[names.index(name)], x[names.index(f"{name}_dot")] = value
    return x


def same_when_read(
    system: System,
    model: Model,
    read: System,
    motors: dict[str, str],
    gears: dict[str, float],
) -> None:
    """Compare accelerations with those of the machine that a file was read as.

    Args:
        system: The machine.
        model: Its model.
        read: The machine that was read.
        motors: Which input drives a joint, of files whose motors have the names of joints.
        gears: By which an input was multiplied.
    """
    own = read.model()
    for given, x, u in instants(system, model, 5):
        inputs = dict(zip((entry.name for entry in system.inputs), u, strict=True))
        felt = []
        for entry in own.control_names:
            name = motors.get(re.sub("_(torque|force)$", "", entry), entry)
            felt.append(gears.get(name, 1.0) * inputs[name])
        theirs = accelerations(read, own, own.f(state_of(given, read, own), felt))
        ours = renamed(accelerations(system, model, model.f(x, u)), read)
        assert largest_gap(ours, theirs) <= AGREE


@pytest.mark.parametrize("name", TREES)
def test_written_mjcf_is_read_as_the_same_machine(name: str, tmp_path: Path) -> None:
    system = systems.get(name)
    (tmp_path / "model.xml").write_text(mjcf_text(system))
    read = read_mjcf(tmp_path / "model.xml")
    assert read.name == system.name
    same_when_read(system, model_of(name), read, {}, {"hoist": -1.0})


def everything(*, friction: float = 0.0, spring: bool = True, ball: bool = True) -> System:
    """A machine with joints of every kind, oblique axes, springs, dampers and limits."""
    s, p = length("s", 0.2, 0.9, speed=2.0), angle("p", -1.0, 1.2)
    q, roll, lift, side = angle("q", speed=3.0), angle("roll"), length("lift"), length("side", -0.4)
    tilt, k = parameter("tilt", 0.3, "rad"), parameter("k", 30.0, "N m/rad")
    sled = move(0.1, s / 2, 0.3 + s * 3**0.5 / 2) @ rot_x(tilt)
    arm = sled @ move(0.2, 0, 0.1) @ rot_y(0.4 - p) @ rot_z(0.7)
    hand = arm @ move(0, 0.3, 0) @ (orient(rotation("T")) if ball else rot_x(roll))
    drum = move(1, 0, 0) @ rot_y(lift / 0.5)
    six = (0.3, 0.2, 0.25, 0.02, -0.01, 0.03)
    bodies = [
        Body("sled", sled, mass=2, inertia=six, shape=Box(0.3, 0.2, 0.1, at=(0.1, 0, 0))),
        Body("arm bar", arm @ move(0, 0.15, 0), mass=1.5, inertia=six, shape=Capsule(0.05, 0.3)),
        Body("badge", arm, shape=Sphere(0.1), color=(0.1, 0.5, 0.9)),
        Body("tool", hand @ rot_x(0.5) @ move(0, 0, 0.25), mass=0.7, inertia=six),
        Body("drum", drum @ rot_x(0.2), mass=0.5, inertia=(0.02, 0.04, 0.02)),
        Body("wing", move(0, 2, 1) @ rot_z(q + 0.3) @ move(side, 0.1), mass=0.4, inertia=0.05),
        Body("post", move(0, 0, 0.5) @ rot_x(0.1), shape=Cylinder(0.1, 1, axis="x")),
    ]
    efforts: list[Any] = [Viscous(3 * rate(s), 0.4), Viscous(rate(q), 0.2), Viscous(rate(lift), 2)]
    if spring:
        efforts += [Potential(k * (p - 0.2) ** 2 / 2 + 5 * lift**2), Potential(p**2)]
    if friction:
        efforts.append(Coulomb(rate(p), friction))
    return System(
        "everything",
        bodies=bodies,
        gravity=toward("-z", 9.81),
        efforts=efforts,
        inputs=[
            Torque("bend", on=bodies[1], about=sled.y, limit=4.0, reacts_on=bodies[0]),
            Torque("wind", on=bodies[4], about=move(1, 0, 0).y, limit=3.0),
        ],
    )


FACTORS = {"lift": 2.0}  # the drum turns by lift / 0.5


def test_joints_of_every_kind_move_in_mujoco_as_they_do_here() -> None:
    system = everything()
    engine = InMujoco(mjcf_text(system), factors=FACTORS)
    same_in_mujoco(system, system.model(), engine)
    assert np.allclose(engine.model.joint("s").range, [0.2, 0.9], rtol=1e-15)
    assert engine.model.joint("side").range.tolist() == [-0.4, 1e6]


def test_what_mujoco_starts_with_is_within_limits() -> None:
    model: Any = mujoco.MjModel.from_xml_string(mjcf_text(systems.get("crane")))
    assert model.qpos0[model.joint("l").qposadr[0]] == 1.5


@pytest.mark.parametrize("form", ["mjcf", "urdf"])
def test_joints_of_every_kind_are_read_as_they_were(form: str, tmp_path: Path) -> None:
    if form == "mjcf":
        system = everything()
        (tmp_path / "model.xml").write_text(mjcf_text(system))
        read = read_mjcf(tmp_path / "model.xml")
    else:
        system = everything(spring=False, ball=False, friction=0.7)
        (tmp_path / "model.urdf").write_text(urdf_text(system))
        read = read_urdf(tmp_path / "model.urdf")
        speeds = {c.name: c.speed for c in read.coordinates}
        assert (speeds["s"], speeds["q"]) == (2.0, 3.0)
    own, model = read.model(), system.model()
    for given, x, u in instants(system, model, 5):
        given["lift"] = FACTORS["lift"] * given["lift"]
        turned = dict(zip(("bend", "wind"), u * [-1.0, 1.0], strict=True))  # p turns about -y
        turned |= {"p_torque": turned["bend"], "lift_torque": turned["wind"]}
        felt = [turned[name] for name in own.control_names]
        slope = own.f(state_of(given, read, own), felt)
        ours, theirs = accelerations(system, model, model.f(x, u)), accelerations(read, own, slope)
        ours["lift"] = FACTORS["lift"] * ours["lift"]
        assert largest_gap(ours, {name: theirs[name] for name in ours}) <= AGREE


PINOCCHIO: dict[str, tuple[dict[str, tuple[str, float]], dict[str, float], str]] = {
    # Joint and sign of every input, damping by joint, and the link in whose axes poses are.
    "acrobot_v0": ({"tau": ("q2", 1.0)}, {}, "axes of acrobot_v0"),
    "pendulum": ({"torque": ("theta", 1.0)}, {}, "axes of pendulum"),
    "crane": (
        {"travel": ("x", 1.0), "traverse": ("y", 1.0), "hoist": ("l", -1.0)},
        {"x": 2500.0, "y": 1000.0, "l": 2000.0, "theta_x": 2000.0, "theta_y": 2000.0},
        "world",
    ),
    "everything": (
        {"bend": ("p", -1.0), "wind": ("lift", 1.0)},
        {"s": 3.6, "q": 0.2, "lift": 0.5},
        "world",
    ),
}


@pytest.mark.parametrize("name", PINOCCHIO)
def test_machines_move_in_pinocchio_as_they_do_here(name: str) -> None:
    """Where gravity is not along -z, poses are those below the link of the machine's axes."""
    system = everything(spring=False, ball=False) if name == "everything" else systems.get(name)
    joints, damping, axes = PINOCCHIO[name]
    text, model = urdf_text(system, partial=name == "crane"), system.model()
    engine = InPinocchio(text, FACTORS if name == "everything" else None)
    for given, x, u in instants(system, model, 5):
        inputs = zip((joints[entry.name] for entry in system.inputs), u, strict=True)
        forces = {joint: sign * value for (joint, sign), value in inputs}
        theirs = engine.accelerations(given, forces, damping)
        assert largest_gap(accelerations(system, model, model.f(x, u)), theirs) <= AGREE
        for body, row in zip(system.bodies, model.frames(x), strict=True):
            assert np.abs(engine.pose(body.name, axes)[:3] - row.reshape(3, 4)).max() <= PLACED


def test_damping_and_friction_are_in_the_file() -> None:
    """Pinocchio reads them, and leaves them to its user."""
    text = urdf_text(everything(spring=False, ball=False, friction=0.7))
    model = InPinocchio(text).model
    for name, damping in {"s": 3.6, "q": 0.2, "lift": 0.5, "p": 0.0}.items():
        index = model.joints[model.getJointId(name)].idx_v
        assert abs(model.damping[index] - damping) < 1e-14
        assert model.friction[index] == (0.7 if name == "p" else 0.0)


@pytest.mark.parametrize("name", ["acrobot_v0", "pendulum"])
def test_written_urdf_is_read_as_the_same_machine(name: str, tmp_path: Path) -> None:
    system = systems.get(name)
    (tmp_path / "model.urdf").write_text(urdf_text(system))
    read = read_urdf(tmp_path / "model.urdf")
    same_when_read(system, model_of(name), read, {"q2": "tau", "theta": "torque"}, {})


def free_body() -> System:
    place = move(length("x"), length("y"), length("z")) @ orient(rotation("R"))
    hull = Body("hull", place @ move(0.1, 0, 0), mass=2, inertia=(1, 2, 2.5), shape=Sphere(0.2))
    wheel = Body("wheel", place @ move(0, 1, 0) @ rot_y(angle("a")), mass=1, inertia=0.1)
    return System("free", bodies=[hull, wheel], gravity=toward("-z"))


def test_what_is_free_has_one_joint_in_both_formats(tmp_path: Path) -> None:
    system = free_body()
    model = system.model()
    same_in_mujoco(system, model, InMujoco(mjcf_text(system), FREE))
    text = urdf_text(system)
    kinds = {one.get("name"): one.get("type") for one in ElementTree.fromstring(text).iter("joint")}
    assert (kinds["R"], kinds["a"]) == ("floating", "continuous")
    assert not kinds.keys() & {"x", "y", "z"}
    assert InPinocchio(text).model.nv == model.nv
    (tmp_path / "model.urdf").write_text(text)
    same_when_read(system, model, read_urdf(tmp_path / "model.urdf"), {}, {})


def test_lengths_with_limits_stay_joints_of_their_own() -> None:
    x, y, z = length("x", -5, 5), length("y"), length("z")
    hull = Body("hull", move(x, y, z) @ orient(rotation("R")), mass=2, inertia=(1, 2, 2.5))
    system = System("free", bodies=[hull])
    engine = InMujoco(mjcf_text(system))
    same_in_mujoco(system, system.model(), engine)
    assert engine.model.joint("x").range.tolist() == [-5.0, 5.0]


def coupled() -> System:
    """Two fingers, of which the second one goes the other way twice as far."""
    p, q = angle("p"), length("q", 0.0, 0.1)
    palm = rot_y(p) @ move(0, 0, 0.3)
    bodies = [
        Body("palm", palm, mass=1, inertia=0.1),
        Body("left", palm @ move(q, 0, 0.1), mass=0.3, inertia=0.01),
        Body("right", palm @ move(-2 * q, 0, 0.1), mass=0.2, inertia=0.01),
    ]
    grip = Force("grip", on=bodies[1], along=palm.x, limit=3.0, reacts_on=bodies[0])
    return System("fingers", bodies=bodies, gravity=toward("-z", 9.81), inputs=[grip])


def test_joints_of_one_coordinate_are_coupled_in_mujoco() -> None:
    """MuJoCo's equations without the coupling, projected onto p and q."""
    system = coupled()
    model, engine = system.model(), InMujoco(mjcf_text(system))
    (row,) = engine.model.eq_data
    assert row[:5].tolist() == [0.0, 2.0, 0.0, 0.0, 0.0]
    for given, x, u in instants(system, model, 5):
        both = {**given, "q follower": 2.0 * given["q"]}
        engine.accelerations(both, {"grip": u[0]})
        data, mass = engine.data, np.zeros((3, 3))
        mujoco.mj_fullM(engine.model, data, mass)
        onto = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 2.0]])  # p, q and its follower
        names = [engine.model.joint(k).name for k in range(3)]
        onto = onto[[("p", "q", "q follower").index(name) for name in names]]
        slope = np.linalg.solve(onto.T @ mass @ onto, onto.T @ data.qfrc_smooth)
        theirs = {"p": slope[:1], "q": slope[1:]}
        assert largest_gap(accelerations(system, model, model.f(x, u)), theirs) <= AGREE


@pytest.mark.parametrize("form", ["mjcf", "urdf"])
def test_coupled_joints_are_read_as_one_coordinate(form: str, tmp_path: Path) -> None:
    system = coupled()
    write, read, name = {
        "mjcf": (mjcf_text, read_mjcf, "model.xml"),
        "urdf": (urdf_text, read_urdf, "model.urdf"),
    }[form]
    (tmp_path / name).write_text(write(system))
    same_when_read(system, system.model(), read(tmp_path / name), {"q": "grip"}, {})


@pytest.mark.parametrize("name", ["ant", "half_cheetah", "inverted_double_pendulum", "pusher"])
def test_models_of_others_are_written_as_they_were_read(name: str) -> None:
    """Rotors and springs, too; MuJoCo's own model of its own file is the other engine's test."""
    system = read_mjcf(ASSETS / f"{name}.xml")
    free = {c.name: tuple(f"{c.name}_at_{axis}" for axis in "xyz") for c in system.coordinates}
    engine = InMujoco(mjcf_text(system), free)
    names, model = [entry.name for entry in system.inputs], system.model()
    for given, x, u in instants(system, model, 3):
        theirs = engine.accelerations(given, dict(zip(names, u, strict=True)))
        assert largest_gap(accelerations(system, model, model.f(x, u)), theirs) <= AGREE


@pytest.mark.skipif(not FOLDER.is_dir(), reason="needs example-robot-data")
@pytest.mark.parametrize(
    "name", ["ur_description/urdf/ur5_robot.urdf", "solo_description/robots/solo12.urdf"]
)
def test_robots_of_others_are_written_as_they_were_read(name: str) -> None:
    floating = "solo" in name
    system = read_urdf(FOLDER / name, base="floating" if floating else "fixed", shapes=False)
    engine = InMujoco(mjcf_text(system), {"base": ("x", "y", "z")})
    names, model = [entry.name for entry in system.inputs], system.model()
    for given, x, u in instants(system, model, 3):
        theirs = engine.accelerations(given, dict(zip(names, u, strict=True)))
        assert largest_gap(accelerations(system, model, model.f(x, u)), theirs) <= AGREE


def wrong() -> System:
    """A machine with much that no file has."""
    x, q, r = length("x"), angle("q"), angle("r")
    arm = move(x, 0, 0) @ rot_z(q)
    body = Body("body", arm, mass=1, inertia=1)
    odd = Body("odd", move(x**2, 0, 0), mass=1, inertia=1)
    flat = Body("flat", move(0, 1, 0) @ rot_z(r), mass=1, inertia=1)
    u, drive = Control("u", limit=1.0), Drive("d", on=r, limit=1.0)
    return System(
        "wrong",
        bodies=[body, odd, flat],
        gravity=toward("-z", 1.62),
        constraints=[zero(rate(x) - rate(q), "rolls")],
        inputs=[u, drive],
        efforts=[
            Wrench(on=body, force=(u.symbol**2, 0, 0)),
            Wrench(on=body, torque=(0, 0, -rate(q) * abs(rate(q)))),
            Coulomb(rate(q), 1.0, 0.5),
            Viscous(rate(x) + rate(q), 1.0),
            Potential(q**4),
            Spring(between=(arm, move(0, 0, 0)), stiffness=1),
            Buoyancy(on=body, lift=1),
        ],
    )


def test_all_that_a_file_lacks_is_named_at_once() -> None:
    with pytest.raises(InputError) as caught:
        mjcf_text(wrong())
    said = str(caught.value)
    for part in (
        "body 'odd': its frame moves by x**2, which is not linear",
        "constraint 'rolls'",
        "input 'd': it is a Drive",
        "input 'u': its force is not constant times the input",
        "wrench on body 'body': no input gives it",
        "Coulomb friction of q_dot: it is smoothed by 0.5",
        "viscous friction of q_dot + x_dot",
        "its energy q**4 is not that of springs",
        "spring: it is no friction or spring of a joint",
        "buoyancy: it is no friction or spring of a joint",
    ):
        assert part in said, part


def test_a_coordinate_of_a_frame_that_is_refused_is_no_further_trouble() -> None:
    """Its friction, spring and motor have no joint to go to."""
    q = angle("q")
    odd = Body("odd", move(q**2, 0, 0) @ rot_z(q), mass=1, inertia=1)
    base = Body("base", move(length("x"), 0, 0), mass=1)
    system = System(
        "odd",
        bodies=[odd, base],
        inputs=[Torque("turn", on=odd, about=rot_z(q).z, limit=1.0)],
        efforts=[Viscous(rate(q), 1.0), Potential(q**2)],
    )
    with pytest.raises(InputError) as caught:
        mjcf_text(system)
    assert [mistake.where for mistake in caught.value.mistakes] == ["body 'odd'"]
    idle = angle("idle")
    system = System("idle", bodies=[base], efforts=[Potential(idle**2)])
    with pytest.raises(InputError, match="coordinate 'idle': it moves no body"):
        mjcf_text(system)


def test_what_only_one_format_lacks_is_named() -> None:
    with pytest.raises(InputError, match="MuJoCo's frictionloss is another law"):
        mjcf_text(everything(friction=1.0))
    with pytest.raises(InputError) as caught:
        urdf_text(everything())
    said = str(caught.value)
    assert "rotation 'T': URDF has no joint" in said
    assert "joint 'p': it has a spring" in said
    named = Body("world", rot_z(angle("r")), mass=1, inertia=1)
    with pytest.raises(InputError, match="files give this name to the world"):
        mjcf_text(System("flat", bodies=[named]))
    sled = Body("sled", move(length("x")), mass=1)
    with pytest.raises(InputError, match=r"it is 1\.62 m/s"):
        urdf_text(System("moon", bodies=[sled], gravity=toward("-z", 1.62)))


def test_what_may_be_left_out_is_left_out() -> None:
    """Of a submarine, its added mass, drag and buoyancy: a body that is pushed remains."""
    text = mjcf_text(systems.get("submarine"), partial=True)
    model: Any = mujoco.MjModel.from_xml_string(text)
    assert (model.nv, model.nu) == (6, 3)
    model = mujoco.MjModel.from_xml_string(mjcf_text(everything(friction=1.0), partial=True))
    assert not model.dof_frictionloss.any()


@pytest.mark.parametrize("form", ["mjcf", "urdf"])
def test_the_command_writes_models(
    form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = {"mjcf": "acrobot_v0.xml", "urdf": "acrobot_v0.urdf"}[form]
    assert cli.run(["export", "acrobot_v0", "--format", form, "--out", str(tmp_path)]) == 0
    write = {"mjcf": mjcf_text, "urdf": urdf_text}[form]
    assert (tmp_path / name).read_text() == write(systems.get("acrobot_v0"))
    assert [path.name for path in tmp_path.iterdir()] == [name]
    said = capsys.readouterr().out
    assert f"written to {tmp_path / name}" in said
    assert ("python -m mujoco.viewer" in said) == (form == "mjcf")


def test_the_command_names_what_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ["--out", str(tmp_path)]
    assert cli.run(["export", "submarine", "--format", "mjcf", *where]) == 2
    said = capsys.readouterr().err
    assert "it has added mass" in said
    assert "buoyancy" in said
    assert not [*tmp_path.iterdir()]
    assert cli.run(["export", "submarine", "--format", "mjcf", "--partial", *where]) == 0
    assert (tmp_path / "submarine.xml").is_file()
    assert cli.run(["export", "pendulum", "--partial", *where]) == 2
    assert "nothing else leaves anything out" in capsys.readouterr().err
    assert cli.run(["export", "pendulum", "--format", "sdf", *where]) == 2

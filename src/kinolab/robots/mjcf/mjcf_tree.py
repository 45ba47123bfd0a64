"""The tree of an MJCF file: links, joints, springs, friction, masses, and what may touch."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import listed
from kinolab.numerics.arrays import Array
from kinolab.robots.mjcf.compiled_model import WORLD_BODY, CompiledModel
from kinolab.robots.mjcf.mjcf_actuators import ActuatorReader
from kinolab.robots.mjcf.mjcf_equalities import closures, followers
from kinolab.robots.mjcf.mjcf_fields import disabled, not_looked_at, unknown_flags
from kinolab.robots.mjcf.mjcf_geoms import GeomReader
from kinolab.robots.mjcf.mjcf_tendons import tendons
from kinolab.robots.tree.kinematic_tree import (
    Inertial,
    Joint,
    JointKind,
    KinematicTree,
    Link,
    Mimicked,
    pose_of,
)

KINDS: Mapping[str, JointKind] = {
    "FREE": "floating",
    "BALL": "ball",
    "SLIDE": "prismatic",
    "HINGE": "revolute",
}


def tree_of(compiled: CompiledModel, geoms: GeomReader, *, commands: bool) -> KinematicTree:
    """Return a model as a tree of links and joints.

    Args:
        commands: Whether inputs of servos whose forces have limits are their commands.
    """
    model = compiled.model
    links: list[Link] = []
    joints: list[Joint] = []
    follows = followers(compiled)
    for body in range(model.nbody):
        own, moving = _hung(compiled, geoms, body, follows)
        links += own
        joints += moving
    for told in (unknown_flags, not_looked_at):
        for what in told(compiled.mujoco, model):
            compiled.cannot(what)
    name = model.names.split(b"\0", 1)[0].decode(errors="replace")
    x, y, z = map(float, model.opt.gravity)
    actuators = ActuatorReader(compiled, commands=commands)
    motors, acting = tuple(actuators.motors()), tuple(actuators.actuators())
    solids = [geoms.solid_geoms(body) for body in range(model.nbody)]
    return KinematicTree(
        name or compiled.path.stem,
        tuple(links),
        tuple(joints),
        motors,
        (x, y, z),
        thrusters=tuple(actuators.thrusters()),
        actuators=acting,
        aims=tuple(actuators.aims),
        tendons=tuple(tendons(compiled)),
        closures=tuple(closures(compiled)),
        allowed=allowed_pairs(model, compiled.bodies, solids),
        notes=tuple(_notes(compiled, geoms, actuators)),
    )


def _notes(compiled: CompiledModel, geoms: GeomReader, actuators: ActuatorReader) -> Iterator[str]:
    """Yield what has a meaning for motions in MuJoCo, and none or another one in the machine."""
    mocap = [compiled.bodies[k] for k in np.flatnonzero(compiled.model.body_mocapid >= 0)]
    equality = compiled.names("EQUALITY", compiled.model.neq, "equality")
    for sentence, names in {
        "mocap bodies, which are moved from outside, stand still: {}.": mocap,
        "keyframes are not read: {}. [start] of a scenario says where it begins.": compiled.names(
            "KEY", compiled.model.nkey, "key"
        ),
        "what is switched off is not read: {}.": [
            *(equality[k] for k in np.flatnonzero(compiled.model.eq_active0 == 0)),
            *actuators.off,
        ],
        'the ground is not read: {}. Write ground = "plane" below [world].': geoms.grounds(),
        "servos without ctrlrange are motors, whose inputs are forces: {}.": actuators.unaimed,
        "servos with a negative kp or kv drive their joints away: {}.": actuators.driving,
        "actearly is a matter of time steps, and is not read: {}.": actuators.early,
    }.items():
        if told := listed(names):
            yield sentence.format(told)


def _hung(
    compiled: CompiledModel, geoms: GeomReader, body: int, follows: Mapping[str, Mimicked]
) -> tuple[list[Link], list[Joint]]:
    """Return the links and joints of a body: one link for every joint, the last one it."""
    model, name = compiled.model, compiled.bodies[body]
    link, around = geoms.link(body, _inertial(compiled, body))
    link = replace(link, borne=float(model.body_gravcomp[body]))
    held = [Joint(f"{one.name} fixed", "fixed", name, one.name) for one in around]
    if body == WORLD_BODY:
        return [link, *around], held
    parent = compiled.bodies[int(model.body_parentid[body])]
    pose = pose_of(model.body_pos[body], compiled.turn(model.body_quat[body]))
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    if not count:
        return [link, *around], [Joint(f"{name} fixed", "fixed", parent, name, pose), *held]
    links, joints = [link], []
    for k in range(first, first + count):
        last = k == first + count - 1
        child = name if last else f"{name} after {compiled.joints[k]}"
        if not last:
            links.append(Link(child))
        joint = _joint(compiled, k, parent, child, follows)
        joints.append(joint if joint.kind == "floating" else replace(joint, pose=pose))
        parent, pose = child, np.eye(4)
    return links, joints


def _joint(
    compiled: CompiledModel, k: int, parent: str, child: str, follows: Mapping[str, Mimicked]
) -> Joint:
    """Return a joint without its pose."""
    model, name = compiled.model, compiled.joints[k]
    kind = KINDS[compiled.mujoco.mjtJoint(int(model.jnt_type[k])).name.removeprefix("mjJNT_")]
    lower, upper = map(float, model.jnt_range[k]) if model.jnt_limited[k] else (-math.inf, math.inf)
    idle = model.jnt_actfrclimited[k] or "ACTUATION" in disabled(compiled.mujoco, model)
    if idle and model.jnt_actgravcomp[k] and model.body_gravcomp.any():
        what = f"joint {name} has actuatorgravcomp, and a limit of the force of all its actuators."
        compiled.cannot(what, "Leave its actuatorfrcrange out, and let actuators be enabled.")
    dof, at = int(model.jnt_dofadr[k]), int(model.jnt_qposadr[k])
    damping, stiffness = (
        compiled.powers(*own) for own in (("dof_damping", dof), ("jnt_stiffness", k))
    )
    joint = Joint(
        *(name, kind, parent, child),
        upper=upper,
        anchor=np.zeros(3) if kind == "prismatic" else np.array(model.jnt_pos[k]),
        damping=damping[0],  # of its first rate, as friction and rotor are
        higher_damping=damping[1:],
        friction=float(model.dof_frictionloss[dof]),
        armature=float(model.dof_armature[dof]),
        stiffness=stiffness[0],
        higher_stiffness=stiffness[1:],
    )
    if kind in ("revolute", "prismatic"):
        return replace(
            joint,
            axis=np.array(model.jnt_axis[k]),
            lower=lower,
            mimics=follows.get(name),
            zero=float(model.qpos0[at]),
            rest=float(model.qpos_spring[at]),
        )
    if any(stiffness[1::2]):
        what = (
            f"the {'free' if kind == 'floating' else kind} joint {name} has a stiffness with the "
            f"coefficient {stiffness[1]:g} of the square of an angle, which has a kink at rest."
        )
        compiled.cannot(what, "The coefficients of its first and third power are read.")
    width = 4 if kind == "ball" else 7
    *place, w, x, y, z = map(float, model.qpos_spring[at : at + width])
    return replace(joint, rests=(*place, x, y, z, w))


def _inertial(compiled: CompiledModel, body: int) -> Inertial | None:
    model = compiled.model
    if body == WORLD_BODY or not (model.body_mass[body] or model.body_inertia[body].any()):
        return None
    kinds, kind = compiled.mujoco.mjtSameFrame, int(model.body_sameframe[body])
    turn, at = compiled.turn(model.body_iquat[body]), np.array(model.body_ipos[body])
    if kind == int(kinds.mjSAMEFRAME_BODY):  # what is off by rounding does not move it
        turn, at = np.eye(3), np.zeros(3)
    elif kind == int(kinds.mjSAMEFRAME_BODYROT):
        turn = np.eye(3)
    inertia: Array = turn @ np.diag(model.body_inertia[body]) @ turn.T
    return Inertial(float(model.body_mass[body]), at, inertia)


def allowed_pairs(
    model: Any, names: Sequence[str], solids: Sequence[Sequence[int]]
) -> frozenset[frozenset[str]]:
    """Return the pairs of bodies, by name, that MuJoCo's filter keeps from colliding.

    Two geoms collide if the type of one shares a bit with the affinity of the other one. Bodies do
    if some of their geoms do and no ``<exclude>`` names them, or if a ``<pair>`` names two of them.

    Args:
        solids: Of each body the geoms that are solids.

    Source: MuJoCo's documentation, chapter Computation, Collision detection: filtering.
    """
    types, affinities = (
        _bits(values, solids) for values in (model.geom_contype, model.geom_conaffinity)
    )
    excluded = {divmod(int(signature), 1 << 16) for signature in model.exclude_signature}
    geoms = zip(model.pair_geom1, model.pair_geom2, strict=True)
    wanted = {frozenset(int(model.geom_bodyid[g]) for g in pair) for pair in geoms}
    return frozenset(
        frozenset((names[a], names[b]))
        for a, b in combinations([body for body, own in enumerate(solids) if own], 2)
        if frozenset((a, b)) not in wanted
        and (
            not (types[a] & affinities[b] or types[b] & affinities[a])
            or {(a, b), (b, a)} & excluded
        )
    )


def _bits(values: NDArray[np.int32], solids: Sequence[Sequence[int]]) -> list[int]:
    """Return of each body the bits that any of its geoms has."""
    return [int(np.bitwise_or.reduce(values[[*own]], initial=0)) if own else 0 for own in solids]

"""Reading MJCF files, MuJoCo's models, by MuJoCo itself.

Source: MuJoCo's documentation, XML reference and chapter Computation (joints, actuators, passive
forces, equality constraints).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import ParseError, iterparse

import numpy as np

from kinolab.arguments import require_fit
from kinolab.dynamics import System
from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Shape, Sphere
from kinolab.errors import InputError, Mistake
from kinolab.files import is_file
from kinolab.lazy import library_of
from kinolab.numerics.arrays import Array
from kinolab.robots.compared.mujoco_engine import MujocoEngine, quiet
from kinolab.robots.kinematic_tree import (
    MOST_BYTES,
    MOST_LINKS,
    Closure,
    Inertial,
    Joint,
    JointKind,
    KinematicTree,
    Link,
    Mimicked,
    PlacedShape,
    VisibleMesh,
    pose_of,
)
from kinolab.robots.mjcf_actuators import ActuatorReader
from kinolab.robots.mjcf_contacts import allowed_pairs
from kinolab.robots.mjcf_fields import (
    apply_flags,
    disabled,
    names_of,
    not_finite,
    not_looked_at,
    turn_of,
    unknown_flags,
)
from kinolab.robots.robot_machine import assembled
from kinolab.robots.solids.convex_parts import check_parts, enclosing_shapes
from kinolab.robots.solids.enclosing import enclosing_shape
from kinolab.robots.tree_mistakes import tree_mistakes
from kinolab.world.shape_surfaces import Faces

WORLD_BODY = 0
CLOSING = ("connect", "weld")  # equality constraints that close loops
# [m], edges of the cube that stands for the half-space behind a plane, which has no end: in its
# middle a surface is where it should be but for rounding, 1e-10 m
DEEP = 2e6
LEVEL = 1e-9  # of a plane's normal, and of its height in [m]: less is rounding


def read_mjcf(
    path: str | Path,
    *,
    locked: Mapping[str, float] | None = None,
    shapes: bool = True,
    self_collisions: bool = True,
    convex_parts: int | None = None,
    partial: bool = False,
) -> System:
    """Read a robot from an MJCF file as a machine.

    Bodies without joints are fixed to their parents. A motor's limit is that of its control, times
    gain and gear, or that of its force or of its joint's; servos become motors with their force
    limit, and requirements of what their gain and ``ctrlrange`` let them do where they are;
    actuators of fixed tendons act on all joints of these. Springs of hinges and slides
    count, and so do friction and rotors (``armature``) of all joints; the range of a ball joint is
    a requirement of the machine. Contacts between bodies do not push, as in all of kinolab. Flags
    that disable forces, limits or actuators do so; solids keep apart all the same where a flag
    disables contacts. What is fixed to the world is not touched, but by what rests on it or turns
    about it; planes are walls and floors, except the ground z = 0, which a scenario has or not.
    Bodies that are connected or welded to others close loops, exactly instead of softly. Geoms that
    collide count, or those that are drawn where a body has none; meshes and ellipsoids are enclosed
    in boxes and capsules.

    Args:
        path: The file.
        locked: Positions of joints that do not move, by name, in [rad] or [m].
        shapes: Whether to read shapes at all.
        self_collisions: Whether bodies may not touch each other: those that can and are not
            neighbours, nor of one robot and touch at rest, or may by the file's ``contype``,
            ``conaffinity``, ``<exclude>`` and ``<pair>``.
        convex_parts: How many parts a mesh may be divided into, each with a box or capsule of its
            own, instead of one around the whole.
        partial: Whether to leave out what cannot be represented.

    Raises:
        InputError: With everything in the file that cannot be represented, such as tendons, muscles
            or a fluid, unless ``partial``, and with numbers that are not finite. All of MuJoCo's
            model is looked at, so that nothing is left out in silence. With the joint at which the
            machine moves otherwise than MuJoCo's own model, unless something is left out.
    """
    require_fit("read_mjcf path", str | Path, path)
    require_fit("read_mjcf locked", Mapping[str, float] | None, locked)
    path = Path(path)
    check_parts(convex_parts, path.name)
    reader = _ModelReader(path, shapes=shapes, convex_parts=convex_parts)
    tree = reader.tree()
    mistakes = [*tree_mistakes(tree, locked or {}, path.name)]
    if not partial:
        mistakes += reader.left_out
    if mistakes:
        raise InputError(mistakes)
    return assembled(
        tree,
        locked=locked,
        self_collisions=self_collisions,
        where=path.name,
        file=reader.content(),
        engines=() if reader.left_out else (reader.engine(),),  # which leaves nothing out
    )


def _compiled(mujoco: Any, path: Path) -> Any:
    """Return MuJoCo's model of a file."""
    if not is_file(path):
        raise InputError([Mistake(str(path), "there is no such file.")])
    if path.stat().st_size > MOST_BYTES:
        what = f"it is larger than {MOST_BYTES // 10**6} MB."
        raise InputError([Mistake(path.name, what)])
    if _first_element(path) == "robot":
        what = "it begins with <robot>, so that it is a URDF file."
        raise InputError([Mistake(path.name, what, "Give it a name that ends with .urdf.")])
    with quiet(mujoco):
        try:
            model = mujoco.MjModel.from_xml_path(str(path))
        except Exception as error:  # of its compiler, of several kinds
            what = f"MuJoCo does not read it ({' '.join(str(error).split())})."
            raise InputError([Mistake(path.name, what)]) from error
    if model.nbody > MOST_LINKS:
        raise InputError([Mistake(path.name, f"it has more than {MOST_LINKS} bodies.")])
    return model


def _first_element(path: Path) -> str:
    """Return the name of a file's first element; empty where it is no XML."""
    try:
        with path.open("rb") as file:
            return next(str(found.tag) for _, found in iterparse(file, events=["start"]))
    except (ParseError, StopIteration):
        return ""  # MuJoCo will say why


class _ModelReader:
    """Converts MuJoCo's model, and collects what cannot be represented."""

    def __init__(self, path: Path, *, shapes: bool, convex_parts: int | None) -> None:
        self.left_out: list[Mistake] = []
        self._mujoco = library_of("robots", "mujoco", "MJCF files are read by MuJoCo")
        self._path, self._shapes, self._convex_parts = path, shapes, convex_parts
        self._model = model = _compiled(self._mujoco, path)
        self._bodies = self._names("BODY", model.nbody, "body")
        self._joints = self._names("JOINT", model.njnt, "joint")
        self._geom_names = self._names("GEOM", model.ngeom, "geom")
        self._placed = self._mujoco.MjData(model)
        self._mujoco.mj_kinematics(model, self._placed)
        off = disabled(self._mujoco, model)
        self._original = copy(model) if off else model  # with its flags
        apply_flags(self._mujoco, model)
        if broken := [Mistake(path.name, what) for what in not_finite(self._mujoco, model)]:
            raise InputError(broken)

    def engine(self) -> MujocoEngine:
        """Return MuJoCo's own model of the file, once all of it is read."""
        return MujocoEngine(self._mujoco, self._original, self._joints)

    def content(self) -> bytes:
        """Return all of the file that MuJoCo compiled."""
        whole = np.empty(self._mujoco.mj_sizeModel(self._original), dtype=np.uint8)
        self._mujoco.mj_saveModel(self._original, None, whole)
        return whole.tobytes()

    def _names(self, kind: str, count: int, word: str) -> list[str]:
        return names_of(self._mujoco, self._model, kind, count, word)

    def _cannot(self, what: str, remedy: str = "") -> None:
        self.left_out.append(Mistake(self._path.name, what, remedy))

    def tree(self) -> KinematicTree:
        """Return the model as a tree of links and joints."""
        model = self._model
        links: list[Link] = []
        joints: list[Joint] = []
        follows = self._follows()
        for body in range(model.nbody):
            own, moving = self._hung(body, follows)
            links += own
            joints += moving
        self._note_what_is_left_out()
        name = model.names.split(b"\0", 1)[0].decode(errors="replace")
        x, y, z = map(float, model.opt.gravity)
        actuators = ActuatorReader(self._mujoco, model, self._joints, self._bodies, self._cannot)
        return KinematicTree(
            name or self._path.stem,
            tuple(links),
            tuple(joints),
            tuple(actuators.motors()),
            (x, y, z),
            thrusters=tuple(actuators.thrusters()),
            pulls=tuple(actuators.pulls()),
            servos=tuple(actuators.servos),
            closures=tuple(self._closures()),
            allowed=allowed_pairs(
                model, self._bodies, [*map(self._solid_geoms, range(model.nbody))]
            ),
        )

    def _hung(self, body: int, follows: Mapping[str, Mimicked]) -> tuple[list[Link], list[Joint]]:
        """Return the links and joints of a body: one link for every joint, the last one it."""
        model, name = self._model, self._bodies[body]
        stands = self._stands(body)
        around = self._standing(body) if stands else []
        geoms = () if stands else self._solid_geoms(body)
        solids = tuple(s for g in geoms for s in self._solids(g))
        visible = tuple(self._visible(body)) if self._shapes else ()
        link = Link(name, self._inertial(body), solids, visible)
        held = [Joint(f"{one.name} fixed", "fixed", name, one.name) for one in around]
        if body == WORLD_BODY:
            return [link, *around], held
        parent = self._bodies[int(model.body_parentid[body])]
        pose = pose_of(model.body_pos[body], self._turn(model.body_quat[body]))
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        if not count:
            return [link, *around], [Joint(f"{name} fixed", "fixed", parent, name, pose), *held]
        links, joints = [link], []
        for k in range(first, first + count):
            last = k == first + count - 1
            child = name if last else f"{name} after {self._joints[k]}"
            if not last:
                links.append(Link(child))
            free = int(model.jnt_type[k]) == int(self._mujoco.mjtJoint.mjJNT_FREE)
            joints.append(self._joint(k, parent, child, np.eye(4) if free else pose, follows))
            parent, pose = child, np.eye(4)
        return links, joints

    def _joint(
        self, k: int, parent: str, child: str, pose: Array, follows: Mapping[str, Mimicked]
    ) -> Joint:
        model, types, name = self._model, self._mujoco.mjtJoint, self._joints[k]
        dof, at = int(model.jnt_dofadr[k]), int(model.jnt_qposadr[k])
        kinds: dict[Any, JointKind] = {
            types.mjJNT_FREE: "floating",
            types.mjJNT_BALL: "ball",
            types.mjJNT_SLIDE: "prismatic",
            types.mjJNT_HINGE: "revolute",
        }
        kind = kinds[types(int(model.jnt_type[k]))]
        lower, upper = -math.inf, math.inf
        if model.jnt_limited[k]:
            lower, upper = map(float, model.jnt_range[k])
        if kind in ("floating", "ball"):
            self._check_rates(k, kind)
            joint = Joint(name, kind, parent, child, pose, anchor=np.array(model.jnt_pos[k]))
            return replace(joint, upper=upper, **self._losses(dof))
        stiffness = self._powers("jnt_stiffness", k)
        return Joint(
            name,
            kind,
            parent,
            child,
            pose,
            np.array(model.jnt_axis[k]),
            lower,
            upper,
            mimics=follows.get(name),
            anchor=np.array(model.jnt_pos[k]) if kind == "revolute" else np.zeros(3),
            zero=float(model.qpos0[at]),
            stiffness=stiffness[0],
            rest=float(model.qpos_spring[at]),
            higher_stiffness=stiffness[1:],
            **self._losses(dof),
        )

    def _losses(self, dof: int) -> dict[str, Any]:
        """Return friction and rotor of a joint, those of its first rate."""
        damping = self._powers("dof_damping", dof)
        return {
            "damping": damping[0],
            "higher_damping": damping[1:],
            "friction": float(self._model.dof_frictionloss[dof]),
            "armature": float(self._model.dof_armature[dof]),
        }

    def _powers(self, name: str, k: int) -> tuple[float, ...]:
        """Return the coefficients of the first, second, … power."""
        fields = (getattr(self._model, one, None) for one in (name, f"{name}poly"))
        return tuple(float(c) for rows in fields if rows is not None for c in np.ravel(rows[k]))

    def _check_rates(self, k: int, kind: JointKind) -> None:
        """Name what a joint with several rates may not have."""
        if any(self._powers("jnt_stiffness", k)):
            word = "free" if kind == "floating" else kind
            what = (
                f"the {word} joint {self._joints[k]} has stiffness, whose torque is along the axis "
                "of the turn from where it is at rest; there is none where it rests."
            )
            self._cannot(what, "Springs of three hinges are read.")

    def _inertial(self, body: int) -> Inertial | None:
        model = self._model
        if body == WORLD_BODY or not (model.body_mass[body] or model.body_inertia[body].any()):
            return None
        kinds, kind = self._mujoco.mjtSameFrame, int(model.body_sameframe[body])
        turn, at = self._turn(model.body_iquat[body]), np.array(model.body_ipos[body])
        if kind == int(kinds.mjSAMEFRAME_BODY):  # what is off by rounding does not move it
            turn, at = np.eye(3), np.zeros(3)
        elif kind == int(kinds.mjSAMEFRAME_BODYROT):
            turn = np.eye(3)
        inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T
        return Inertial(float(model.body_mass[body]), at, inertia)

    def _turn(self, quaternion: Array) -> Array:
        return turn_of(self._mujoco, quaternion)

    def _stands(self, body: int) -> bool:
        """Whether a body is fixed to the world, and something of it collides."""
        model, above = self._model, body
        while above != WORLD_BODY and not model.body_jntnum[above]:
            above = int(model.body_parentid[above])
        return above == WORLD_BODY and any(map(self._collides, self._solid_geoms(body)))

    def _standing(self, body: int) -> list[Link]:
        """Return what collides of a body that stands, each in a link of its own."""
        drawn = any(self._visible(body))
        return [
            Link(
                f"{self._bodies[body]} {self._geom_names[g]}{f' {k + 1}' if k else ''}",
                solids=(solid,),
                visible=tuple(self._patch(g)),
                stands=True,
                hidden=drawn,
            )
            for g in self._solid_geoms(body)
            for k, solid in enumerate(self._solids(g))
        ]

    def _collides(self, g: int) -> bool:
        return bool(self._model.geom_contype[g] or self._model.geom_conaffinity[g])

    def _solid_geoms(self, body: int) -> list[int]:
        """Return the geoms that collide, or those that are drawn where none does."""
        first = int(self._model.body_geomadr[body])
        own = range(first, first + int(self._model.body_geomnum[body])) if self._shapes else ()
        return [g for g in own if self._collides(g)] or [*own]

    def _solids(self, g: int) -> Iterator[PlacedShape]:
        """Yield the shapes of a geom."""
        model, types = self._model, self._mujoco.mjtGeom
        pose = pose_of(model.geom_pos[g], self._turn(model.geom_quat[g]))
        red, green, blue, _ = map(float, model.geom_rgba[g])
        kind = int(model.geom_type[g])
        if kind == int(types.mjGEOM_MESH):
            solids = self._around_mesh(int(model.geom_dataid[g]))
        elif self._is_plane(g):
            solids = self._behind_plane(g) if self._collides(g) else []
        else:
            shape = self._shape(g)
            solids = [] if shape is None else [PlacedShape(shape, np.eye(4))]
        for solid in solids:
            yield replace(solid, pose=pose @ solid.pose, color=(red, green, blue))

    def _behind_plane(self, g: int) -> list[PlacedShape]:
        """Return the solid behind a plane, in its frame; none of the ground, of scenarios."""
        if self._is_ground(g):
            return []
        model = self._model
        turn = self._placed.geom_xmat[g].reshape(3, 3)
        centre = -turn.T @ self._placed.geom_xpos[g]  # the world's origin, wherever its own lies
        centre[2] = -DEEP / 2
        grounded = any(
            self._collides(one) and self._is_ground(one)
            for one in filter(self._is_plane, range(model.ngeom))
        )
        if grounded and abs(turn[2, 2]) < LEVEL:  # a wall stands on the ground
            centre += DEEP / 2 * turn[2]
        return [PlacedShape(Box(DEEP, DEEP, DEEP), pose_of(centre, np.eye(3)))]

    def _patch(self, g: int) -> Iterator[VisibleMesh]:
        """Yield what is drawn of a plane; of one without an end, as much as the model is large."""
        model = self._model
        if not self._is_plane(g):
            return
        x, y = (float(half) or float(model.stat.extent) for half in model.geom_size[g, :2])
        corners = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
        faces = np.array([[0, 1, 2], [0, 2, 3]])
        yield self._drawn(g, self._geom_names[g], corners, faces, model.geom_rgba[g])

    def _drawn(self, g: int, name: str, vertices: Array, faces: Faces, rgba: Array) -> VisibleMesh:
        """Return a mesh as it is drawn, of vertices (n, 3) in a geom's frame in one colour."""
        colors = np.tile(np.array(rgba[:3], dtype=float), (len(faces), 1))
        placed = vertices @ self._turn(self._model.geom_quat[g]).T + self._model.geom_pos[g]
        return VisibleMesh(name, placed, faces, colors)

    def _is_plane(self, g: int) -> bool:
        return int(self._model.geom_type[g]) == int(self._mujoco.mjtGeom.mjGEOM_PLANE)

    def _is_ground(self, plane: int) -> bool:
        """Whether a plane is that of the world's ground: z = 0, from above."""
        level = float(self._placed.geom_xmat[plane, 8]) > 1.0 - LEVEL
        return level and abs(float(self._placed.geom_xpos[plane, 2])) < LEVEL

    def _visible(self, body: int) -> Iterator[VisibleMesh]:
        """Yield the meshes that are drawn: those that do not collide, where there are any."""
        model = self._model
        first = int(model.body_geomadr[body])
        meshes = [
            g
            for g in range(first, first + int(model.body_geomnum[body]))
            if model.geom_type[g] == int(self._mujoco.mjtGeom.mjGEOM_MESH)
        ]
        only = [g for g in meshes if not (model.geom_contype[g] or model.geom_conaffinity[g])]
        for g in only or meshes:
            where, vertices, faces = self._mesh(int(model.geom_dataid[g]))
            material = int(model.geom_matid[g])
            color = model.geom_rgba[g] if material < 0 else model.mat_rgba[material]
            yield self._drawn(g, where, vertices, faces, color)

    def _mesh(self, mesh: int) -> tuple[str, Array, Faces]:
        """Return what a mesh is called, its vertices (n, 3) in [m] and its faces (m, 3)."""
        model = self._model
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        vertices = np.array(model.mesh_vert[first : first + count], dtype=float)
        first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        faces = np.array(model.mesh_face[first : first + count], dtype=np.int64)
        return f"mesh {self._names('MESH', model.nmesh, 'mesh')[mesh]}", vertices, faces

    def _around_mesh(self, mesh: int) -> list[PlacedShape]:
        """Return solids around a mesh."""
        where, vertices, faces = self._mesh(mesh)
        try:
            return enclosing_shapes(vertices, faces, self._convex_parts, where)
        except InputError as error:
            for one in error.mistakes:
                self._cannot(f"{one.where}: {one.what}", one.remedy)
            return [enclosing_shape(vertices)]

    def _shape(self, g: int) -> Shape | None:
        """Return a geom's shape, neither of a mesh nor of a plane; None where it has none."""
        model, types = self._model, self._mujoco.mjtGeom
        a, b, c = map(float, model.geom_size[g])
        kind = types(int(model.geom_type[g]))
        if kind == types.mjGEOM_SPHERE:
            return Sphere(a)
        if kind == types.mjGEOM_CAPSULE:
            return Capsule(a, 2 * b)
        if kind == types.mjGEOM_CYLINDER:
            return Cylinder(a, 2 * b)
        if kind in (types.mjGEOM_BOX, types.mjGEOM_ELLIPSOID):
            return Box(2 * a, 2 * b, 2 * c)
        word = kind.name.removeprefix("mjGEOM_").lower()
        what = f"geom {self._geom_names[g]} has the type {word}, which is no solid here."
        self._cannot(what, "Write it as meshes, or as obstacles of a scenario.")
        return None

    def _equalities(self) -> Iterator[tuple[int, str]]:
        """Yield the equality constraints that hold, with their kinds in lower case."""
        model, mujoco = self._model, self._mujoco
        for k in np.flatnonzero(model.eq_active0).tolist():
            yield k, mujoco.mjtEq(int(model.eq_type[k])).name.removeprefix("mjEQ_").lower()

    def _follows(self) -> dict[str, Mimicked]:
        """Return which joints follow others by a linear equality constraint."""
        model, found = self._model, {}
        names = self._names("EQUALITY", model.neq, "equality")
        for k, kind in self._equalities():
            if kind in CLOSING:
                continue
            first, second = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
            polynomial = np.array(model.eq_data[k, :5])
            if kind == "joint" and second >= 0 and not polynomial[2:].any():
                own, leader = self._joints[first], self._joints[second]
                if own in found:
                    self._cannot(f"equality constraint {names[k]}: joint {own} follows two others.")
                    continue
                # q1 - q1(0) = a + b (q2 - q2(0))
                zeros = [float(model.qpos0[model.jnt_qposadr[j]]) for j in (first, second)]
                factor = float(polynomial[1])
                found[own] = Mimicked(leader, factor, zeros[0] + polynomial[0] - factor * zeros[1])
            else:
                what = f"equality constraint {names[k]}, {kind}, "
                if kind != "joint":
                    self._cannot(f"{what}couples more than two joints, or what is no joint.")
                elif second < 0:
                    self._cannot(f"{what}holds {self._joints[first]}.", "Use locked instead.")
                else:
                    self._cannot(f"{what}has a polycoef that is not linear in the other joint.")
        return found

    def _closures(self) -> Iterator[Closure]:
        """Yield what ``connect`` and ``weld`` hold together, bodies or sites."""
        model, names = self._model, self._names("EQUALITY", self._model.neq, "equality")
        site = int(self._mujoco.mjtObj.mjOBJ_SITE)
        for k, kind in self._equalities():
            if kind not in CLOSING:
                continue
            first, second = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
            data = np.array(model.eq_data[k])
            welded = kind == "weld" and data[10] != 0.0  # the scale of its torque
            if int(model.eq_objtype[k]) == site:
                poses = [
                    pose_of(model.site_pos[s], self._turn(model.site_quat[s]))
                    for s in (first, second)
                ]
                first, second = (int(model.site_bodyid[s]) for s in (first, second))
            elif kind == "connect":
                poses = [pose_of(anchor, np.eye(3)) for anchor in (data[:3], data[3:6])]
            else:  # the second body's anchor comes first, then its pose in the first one's axes
                poses = [pose_of(data[3:6], self._turn(data[6:10])), pose_of(data[:3], np.eye(3))]
            ends = self._bodies[first], self._bodies[second]
            roots = (int(model.body_rootid[body]) for body in (first, second))
            if any(int(model.body_mocapid[root]) >= 0 for root in roots):
                what = f"equality constraint {names[k]} holds {ends[0]} and {ends[1]} together"
                self._cannot(f"{what}, of which one is a mocap body, moved from outside.")
                continue
            yield Closure(names[k], "pose" if welded else "point", *ends, *poses)

    def _note_what_is_left_out(self) -> None:
        """Name what the machine would lack."""
        for told in (unknown_flags, not_looked_at):
            for what in told(self._mujoco, self._model):
                self._cannot(what)

"""Reading URDF files, the robot descriptions of ROS, by yourdfpy.

Source: the specification at wiki.ros.org/urdf/XML.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar, get_args

import numpy as np

from kinolab.arguments import require_fit
from kinolab.concurrency.stages import doing
from kinolab.dynamics import System
from kinolab.dynamics.language.shapes import Box, Cylinder, Shape, Sphere
from kinolab.errors import InputError, Mistake, UnknownNameError, listed, printable
from kinolab.files import LOG, is_file
from kinolab.lazy import library_of
from kinolab.numerics.arrays import Array
from kinolab.robots.actuation.actuators import Motor
from kinolab.robots.compared.urdf_engines import urdf_engines
from kinolab.robots.machine.given_motion import PerJoint, given_motion
from kinolab.robots.machine.robot_machine import Base, assembled
from kinolab.robots.solids.convex_parts import check_parts, enclosing_shapes
from kinolab.robots.solids.solid_mass import ball_mass, box_mass, cylinder_mass, mesh_mass
from kinolab.robots.tree.joint_inertia import together
from kinolab.robots.tree.kinematic_tree import (
    Inertial,
    Joint,
    JointKind,
    KinematicTree,
    Link,
    Mimicked,
    PlacedShape,
    VisibleMesh,
    usable_name,
)
from kinolab.robots.tree.tree_mistakes import tree_mistakes
from kinolab.robots.tree.urdf_inertials import balanced, write_inertials
from kinolab.robots.urdf.mesh_files import find_mesh
from kinolab.robots.urdf.urdf_fields import READ, unread_words
from kinolab.robots.urdf.xacro_files import expanded
from kinolab.untrusted import read, refuse_many
from kinolab.world.meshes.mesh import load_mesh
from kinolab.world.shapes.shape_surfaces import Faces

T = TypeVar("T")
# Some files call themselves XML 0.0, or begin with a blank line; other readers mind neither.
XML_VERSION = re.compile(rb"""^(<\?xml\s+version\s*=\s*["'])[^"']*""")
LARGEST_LINK = 20.0  # [m] across: beyond that a mesh is likely to be in millimetres
TEXTS = {"name", "type", "filename", "link", "joint"}  # attributes that are not numbers
MAGNITUDES = {"limit": ("effort", "velocity"), "dynamics": ("friction",)}
COUNTS = {"xyz": 3, "rpy": 3, "size": 3, "scale": 3, "rgba": 4}  # of numbers, where it is not 1
MOVED = ("revolute", "continuous", "prismatic")  # by one number, so that a motor may do it
KINDS: Mapping[str, JointKind] = {
    "fixed": "fixed",
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "planar": "planar",
    "floating": "floating",
}


def read_urdf(
    path: str | Path,
    *,
    base: Base = "fixed",
    locked: Mapping[str, float] | None = None,
    packages: Mapping[str, str | Path] | None = None,
    shapes: bool = True,
    self_collisions: bool = True,
    convex_parts: int | None = None,
    kinematic: bool = False,
    max_velocity: PerJoint | None = None,
    max_acceleration: PerJoint | None = None,
    density: float | None = None,
    balance_inertia: bool = False,
) -> System:
    """Read a robot from a URDF file as a machine.

    Links become bodies in their own frames; what moves together has one mass. A joint from 0 to 0
    has no limits, as in files that leave them out. Joints with an effort limit have a motor of that
    limit; damping is viscous friction, friction is Coulomb's. Collision geometry counts, or what is
    drawn where there is none; meshes are enclosed in boxes and capsules. Sensors, transmissions and
    what simulators add are left out; warnings name whatever else is not read.

    Args:
        path: The file, or a template that xacro, where it is installed, expands.
        base: ``"fixed"`` to the world or ``"floating"`` freely: then the root has the coordinates
            ``x``, ``y`` and ``z`` in [m] and the attitude ``base``.
        locked: Positions of joints that do not move, by name, in [rad] or [m].
        packages: Folders of ``package://`` by name; otherwise they are looked for above the file.
        shapes: Whether to read shapes at all.
        self_collisions: Whether links may not touch each other: those that can, are not neighbours
            and do not touch at rest. An SRDF of the same name beside the file says which may.
        convex_parts: How many parts a mesh may be divided into, each with a box or capsule of its
            own, instead of one around the whole.
        kinematic: Whether the speeds of joints are its inputs, whatever forces that takes. Masses,
            friction and efforts have no part in its motion then, and need not be in the file.
        max_velocity: Of a kinematic robot: limits of joints beside those of the file, of all or by
            name, in [rad/s] or [m/s].
        max_acceleration: Of a kinematic robot: limits of accelerations, in [rad/s^2] or [m/s^2],
            which are the inputs then.
        density: In [kg/m^3] of what links without ``<inertial>`` are made of: their collision
            geometry, or what is drawn where there is none; meshes are filled, and those with open
            edges enclosed in their convex hull.
        balance_inertia: Whether a link of which one moment of inertia exceeds the sum of the others
            has their mean about every axis, as MuJoCo's ``balanceinertia`` has it; a note tells.

    Raises:
        InputError: With every mistake in the file, in particular of links without inertia, missing
            meshes, and lengths in millimetres; with the joint at which the machine moves otherwise
            than the model that MuJoCo or Pinocchio, where installed, makes of the same file.
    """
    require_fit("read_urdf path", str | Path, path)
    require_fit("read_urdf locked", Mapping[str, float] | None, locked)
    require_fit("read_urdf packages", Mapping[str, Any] | None, packages)
    if base not in get_args(Base):
        raise UnknownNameError("base", str(base), known=get_args(Base), where="read_urdf base")
    require_fit("read_urdf density", float | None, density)
    path = Path(path)
    if density is not None and not 0.0 < density < math.inf:
        remedy = "Give kg/m^3, such as 2700 of aluminium."
        raise InputError([Mistake(f"{path.name} density", f"it is {density:g}.", remedy)])
    check_parts(convex_parts, path.name)
    robot, document, notes = _parsed(path, packages or {}, balance=balance_inertia)
    xml = library_of("robots", "lxml.etree", "URDF files are read by yourdfpy and lxml")
    reader = _LinkReader(path, packages or {}, density, shapes=shapes, convex_parts=convex_parts)
    given = given_motion(path.name, max_velocity, max_acceleration, kinematic=kinematic)
    links = tuple(reader.link(entry) for entry in robot.links)
    write_inertials(xml, document, reader.filled)
    joints = tuple(reader.joint(entry) for entry in robot.joints)
    name, motors = str(robot.name or path.stem), tuple(reader.motors)
    tree = KinematicTree(
        *(name, links, joints, motors),
        allowed=_allowed(path, [link.name for link in links]),
        notes=(*notes, *_not_read(robot, pushed=given is None)),
    )
    mistakes = [*reader.mistakes, *tree_mistakes(tree, locked or {}, path.name)]
    if mistakes:
        raise InputError(mistakes)
    return assembled(
        tree,
        base=base,
        locked=locked,
        self_collisions=self_collisions,
        where=path.name,
        file=xml.tostring(document),
        engines=urdf_engines(xml, document, floating=base == "floating"),
        given=given,
    )


def _parsed(
    path: Path, packages: Mapping[str, str | Path], *, balance: bool
) -> tuple[Any, Any, list[str]]:
    """Return yourdfpy's robot, the document of lxml, and what is not read or was changed."""
    library = library_of("robots", "yourdfpy", "URDF files are read by yourdfpy")
    if not is_file(path):
        raise InputError([Mistake(str(path), "there is no such file.")])
    content = read(path, "xml")
    if b"<!ENTITY" in content:
        raise InputError([Mistake(path.name, "it defines XML entities.", "Write them out.")])
    content = XML_VERSION.sub(rb"\g<1>1.0", expanded(path, content, packages).lstrip())
    xml = library_of("robots", "lxml.etree", "URDF files are read by yourdfpy and lxml")
    notes: list[str] = []
    try:
        # yourdfpy guesses where this fails
        document = xml.fromstring(content, xml.XMLParser(resolve_entities=False))
        if document.tag != "robot":
            what = f"it begins with <{printable(str(document.tag))}>, not <robot>."
            raise InputError([Mistake(path.name, what, "MJCF files are named .xml.")])
        mistakes, left_out = unread_words(document, path.name)
        mistakes += [*_wrong_numbers(document, path.name), *_empty(document, path.name)]
        if mistakes:
            raise InputError(mistakes)
        if balance and (done := [*balanced(document)]):
            notes, content = done, xml.tostring(document)
        robot = library.URDF.load(
            io.BytesIO(content),
            build_scene_graph=False,
            load_meshes=False,
            build_collision_scene_graph=False,
            load_collision_meshes=False,
        ).robot
    except InputError:
        raise
    except Exception as error:  # of lxml and yourdfpy, of many kinds
        told = f"there is no {error}" if isinstance(error, KeyError) else str(error).strip()
        what = f"it is not a URDF file ({told or type(error).__name__})."
        if isinstance(error, xml.XMLSyntaxError):
            what = f"it is not an XML file ({error.msg})."
        raise InputError([Mistake(path.name, what)]) from error
    if not robot.links:
        raise InputError([Mistake(path.name, "it has no links.")])
    refuse_many(len(robot.links), "links", path.name)
    if left_out:
        notes.append(f"not read: {listed(left_out)}.")
    return robot, document, notes


def _not_read(robot: Any, *, pushed: bool) -> Iterator[str]:
    """Yield what is in a robot's file and not in its machine, which forces push or not."""
    limited = [joint for joint in robot.joints if pushed and joint.limit and joint.type in MOVED]
    kinds = {
        "the effort of joints that follow others is not read: {}.": (
            joint for joint in limited if joint.mimic and joint.limit.effort
        ),
        "joints with effort 0 have no motor: {}.": (
            joint for joint in limited if not joint.mimic and not joint.limit.effort
        ),
        "<safety_controller> of {} is not read; [bounds] of a scenario may be as narrow.": (
            joint for joint in robot.joints if joint.safety_controller
        ),
    }
    for sentence, joints in kinds.items():
        if names := listed(str(joint.name) for joint in joints):
            yield sentence.format(names)


def _allowed(path: Path, links: Sequence[str]) -> frozenset[frozenset[str]]:
    """Return the pairs of links that an SRDF, of MoveIt, lets touch each other; none without it.

    It stands beside the robot's file and is called like it, up to the first point or the last one.
    ``disable_default_collisions`` names a link that may touch all but those of
    ``enable_collisions``.

    Raises:
        InputError: If it is no XML.
    """
    stems = dict.fromkeys((path.stem, path.name.partition(".")[0]))
    file = next((one for stem in stems if is_file(one := path.with_name(f"{stem}.srdf"))), None)
    if file is None:
        return frozenset()
    xml = library_of("robots", "lxml.etree", "SRDF files are read by lxml")
    content = read(file, "xml")
    try:
        document = xml.fromstring(content, xml.XMLParser(resolve_entities=False))
    except xml.XMLSyntaxError as error:
        raise InputError([Mistake(file.name, f"it is not an XML file ({error.msg}).")]) from error
    touching = {one.get("link", "") for one in document.iter("disable_default_collisions")}
    allowed = {frozenset((one, other)) for one in touching for other in links if one != other}
    allowed -= _pairs(document, "enable_collisions")
    return frozenset(allowed | _pairs(document, "disable_collisions"))


def _pairs(document: Any, tag: str) -> set[frozenset[str]]:
    return {frozenset((e.get("link1", ""), e.get("link2", ""))) for e in document.iter(tag)}


def _wrong_numbers(document: Any, where: str) -> Iterator[Mistake]:
    """Yield what should be finite numbers, or no negative ones, and is not."""
    for part in document.iterchildren("link", "joint"):
        at = f"{where} {part.tag} {part.get('name', '')!r}"
        for element in part.iter(*READ):
            for name in sorted({*element.keys()} & READ[element.tag][0] - TEXTS):
                text = element.get(name)
                place = f"<{element.tag}> {name}"
                numbers, due = text.split(), COUNTS.get(name, 1)
                if not all(map(_is_finite, numbers)):
                    what = f"{place} is {printable(text)!r}, which is not finite."
                    yield Mistake(at, what, "Give numbers without units.")
                elif len(numbers) != due and not (name == "scale" and len(numbers) == 1):
                    wanted = "one number" if due == 1 else f"{due} numbers"
                    yield Mistake(at, f"{place} is {printable(text)!r}.", f"Give {wanted}.")
                elif name in MAGNITUDES.get(element.tag, ()) and float(text) < 0.0:
                    what = f"{place} is {float(text):g}, and no magnitude is negative."
                    yield Mistake(at, what, "Give a positive one, or 0 for none.")


def _is_finite(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


def _empty(document: Any, where: str) -> Iterator[Mistake]:
    """Yield the inertias without mass and the geometries without a shape."""
    for link in document.iterchildren("link"):
        at = f"{where} link {link.get('name', '')!r}"
        for inertial in link.iterchildren("inertial"):
            if inertial.find("mass") is None:
                yield Mistake(at, "its <inertial> has no <mass>.", 'Give <mass value="…"/>.')
        solid = link.findall("collision") or link.findall("visual")
        for geometry in (one for drawn in solid for one in drawn.iterchildren("geometry")):
            if not any(geometry.find(shape) is not None for shape in READ["geometry"][1]):
                tags = [f"<{printable(str(child.tag))}>" for child in geometry.iterchildren("*")]
                what = f"its <geometry> has {', '.join(tags) or 'no shape'}."
                yield Mistake(at, what, _listed(sorted(READ["geometry"][1])))


class _LinkReader:
    """Converts links and joints, and collects what is wrong with them."""

    def __init__(
        self,
        path: Path,
        packages: Mapping[str, str | Path],
        density: float | None,
        *,
        shapes: bool,
        convex_parts: int | None,
    ) -> None:
        self.mistakes: list[Mistake] = []
        self.filled: list[Link] = []
        self._density = density
        self.motors: list[Motor] = []
        self._path, self._packages, self._shapes = path, packages, shapes
        self._convex_parts = convex_parts

    def _wrong(self, kind: str, name: str, what: str, remedy: str = "") -> None:
        self.mistakes.append(Mistake(f"{self._path.name} {kind} {name!r}", what, remedy))

    def link(self, entry: Any) -> Link:
        """Return a link; only its name where its numbers cannot be read."""
        doing(f"reading {printable(f'{self._path.name}: link {entry.name}')}")
        return self._guarded("link", self._link, entry, Link(str(entry.name)))

    def joint(self, entry: Any) -> Joint:
        """Return a joint; a fixed one where its numbers cannot be read."""
        fixed = Joint(str(entry.name), "fixed", str(entry.parent), str(entry.child))
        return self._guarded("joint", self._joint, entry, fixed)

    def _guarded(self, kind: str, read: Callable[[Any], T], entry: Any, otherwise: T) -> T:
        try:
            return read(entry)
        except (TypeError, ValueError) as error:
            self._wrong(kind, entry.name, f"its numbers cannot be read ({error}).")
            return otherwise

    def _link(self, entry: Any) -> Link:
        solids: list[PlacedShape] = []
        if self._shapes:
            for drawn in entry.collisions or entry.visuals or ():
                solids += self._solids(entry.name, drawn)
        visible = tuple(self._visible(entry)) if self._shapes else ()
        color = next(filter(None, map(_color, entry.visuals or ())), None)
        solids = [replace(solid, color=color) for solid in solids]
        inertial = self._inertial(entry)
        link = Link(str(entry.name), inertial, tuple(solids), visible)
        if self._density is None or (inertial is not None and inertial.mass > 0.0):
            return link
        self.filled.append(replace(link, inertial=self._of_geometry(entry, self._density)))
        return self.filled[-1]

    def _of_geometry(self, entry: Any, density: float) -> Inertial | None:
        """Return the mass properties of a link by its geometry, None where that has no volume."""
        found = []
        for drawn in entry.collisions or entry.visuals or ():
            own = self._filled(entry.name, drawn.geometry, density)
            if own is not None:
                found.append((Link("", own), _pose(drawn.origin)))
        return together(found) if found else None

    def _filled(self, name: str, given: Any, density: float) -> Inertial | None:
        if given is None:
            return None
        if given.box is not None:
            return box_mass([*map(float, given.box.size)], density)
        if given.cylinder is not None:
            return cylinder_mass(
                float(given.cylinder.radius), float(given.cylinder.length), density
            )
        if given.sphere is not None:
            return ball_mass(float(given.sphere.radius), density)
        return None if given.mesh is None else self._of_mesh(name, given.mesh, density)

    def _of_mesh(self, name: str, mesh: Any, density: float) -> Inertial | None:
        try:
            _, _, vertices, faces = self._mesh(mesh)
        except InputError as error:
            if not self._shapes:  # otherwise it was said when its shape was read
                self._wrong_mesh(name, error)
            return None
        return mesh_mass(vertices, faces, density)

    def _visible(self, entry: Any) -> Iterator[VisibleMesh]:
        """Yield the meshes that are drawn; where one cannot be read, none is, and nobody minds."""
        found = []
        for drawn in entry.visuals or ():
            if drawn.geometry is None or drawn.geometry.mesh is None:
                continue
            try:
                found.append(self._visible_mesh(drawn))
            except InputError as error:
                told = "%s link %r: its mesh is not drawn: %s"
                LOG.warning(told, printable(self._path.name), printable(str(entry.name)), error)
                return
        yield from found

    def _visible_mesh(self, drawn: Any) -> VisibleMesh:
        pose, color = _pose(drawn.origin), _color(drawn)
        name, read, vertices, faces = self._mesh(drawn.geometry.mesh)
        colors = read.colors / 255.0 if len(read.colors) else None
        if color is not None and colors is None:
            colors = np.tile(color, (len(read.faces), 1))
        return VisibleMesh(name, vertices @ pose[:3, :3].T + pose[:3, 3], faces, colors)

    def _mesh(self, mesh: Any) -> tuple[str, Any, Array, Faces]:
        """Return a mesh's name, what is read, and its vertices and faces, which look outward.

        Raises:
            InputError: If its file is not there, or is no mesh.
        """
        scale = np.ones(3) if mesh.scale is None else np.asarray(mesh.scale, dtype=float)
        file = find_mesh(str(mesh.filename), self._path.parent, self._packages)
        if file is None:
            remedy = "Keep the folder of meshes beside that of the file, as the package has them."
            raise InputError([Mistake(str(mesh.filename), "it cannot be found.", remedy)])
        read = load_mesh(file.name, root=file.parent)
        faces = read.faces if scale.prod() > 0.0 else read.faces[:, ::-1]  # it may be mirrored
        return file.name, read, read.vertices * scale, faces

    def _inertial(self, entry: Any) -> Inertial | None:
        given = entry.inertial
        if given is None or given.mass is None:
            return None
        pose = _pose(given.origin)
        own = np.zeros((3, 3)) if given.inertia is None else np.asarray(given.inertia, dtype=float)
        mass = float(given.mass)
        if mass < 0.0:
            self._wrong("link", entry.name, f"its mass is {mass:g} kg.")
        centre = pose[:3, 3]
        if np.abs(centre).max() > LARGEST_LINK:
            what = f"its centre of mass is {np.abs(centre).max():.3g} m from its origin."
            self._wrong("link", entry.name, what, "URDF has metres: is it in millimetres?")
        turn = pose[:3, :3]
        return Inertial(mass, centre, turn @ own @ turn.T)

    def _solids(self, name: str, drawn: Any) -> Iterator[PlacedShape]:
        pose, given = _pose(drawn.origin), drawn.geometry
        if (shape := _plain_shape(given)) is not None:
            yield PlacedShape(shape, pose)
        elif given is not None and given.mesh is not None:
            yield from self._enclosed(name, given.mesh, pose)

    def _enclosed(self, name: str, mesh: Any, pose: Array) -> Iterator[PlacedShape]:
        try:
            file, _, vertices, faces = self._mesh(mesh)
            across = float(np.ptp(vertices, axis=0).max())
            if across > LARGEST_LINK:
                remedy = 'Is it in millimetres? Then it needs scale="0.001 0.001 0.001".'
                raise InputError([Mistake(file, f"it is {across:.3g} m across.", remedy)])
            for solid in enclosing_shapes(vertices, faces, self._convex_parts, file):
                yield replace(solid, pose=pose @ solid.pose)
        except InputError as error:
            self._wrong_mesh(name, error)

    def _wrong_mesh(self, name: str, error: InputError) -> None:
        for one in error.mistakes:
            self._wrong("link", name, f"its mesh {one.where}: {one.what}", one.remedy)

    def _joint(self, entry: Any) -> Joint:
        kind = KINDS.get(str(entry.type))
        if kind is None:
            self._wrong("joint", entry.name, f"its type is {entry.type!r}.", _listed(KINDS))
            kind = "fixed"
        pose = _pose(entry.origin)
        axis = np.array([1.0, 0.0, 0.0]) if entry.axis is None else np.asarray(entry.axis, float)
        if axis.shape != (3,):
            self._wrong("joint", entry.name, "its axis is not made of three numbers.")
            axis = np.array([1.0, 0.0, 0.0])
        size = float(np.linalg.norm(axis))
        if kind != "fixed" and not (0.0 < size < math.inf):
            self._wrong("joint", entry.name, "its axis has no direction.")
            axis, size = np.array([1.0, 0.0, 0.0]), 1.0
        limit, friction, mimic = entry.limit, entry.dynamics, entry.mimic
        lower, upper = -math.inf, math.inf
        if limit is not None and entry.type in ("revolute", "prismatic"):
            lower, upper = _number(limit.lower), _number(limit.upper)
            if lower == upper == 0.0:  # what exporters write that know of no limits
                lower, upper = -math.inf, math.inf
        elif entry.type in ("revolute", "prismatic") and mimic is None:
            what, remedy = "it has no <limit>.", "An unlimited rotation has the type continuous."
            self._wrong("joint", entry.name, what, remedy)
        speed = _number(limit.velocity) if limit is not None else 0.0
        effort = _number(limit.effort) if limit is not None and mimic is None else 0.0
        if effort > 0.0 and kind in ("revolute", "prismatic"):
            motor = f"{usable_name(str(entry.name))}_{'force' if kind == 'prismatic' else 'torque'}"
            self.motors.append(Motor(motor, str(entry.name), -effort, effort))
        return Joint(
            str(entry.name),
            kind,
            str(entry.parent),
            str(entry.child),
            pose,
            axis / size if size else axis,
            lower,
            upper,
            speed if speed > 0.0 else math.inf,
            _number(friction.damping) if friction is not None else 0.0,
            _number(friction.friction) if friction is not None else 0.0,
            None
            if mimic is None
            else Mimicked(
                str(mimic.joint),
                1.0 if mimic.multiplier is None else float(mimic.multiplier),
                _number(mimic.offset),
            ),
        )


def _pose(origin: Any) -> Array:
    """Return where something is, shape (4, 4): where its owner is, if nothing is said."""
    return np.eye(4) if origin is None else np.asarray(origin, dtype=float)


def _plain_shape(given: Any) -> Shape | None:
    """Return a geometry's box, cylinder or ball, None of a mesh."""
    if given is None:
        return None
    if given.box is not None:
        x, y, z = map(float, given.box.size)
        return Box(x, y, z)
    if given.cylinder is not None:
        return Cylinder(float(given.cylinder.radius), float(given.cylinder.length))
    return None if given.sphere is None else Sphere(float(given.sphere.radius))


def _number(given: float | None) -> float:
    """Return a number of a file, 0 where it is left out."""
    return 0.0 if given is None else float(given)


def _color(drawn: Any) -> tuple[float, float, float] | None:
    material = drawn.material
    if material is None or material.color is None or material.color.rgba is None:
        return None
    red, green, blue = (min(max(float(c), 0.0), 1.0) for c in material.color.rgba[:3])
    return red, green, blue


def _listed(known: Iterable[str]) -> str:
    return f"Known: {', '.join(known)}."

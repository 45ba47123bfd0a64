"""The content of a page as an animated glTF scene, for Blender and other viewers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinolab.dynamics.language.shapes import Cylinder
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import of_matrices
from kinolab.show.gltf.glb import Glb
from kinolab.show.scene.camera import horizontal_axes
from kinolab.show.scene.content import Content, Curve
from kinolab.show.scene.curves import evaluated
from kinolab.show.scene.models.ball import Color
from kinolab.show.scene.models.cone import cone_mesh
from kinolab.show.scene.models.ground import floor_top, marked_areas
from kinolab.show.scene.models.setting import SceneColors
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, by_color, weld
from kinolab.show.scene.picture import Floor, Ghost
from kinolab.show.scene.still import GOAL, INK, PATH, START, extent, goal_ball
from kinolab.world.shapes.geometry import triangles

GHOST_OPACITY = 0.4  # of start, goal and cones


def glb_scene(content: Content) -> bytes:
    """Return a binary glTF file of the page's scene, with the motion as its animation.

    The scene is in metres. glTF's up is y: the root node turns the picture's up there, and below
    it everything is in kinolab's axes. Between keys viewers interpolate linearly.
    """
    glb, picture = Glb(), content.picture
    root = glb.node(f"kinolab: {content.name}", rotation=_upright(picture.up))
    machine = picture.machine()
    _add_machine(glb, root, content, machine)  # first: its bodies keep their names
    still = extent(content).still
    _add_floor(glb, root, still.floor, picture.colors)
    for obstacle, mesh in zip(picture.obstacles, still.obstacles, strict=True):
        add_mesh(glb, root, obstacle.name, mesh)
    for k, cone in enumerate(picture.cones):
        add_mesh(glb, root, f"cone {k + 1}", cone_mesh(cone), GHOST_OPACITY)
    _add_ghost(glb, root, "start", picture.start, machine, START)
    if isinstance(picture.goal, Ghost):
        _add_ghost(glb, root, "goal", picture.goal, machine, GOAL)
    elif picture.goal is not None:
        add_mesh(glb, root, "goal", goal_ball(picture.goal), GHOST_OPACITY)
    for k, point in enumerate(picture.points):
        add_mesh(glb, root, f"goal point {k + 1}", goal_ball(point), GHOST_OPACITY)
    _add_path(glb, root, content)
    if content.keys.ends is not None:
        thinnest = 0.002 * still.size  # least radius of a cable, relative to the scene's size
        _add_cables(glb, root, content.keys.ends, np.fmax(picture.radii, thinnest))
    return glb.to_bytes()


def _upright(up: Array) -> list[float]:
    """The rotation of up to y and of a front view's right to x, as x, y, z, w."""
    across, toward = horizontal_axes(up)
    upward = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    turn: list[float] = of_matrices(np.stack([across, upward, toward])).tolist()
    return turn


def add_mesh(
    glb: Glb, parent: int | None, name: str, mesh: SurfaceMesh, opacity: float = 1.0
) -> int:
    """Add a node with a coloured mesh, one primitive per colour."""
    if not len(mesh.faces):
        return glb.node(name, parent)
    faces, groups = by_color(mesh)
    points = glb.points(mesh.vertices)
    primitives = [
        glb.primitive(points, faces[first : first + count], glb.material(_color(rgb), opacity))
        for rgb, first, count in groups
    ]
    return glb.node(name, parent, mesh=glb.mesh(name, primitives))


def _add_floor(glb: Glb, root: int, floor: Floor | None, colors: SceneColors) -> None:
    if floor is None:
        return
    add_mesh(glb, root, "floor", floor_top(floor.low, floor.high, colors))
    for k, area in enumerate(marked_areas(floor.low, floor.high, colors)):
        # 2e-4 of the ground's longer side: how far marks lie above it
        height = 2e-4 * float(np.max(floor.high - floor.low))
        lifted = area.vertices + np.array([0.0, 0.0, height])
        add_mesh(glb, root, f"mark {k + 1}", replace(area, vertices=lifted))


def _add_ghost(
    glb: Glb,
    root: int,
    name: str,
    ghost: Ghost | None,
    machine: Sequence[SurfaceMesh],
    color: Color,
) -> None:
    if ghost is None:
        return
    parent = glb.node(name, root)
    for k, mesh in enumerate(ghost.placed(machine)):
        add_mesh(glb, parent, f"{name} {k + 1}", mesh.painted(color), GHOST_OPACITY)


def _add_machine(glb: Glb, root: int, content: Content, machine: Sequence[SurfaceMesh]) -> None:
    """Add a node per body, whose transform is its frame; rotors are nodes below it."""
    keys = content.keys
    for k, (body, mesh) in enumerate(zip(content.picture.bodies, machine, strict=True)):
        place, turn = keys.places[k], keys.turns[k]
        first = {"translation": place.values[0].tolist(), "rotation": turn.values[0].tolist()}
        node = glb.node(body.name, root, **first)
        shape = add_mesh(glb, node, f"{body.name} shape", mesh)
        glb.animate(node, "translation", place.times, place.values)
        glb.animate(node, "rotation", turn.times, turn.values)
        if body.whirl and len(place.times) > 1:
            _whirl(glb, shape, body.whirl, place.times)


def _whirl(glb: Glb, node: int, speed: float, times: Array) -> None:
    begin, end = times[0], times[-1]
    # 1.0 [rad] between two keys of a rotor
    t = np.linspace(begin, end, int(np.ceil(abs(speed) * (end - begin) / 1.0)) + 2)
    half = 0.5 * speed * (t - begin)
    zero = np.zeros_like(t)
    glb.animate(node, "rotation", t, np.stack([zero, zero, np.sin(half), np.cos(half)], axis=1))


def _add_path(glb: Glb, root: int, content: Content) -> None:
    place = content.keys.places[0]
    if content.picture.path is None or len(place.times) < 2:
        return
    line = evaluated(place, np.linspace(place.times[0], place.times[-1], 1000))
    ends = np.stack([np.arange(len(line) - 1), np.arange(1, len(line))], axis=1)
    paint = glb.material(_color([c / 255.0 for c in PATH]))
    glb.node("path", root, mesh=glb.mesh("path", [glb.primitive(glb.points(line), ends, paint)]))


def _add_cables(glb: Glb, root: int, curve: Curve, radii: Array) -> None:
    """Add each cable as a unit rod along z with animated translation, rotation and scale."""
    ends = curve.values.reshape(len(curve.times), -1, 2, 3)
    for k in range(ends.shape[1]):
        rod = Cylinder(float(radii[k]), 1.0, at=(0.0, 0.0, 0.5))
        mesh = weld(*triangles(rod), _color([c / 255.0 for c in INK]))
        tracks = _stretched(ends[:, k])
        node = add_mesh(glb, root, f"cable {k + 1}", mesh)
        for what, values in zip(("translation", "rotation", "scale"), tracks, strict=True):
            glb.animate(node, what, curve.times, values)


def _stretched(ends: Array) -> tuple[Array, Array, Array]:
    """Translation, rotation and scale of a rod along z between ends (nk, 2, 3); 0 if slack."""
    slack = np.asarray(~np.isfinite(ends).all(axis=(1, 2)))
    known = np.where(slack[:, None, None], 0.0, ends)
    path = known[:, 1] - known[:, 0]
    length = np.linalg.norm(path, axis=1)
    path[length == 0.0] = (0.0, 0.0, 1.0)
    unit = path / np.linalg.norm(path, axis=1, keepdims=True)
    # The shortest rotation from z: (z x unit, 1 + z . unit), and about x if unit is -z.
    q = np.stack([-unit[:, 1], unit[:, 0], 0.0 * length, 1.0 + unit[:, 2]], axis=1)
    q[np.linalg.norm(q, axis=1) < 1e-6] = (1.0, 0.0, 0.0, 0.0)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    thick = np.where(slack, 0.0, 1.0)
    return known[:, 0], q, np.stack([thick, thick, length], axis=1)


def _color(rgb: Sequence[float]) -> Color:
    red, green, blue = rgb
    return red, green, blue

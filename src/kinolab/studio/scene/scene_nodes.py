"""The scene that film and page have, as nodes of viser: few drawing calls, sent only when changed.

A node is a drawing call for each of its colours. Obstacles are nodes of their own, to be clicked
and dragged, as long as they are few; of many the world is one node.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import trimesh
import viser

from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import of_matrices
from kinolab.problem import PlanningTask
from kinolab.show.gltf.glb import Glb
from kinolab.show.gltf.glb_scene import add_mesh
from kinolab.show.scene.camera import Camera, View, frame_scene
from kinolab.show.scene.captions import GOAL_WORD, START_WORD
from kinolab.show.scene.models.cone import cone_mesh
from kinolab.show.scene.models.ground import floor_top, grid_step, marked_lines
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, join
from kinolab.show.scene.picture import Ghost, GoalMarker, Picture
from kinolab.show.scene.problem_picture import picture
from kinolab.show.scene.still import GOAL, PATH, Still, goal_ball, set_up
from kinolab.studio.core.tolerance_box import tolerance_box
from kinolab.trajectory import Trajectory
from kinolab.world.obstacles.obstacle import rotation

NEAR, COARSE = 0.25, 0.1  # of the scene's size: from where on; and of its triangles: how many
SKY, SUN = 2.4, 1.7  # intensities of light from above, and from the front
RING = 0.02  # height of a goal region on the ground, relative to its radius
ALARM = (220, 30, 30)  # what touches
REGION = 0.3  # opacity of regions and cones


class SceneNodes:
    """What a browser shows of a problem.

    Args:
        clicked: Called with the number of an obstacle that was clicked.

    Attributes:
        problem: What is shown.
        nodes: Of viser, by their names.
        labels: Whether words are shown.
        place: Of the leading body, shape (3,), in [m].
    """

    def __init__(self, server: viser.ViserServer, clicked: Callable[[int], None]) -> None:
        self._scene, self._clicked = server.scene, clicked
        self._keys: dict[str, str] = {}  # what each node shows, to send it only if it changes
        self.nodes: dict[str, Any] = {}
        self._moved: dict[str, Any] = {}  # nodes of bodies
        self.problem: PlanningTask | None = None
        self._still: Still | None = None
        self._hull = np.zeros((1, 3))
        self.labels = True
        self.place = np.zeros(3)  # of the leading body, in [m]
        self._scene.world_axes.visible = False
        self._scene.configure_environment_map(None)
        self._scene.configure_default_lights(enabled=False)
        self._scene.add_light_hemisphere(
            "/light/sky", sky_color=(255, 255, 255), ground_color=(150, 145, 140), intensity=SKY
        )
        self._scene.add_light_directional(
            "/light/sun", intensity=SUN, cast_shadow=False, position=(-0.5, -1.0, 1.6)
        )

    @property
    def size(self) -> float:
        """Of all that is seen, in [m]."""
        return 1.0 if self._still is None else self._still.size

    @property
    def spacing(self) -> float | None:
        """Of the lines on the floor, in [m]; None where there are none."""
        still = self._still
        if still is None or still.floor is None or still.picture.colors.pattern != "grid":
            return None
        return grid_step(float(np.max(still.floor.high - still.floor.low)))

    def show(self, problem: PlanningTask, *, touching: Sequence[tuple[str, str]] = ()) -> None:
        """Show a problem with its machine at the start, and what touches there in red."""
        self.problem = problem
        render = problem.scenario.render.model_copy(update={"cut": None})
        scene = picture(problem, problem.start[None], render)
        scene = replace(scene, view="perspective", path=None)
        motion = problem.frames(problem.start)[None]
        self._still, self._hull = set_up(scene, motion)
        self._up(scene)
        wanted = {"floor": self._floor, "world": self._world, "machine": self._machine}
        before = set(self.nodes)
        kept = {name for show in wanted.values() for name in show(problem, scene)}
        kept |= set(self._marks(problem, scene)) | set(self._alarm(problem, scene, touching))
        for name in before - kept:
            if not name.startswith("/plan"):
                self.remove(name)

    def remove(self, name: str) -> None:
        """Remove a node, if it is there."""
        self._keys.pop(name, None)
        self._moved.pop(name, None)
        if node := self.nodes.pop(name, None):
            node.remove()

    def pose(self, x: Array) -> None:
        """Move the machine to a state (nx,)."""
        problem = self.problem
        if problem is None:
            return
        frames = problem.frames(x)
        self.place = frames[problem.leading, 3::4]
        for body, pose in zip(problem.bodies, frames, strict=True):
            if node := self._moved.get(f"/machine/{body.name}"):
                node.wxyz, node.position = _turn(pose), pose[3::4]
        if problem.cables:
            self._cables(problem.placement(x)[1])

    def move_obstacle(self, number: int, place: Array, wxyz: Array) -> None:
        """Move the picture of an obstacle, before the text says so."""
        if node := self.nodes.get(f"/world/{number}"):
            node.position, node.wxyz = place, wxyz

    def plan(self, problem: PlanningTask, motion: Trajectory | None) -> None:
        """Draw the path of the leading body along a motion."""
        if motion is None:
            self.remove("/plan/path")
            return
        places = problem.model.frames(motion.x)[:, problem.leading, 3::4]
        pairs = np.stack([places[:-1], places[1:]], axis=1)
        self.lines("/plan/path", pairs, PATH, 3.0)

    def tree(self, segments: Array | None) -> None:
        """Draw a search graph, shape (edges, 2, 3); the newest branches of a large one."""
        if segments is None or not len(segments):
            self.remove("/plan/tree")
        else:
            # 20_000 edges of a search graph that are drawn, the newest ones
            self.lines("/plan/tree", segments[-20_000:], (150, 160, 175), 1.0)

    def camera(self, view: View, size: tuple[int, int] = (800, 600)) -> Camera:
        """Return the nearest camera that sees all of it, in a picture of a size in [pixel]."""
        assert self._still is not None
        up = np.asarray(self._still.picture.up, dtype=float)
        return frame_scene(self._hull, up, view, size, angles=self._still.outlook.angles)

    def _up(self, scene: Picture) -> None:
        up = tuple(np.asarray(scene.up, dtype=float).tolist())
        if self._changed("up", up):
            self._scene.set_up_direction(up)

    def _floor(self, _: PlanningTask, scene: Picture) -> list[str]:
        still = self._still
        if still is None or still.floor is None:
            return []
        low, high, colors = still.floor.low, still.floor.high, scene.colors
        self._mesh("/floor/top", floor_top(low, high, colors), key=(low, high, scene.setting))
        lines = marked_lines(low, high, colors)
        if not len(lines):
            return ["/floor/top"]
        self.lines("/floor/lines", lines + _above(lines), _bytes(colors.lines), 1.0)
        return ["/floor/top", "/floor/lines"]

    def _world(self, problem: PlanningTask, scene: Picture) -> list[str]:
        assert self._still is not None
        meshes = dict(zip((o.name for o in scene.obstacles), self._still.obstacles, strict=True))
        entries = problem.scenario.world.obstacle
        # 100 obstacles with a node each; with machine, goal and gizmo below 300 calls
        if len(entries) > 100:
            key = (problem.scenario.world.model_dump(), scene.setting)
            self._mesh("/world/all", join(list(meshes.values())), key=key)
            return ["/world/all"]
        names = []
        for number, entry in enumerate(entries):
            if entry.name not in meshes:
                continue  # it was the floor
            name, place, turn = f"/world/{number}", np.array(entry.position), rotation(entry.rpy)
            mesh = meshes[entry.name]
            pose = np.column_stack([turn.T, -turn.T @ place])
            still = entry.model_dump(exclude={"position", "rpy"})
            shown = (still, scene.setting, number, mesh.colors[0].tolist(), len(mesh.faces))
            if self._mesh(name, mesh.moved(pose), key=shown):
                self.nodes[name].on_click(lambda _, number=number: self._clicked(number))
            node = self.nodes[name]
            node.position, node.wxyz = place, wxyz_of(turn)
            names.append(name)
        return names

    def _machine(self, problem: PlanningTask, scene: Picture) -> list[str]:
        assert self._still is not None
        poses, names = problem.frames(problem.start), list[str]()
        self.place = poses[problem.leading, 3::4]
        for body, mesh, pose in zip(problem.bodies, self._still.machine, poses, strict=True):
            if not len(mesh.faces):
                continue
            name = f"/machine/{body.name}"
            self._mesh(name, mesh, key=(problem.machine.name, body.name, mesh.vertices))
            self._moved[name] = self.nodes[name]
            self.nodes[name].position, self.nodes[name].wxyz = pose[3::4], _turn(pose)
            names.append(name)
        if problem.cables:
            names += self._cables(problem.placement(problem.start)[1])
        names += self._word(START_WORD, self._top(poses, scene))
        return names

    def _marks(self, problem: PlanningTask, scene: Picture) -> list[str]:
        """Draw where the machine shall go, and where it must not look."""
        assert self._still is not None
        names, green = list[str](), _bytes(GOAL)
        goal, words = scene.goal, list[tuple[str, Array]]()
        if isinstance(goal, Ghost):
            shown = [m for m in goal.placed(self._still.machine) if len(m.faces)]
            # 0.35: opacity of the machine at the goal
            names += self._solid("/goal/machine", join(shown), green, 0.35)
            words.append((GOAL_WORD, self._top(goal.table, scene)))
        region = None if isinstance(goal, GoalMarker) else tolerance_box(problem)
        if region is not None:
            # 1e-3 of the scene's size: how thick at least a region is that is drawn
            low, high = region + 5e-4 * self.size * np.array([[-1.0], [1.0]])
            self.boxes("/goal/box", low[None], high[None], green)
            names.append("/goal/box")
            if goal is None:
                words.append((GOAL_WORD, 0.5 * (low + high)))
        points = [*([goal] if isinstance(goal, GoalMarker) else []), *scene.points]
        for k, marker in enumerate(points):
            flat = scene.stands_on_ground and marker is goal
            mesh = _ring(marker) if flat else goal_ball(marker)
            names += self._solid(f"/goal/region {k}", mesh, green, REGION)
            words.append((GOAL_WORD, np.array(marker.position)))
        for k, cone in enumerate(scene.cones):
            mesh, color = cone_mesh(cone), ALARM if cone.forbidden else green
            names += self._solid(f"/goal/cone {k}", mesh, color, REGION)
        for k, (word, place) in enumerate(words):
            names += self._word(word, place, k)
        return names

    def _alarm(
        self, problem: PlanningTask, scene: Picture, touching: Sequence[tuple[str, str]]
    ) -> list[str]:
        """Draw in red what touches at the start."""
        assert self._still is not None
        names = {name for pair in touching for name in pair}
        poses = problem.frames(problem.start)
        red = [
            mesh.moved(pose)
            for body, mesh, pose in zip(problem.bodies, self._still.machine, poses, strict=True)
            if body.name in names and len(mesh.faces)
        ]
        things = zip(scene.obstacles, self._still.obstacles, strict=True)
        red += [mesh for each, mesh in things if each.name in names]
        return self._solid("/alarm", join(red), ALARM, 0.55, grown=1.002) if red else []

    def _cables(self, ends: Array) -> list[str]:
        lines = ends.reshape(-1, 2, 3)
        self.lines("/machine/cables", lines[np.isfinite(lines).all(axis=(1, 2))], (60, 60, 60), 2)
        return ["/machine/cables"]

    def _word(self, word: str, place: Array, number: int = 0) -> list[str]:
        name = f"/words/{word} {number}"
        if self._changed(name, (place, self.labels)):
            self.nodes[name] = self._scene.add_label(
                name, word, position=place, visible=self.labels, anchor="bottom-center"
            )
        return [name]

    def _top(self, poses: Array, scene: Picture) -> Array:
        """Return the place of a word above the machine, shape (3,)."""
        assert self._still is not None
        pairs = zip(self._still.machine, poses, strict=True)
        corners = [mesh.moved(pose).vertices for mesh, pose in pairs if len(mesh.faces)]
        points = np.concatenate(corners) if corners else poses[:, 3::4]
        points = points[np.isfinite(points).all(axis=1)]
        up = np.asarray(scene.up, dtype=float)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return np.asarray(middle + up * ((points - middle) @ up).max())

    def _mesh(self, name: str, mesh: SurfaceMesh, key: Any) -> bool:
        """Show a mesh in its colours; say whether it had to be sent."""
        if not self._changed(name, key):
            return False
        # 20_000 triangles of a mesh that is drawn coarser from afar
        if len(mesh.faces) < 20_000 or (mesh.colors != mesh.colors[:1]).any():
            glb = Glb()
            add_mesh(glb, None, "mesh", mesh)
            self.nodes[name] = self._scene.add_glb(
                name, glb.to_bytes(), cast_shadow=False, receive_shadow=False
            )
            return True
        once: tuple[Any, Any] = (np.eye(1, 4), np.zeros((1, 3)))  # one of what may be many
        self.nodes[name] = self._scene.add_batched_meshes_simple(
            name, mesh.vertices, mesh.faces, *once, batched_colors=_rgb(_bytes(mesh.colors[0])),
            flat_shading=True, side="front" if mesh.is_closed else "double",
            lod=((NEAR * self.size, COARSE),), cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        return True

    def _solid(
        self, name: str, mesh: SurfaceMesh, color: Any, opacity: float, grown: float = 1.0
    ) -> list[str]:
        """Show a mesh translucent, in one colour."""
        middle = mesh.vertices.mean(axis=0) if len(mesh.vertices) else np.zeros(3)
        vertices = middle + grown * (mesh.vertices - middle)
        if self._changed(name, (vertices, mesh.faces, color)):
            self.nodes[name] = self._scene.add_mesh_simple(
                name, vertices, mesh.faces, color=_rgb(color), opacity=opacity,
                flat_shading=True, side="double", cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
        return [name]

    def lines(self, name: str, points: Array, color: Any, thickness: float) -> None:
        """Draw segments (n, 2, 3) in one colour; the thickness is in [pixel]."""
        if self._changed(name, points):
            self.nodes[name] = self._scene.add_line_segments(
                name, points.astype(np.float32), _rgb(color),
                thickness=thickness, thickness_units="screen",
            )  # fmt: skip

    def boxes(self, name: str, low: Array, high: Array, color: Any) -> None:
        """Draw translucent boxes between corners, shape (n, 3), as one node."""
        if not len(low):
            self.remove(name)
            return
        if not self._changed(name, (low, high, color)):
            return
        box = trimesh.creation.box()
        turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(low), 1))
        self.nodes[name] = self._scene.add_batched_meshes_simple(
            name, box.vertices, box.faces, turns, 0.5 * (low + high), batched_scales=high - low,
            batched_colors=_rgb(color), opacity=REGION, flat_shading=True, side="double",
            cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    def _changed(self, name: str, key: Any) -> bool:
        """Note what a node shows; say whether it showed something else."""
        digest = hashlib.sha256(pickle.dumps(key)).hexdigest()
        changed = self._keys.get(name) != digest
        self._keys[name] = digest
        return changed


def _ring(marker: GoalMarker) -> SurfaceMesh:
    """Return a flat disk for a goal region on the ground."""
    # 48 corners of it
    made = trimesh.creation.cylinder(marker.radius, RING * marker.radius, sections=48)
    x, y, _ = marker.position
    ball = goal_ball(marker)
    points = made.vertices + np.array([x, y, RING * marker.radius])
    return replace(ball, vertices=points, faces=np.asarray(made.faces))


def _turn(pose: Array) -> Array:
    return wxyz_of(pose.reshape(3, 4)[:, :3])


def wxyz_of(matrix: Array) -> Array:
    """Return a rotation (3, 3) as viser has it: w, x, y, z."""
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < 0.5:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return np.roll(of_matrices(matrix[None])[0], 1)


def _rgb(color: Any) -> tuple[int, int, int]:
    red, green, blue = (int(part) for part in color)
    return red, green, blue


def _bytes(color: Any) -> Array:
    return np.rint(255.0 * np.asarray(color, dtype=float))


def _above(lines: Array) -> Array:
    """Return by how much lines on the floor are drawn above it, shape (3,)."""
    return np.array([0.0, 0.0, 2e-4 * max(float(np.ptp(lines.reshape(-1, 3), axis=0).max()), 1.0)])

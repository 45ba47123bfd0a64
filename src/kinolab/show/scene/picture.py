"""Description of a picture's content, obstacles in colours; independent of rendering."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.scene.camera import View
from kinolab.show.scene.models.ball import Color
from kinolab.show.scene.models.cone import Cone
from kinolab.show.scene.models.cut import along, cut_open, level
from kinolab.show.scene.models.painted_body import PaintedBody
from kinolab.show.scene.models.setting import SETTINGS, SceneColors, SettingName
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, is_room, joined, weld

if TYPE_CHECKING:
    from kinolab.dynamics.facts.machine_facts import BodyGeometry


@dataclass(frozen=True, eq=False)
class Ghost:
    """The machine as a translucent outline.

    Args:
        poses: Of the bodies, shape (nb, 12); [0 | p], which shrinks one to a point, hides it.
        lines: Its cables, shape (nl, 2, 3).
    """

    poses: Array
    lines: Array = field(default_factory=lambda: np.zeros((0, 2, 3)))

    def placed(self, machine: Sequence[SurfaceMesh]) -> list[SurfaceMesh]:
        """The machine's meshes where its bodies are."""
        return [mesh.moved(pose) for mesh, pose in zip(machine, self.table, strict=True)]

    @property
    def table(self) -> Array:
        """The poses as rows of 12 numbers."""
        return np.asarray(self.poses, dtype=np.float64).reshape(-1, 12)


@dataclass(frozen=True, eq=False)
class GoalMarker:
    """A goal region: a ring on the ground; a ball without ground, and around points of bodies."""

    position: tuple[float, float, float]  # [m]
    radius: float  # [m]


@dataclass(frozen=True, eq=False)
class Floor:
    """The rectangle of the ground that is drawn, by two opposite corners of shape (2,), in [m]."""

    low: Array
    high: Array


@dataclass(frozen=True, eq=False)
class Surface:
    """An obstacle as it is drawn: points of shape (n, 3) in [m], three of them per face (m, 3).

    Its colours, RGB in 0..1, are those that a scenario gives it, or else those of each face in its
    file (``paint``, shape (m, 3)); without any it takes one of the setting's.
    """

    name: str
    vertices: Array
    faces: NDArray[np.signedinteger[Any]]
    colors: tuple[Color, ...] = ()
    paint: Array | None = None


@dataclass(frozen=True, eq=False)
class Frames:
    """Frames that are drawn as three axes with a name.

    Args:
        names: One per frame.
        poses: In every row of the motion, shape (nt, nf, 12).
    """

    names: tuple[str, ...]
    poses: Array


@dataclass(frozen=True, eq=False, kw_only=True)
class Picture:
    """The content of a picture.

    Args:
        bodies: Moving bodies; poses are given in the same order.
        ground: Whether the plane z = 0 is drawn; only with ``up`` = z.
        bounds: Limits of the workspace in [m] by axis name; the picture contains them.
        up: Direction that points upward in the picture, shape (3,).
        azimuth: Of the camera in [rad], from the front view counterclockwise; None: where one sees
            most of the way from.
        elevation: Of the camera above the horizon in [rad]; None: by the shape of the world.
        follow: Whether the picture goes with the machine.
        cut: Height in [m] above which obstacles are left out; "way": rooms are cut along the path;
            None: nothing is.
        setting: Where it seems to be.
        path: Path of the first body's origin, shape (n, 3), in [m].
        others: Paths of further machines, each likewise.
        start: Poses at which the machine's ghost is drawn.
        goal: A region, or poses for a second ghost.
        points: Where points of bodies must come, each drawn as a ball.
        cones: Goal cones and keep-out cones of axes.
        lines: Cables: segments of shape (nt, nl, 2, 3) that go with the rows of the motion.
            Segments that are not finite are slack.
        radii: Of the cables in [m], shape (nl,); thin lines where it has no entries.
        frames: Whose axes are drawn, if any.
        rolls: Whether the path is a track on the ground, and not a way through the air.
    """

    bodies: Sequence[BodyGeometry | PaintedBody]
    obstacles: Sequence[Surface] = ()
    ground: bool = False
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    up: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    view: View = "perspective"
    azimuth: float | None = None
    elevation: float | None = None
    follow: bool = False
    cut: float | Literal["way"] | None = None
    setting: SettingName = "studio"
    path: Array | None = None
    others: Sequence[Array] = ()
    start: Ghost | None = None
    goal: GoalMarker | Ghost | None = None
    points: Sequence[GoalMarker] = ()
    cones: Sequence[Cone] = ()
    lines: Array | None = None
    radii: Array = field(default_factory=lambda: np.zeros(0))
    frames: Frames | None = None
    rolls: bool = True

    @property
    def stands_on_ground(self) -> bool:
        """Whether a floor is drawn: requested, and with z pointing upward."""
        up = np.asarray(self.up, dtype=np.float64)
        return self.ground and bool(up[2] > 0.999 * np.linalg.norm(up))

    def machine(self, pixel: float = 0.0) -> tuple[SurfaceMesh, ...]:
        """One mesh per body, as fine as pixels of a size in [m] need it."""
        return tuple(body.mesh(pixel) for body in self._painted())

    def plain(self) -> Picture:
        """The same picture for a process that knows no shapes."""
        return replace(self, bodies=self._painted())

    @property
    def colors(self) -> SceneColors:
        """The colours of the setting."""
        return SETTINGS[self.setting]

    def obstacle_meshes(self) -> list[SurfaceMesh]:
        """The obstacles as coloured meshes, in their order; cut open where the picture says so."""
        meshes = [self._colored(k, each) for k, each in enumerate(self.obstacles)]
        if self.cut == "way":
            if self.path is None:
                return meshes
            heights = along(np.asarray(self.path, dtype=np.float64))
            return [cut_open(mesh, heights) if is_room(mesh) else mesh for mesh in meshes]
        return meshes if self.cut is None else [cut_open(m, level(self.cut)) for m in meshes]

    def _colored(self, number: int, surface: Surface) -> SurfaceMesh:
        if surface.paint is not None and not surface.colors:
            return weld(surface.vertices, surface.faces, surface.paint)
        turns = self.colors.obstacles
        colors = surface.colors or (turns[number % len(turns)],)
        return painted(surface.vertices, surface.faces, colors)

    def _painted(self) -> Sequence[PaintedBody]:
        done = [body for body in self.bodies if isinstance(body, PaintedBody)]
        if len(done) == len(self.bodies):
            return done
        from kinolab.show.scene.models.paint import painted_bodies

        return painted_bodies([body for body in self.bodies if not isinstance(body, PaintedBody)])


def painted(vertices: Array, faces: ArrayLike, colors: Sequence[Color]) -> SurfaceMesh:
    """An obstacle with its colours: one for all, or several.

    Of several colours the pieces of an obstacle take one each, in turn; an obstacle in one piece
    shows them as layers, one above the other.

    Args:
        vertices: Of the obstacle, shape (n, 3), in [m].
        faces: Three vertices each, shape (m, 3).
        colors: RGB in 0..1, at least one.
    """
    mesh = weld(vertices, faces, colors[0])
    if len(colors) == 1 or not len(mesh.faces):
        return mesh
    pieces = joined(len(mesh.faces), mesh.sides)
    if pieces.max() == 0:
        return mesh.painted(_layers(mesh, np.array(colors)))
    return mesh.painted(np.array(colors)[pieces % len(colors)])


def _layers(mesh: SurfaceMesh, colors: Array) -> Array:
    """Colours of the faces by height, with wavy borders; of what is level the first one."""
    corners = mesh.vertices[mesh.faces]
    middle = 0.5 * (corners.min(axis=1) + corners.max(axis=1))  # the two halves of a quad agree
    low, high = mesh.vertices[:, 2].min(), mesh.vertices[:, 2].max()
    # The colours of a single piece come twice, from its foot to its top
    thickness = max(float(high - low), 1e-9) / (2 * len(colors))
    wave = np.sin(0.9 * middle[:, 0] / thickness) + np.sin(0.7 * middle[:, 1] / thickness + 1.0)
    # 0.35 of a layer's thickness: how far its border goes up and down
    height = (middle[:, 2] - low) / thickness + 0.5 * 0.35 * wave
    layer = np.clip(np.floor(height), 0, None).astype(int) % len(colors)
    # 0.72: z of the normal of what is a floor and not a wall: it has the first colour
    layer[mesh.normals[:, 2] > 0.72] = 0
    return np.asarray(colors[layer])

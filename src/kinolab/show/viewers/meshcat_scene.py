"""A plan as a scene of MeshCat, with its motion as an animation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kinolab.arguments import checked
from kinolab.lazy import library_of
from kinolab.numerics.manifolds.rotations import to_matrices
from kinolab.problem import PlanningTask
from kinolab.show.scene.camera import frame_scene, horizontal_axes
from kinolab.show.scene.content import Content
from kinolab.show.scene.scenes import Shown, content_of_plan
from kinolab.show.scene.still import extent
from kinolab.show.viewers.viewed_parts import (
    FRAMES_PER_SECOND,
    ViewedPart,
    moving_parts,
    still_parts,
    times_of,
)

ROOT = "kinolab"


@checked
def show_in_meshcat(problem: PlanningTask, plan: Shown, visualizer: Any = None) -> Any:
    """Show a plan in MeshCat, as an animation that its controls play.

    Cables are not drawn: MeshCat cannot move the ends of a line. Everything lies in the branch
    ``kinolab``, which is moved so that the scene is in the middle.

    Args:
        plan: The result of planning, a trajectory, or a run that was read.
        visualizer: A ``meshcat.Visualizer``; left out, one is started. Its branch ``kinolab`` is
            replaced.

    Returns:
        The visualizer: ``.open()`` opens it in a browser, ``.static_html()`` is a page to keep.

    Raises:
        InputError: If an argument does not fit, or MeshCat is not installed.
    """
    meshcat = library_of("meshcat", "meshcat", "scenes of MeshCat need it")
    content = content_of_plan(problem, plan)
    view = meshcat.Visualizer() if visualizer is None else visualizer
    view[ROOT].delete()
    for part in still_parts(content):
        _draw(meshcat, view[ROOT]["obstacles"][part.name], part)
    animation = meshcat.animation.Animation(default_framerate=FRAMES_PER_SECOND)
    for part in moving_parts(content):
        body = view[ROOT]["machine"][part.name]
        _draw(meshcat, body, part)
        for k in range(len(times_of(content))):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = to_matrices(part.turns[k]), part.places[k]
            if k == 0:
                body.set_transform(pose)
            animation.at_frame(body, k).set_transform(pose)
    view.set_animation(animation)
    _look(view, content)
    return view


def _look(view: Any, content: Content) -> None:
    """Place the scene in the middle, its up along MeshCat's z, and look at all of it.

    MeshCat's camera turns about the origin, and its field of view is what it is.
    """
    up, seen = np.asarray(content.picture.up, dtype=float), extent(content)
    across, toward = horizontal_axes(up)
    camera = frame_scene(seen.hull, up, angles=seen.still.outlook.angles)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([across, -toward, up / np.linalg.norm(up)])
    pose[:3, 3] = -pose[:3, :3] @ camera.target
    view[ROOT].set_transform(pose)
    nearer = math.tan(camera.fov / 2.0) / math.tan(math.radians(75.0) / 2.0)  # of MeshCat's camera
    away = nearer * (camera.position - camera.target)
    x, y, z = (pose[:3, :3] @ away).tolist()
    eye = view["/Cameras/default/rotated/<object>"]
    eye.set_property("position", [x, z, -y])  # y is up there
    # 20.0 of the camera's distance: what is farther away is not drawn
    eye.set_property("far", 20.0 * float(np.linalg.norm(away)))
    view["/Grid"].set_property("visible", False)  # it would cut through the scene


def _draw(meshcat: Any, node: Any, part: ViewedPart) -> None:
    shape = meshcat.geometry.TriangularMeshGeometry(part.vertices, part.triangles, part.colors)
    node.set_object(shape, meshcat.geometry.MeshLambertMaterial(vertexColors=True))

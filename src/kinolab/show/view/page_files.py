"""3D views of a plan: ``scene.html``, ``result.glb``, and a notebook frame."""

from __future__ import annotations

import html
from pathlib import Path

from kinolab.arguments import checked
from kinolab.files import utf_8, write_whole
from kinolab.problem import PlanningTask
from kinolab.runs.folder import MODEL, PAGE
from kinolab.show.gltf.glb_scene import glb_scene
from kinolab.show.page import page_html
from kinolab.show.scene.content import Content
from kinolab.show.scene.scenes import Shown, content_of_plan
from kinolab.solve import PlanResult


def views(content: Content) -> dict[str, bytes]:
    """Return ``scene.html`` and ``result.glb`` of a run, by their names."""
    return {PAGE: utf_8(page_html(content)), MODEL: glb_scene(content)}


def write_model(folder: Path, content: Content) -> None:
    """Write ``result.glb`` to a run's folder, atomically."""
    write_whole(folder / MODEL, glb_scene(content))


@checked
def save_page(problem: PlanningTask, plan: Shown, path: str | Path = PAGE) -> Path:
    """Write the interactive page of a plan; with None that of the problem before planning.

    Args:
        plan: The result of planning, a trajectory, or a run that was read.
        path: Of the file, which is written atomically; ``scene.html`` when left out.

    Returns:
        The path.

    Raises:
        InputError: If an argument is something else, or the trajectory is another machine's.
    """
    write_whole(Path(path), utf_8(page_html(content_of_plan(problem, plan))))
    return Path(path)


@checked
def save_glb(problem: PlanningTask, plan: Shown, path: str | Path = MODEL) -> Path:
    """Write the scene of a plan with its motion as binary glTF, which Blender opens.

    Args:
        plan: The result of planning, a trajectory, or a run that was read.
        path: Of the file, which is written atomically; ``result.glb`` when left out.

    Returns:
        The path.

    Raises:
        InputError: If an argument is something else, or the trajectory is another machine's.
    """
    write_whole(Path(path), glb_scene(content_of_plan(problem, plan)))
    return Path(path)


def notebook_frame(problem: PlanningTask, plan: PlanResult | None) -> str:
    """Return the interactive page as HTML for a notebook.

    It runs in a sandboxed frame without access to the notebook or a network.

    Args:
        plan: The result of planning; None shows the problem alone.
    """
    page = html.escape(page_html(content_of_plan(problem, plan)))
    style = "width: 100%; height: 600px; border: 0"  # pixels, in a notebook
    return f'<iframe sandbox="allow-scripts" style="{style}" srcdoc="{page}"></iframe>'

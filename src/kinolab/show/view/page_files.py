"""3D views of a plan: ``scene.html``, ``result.glb``, and a notebook frame."""

from __future__ import annotations

import html
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from kinolab.files import utf_8, write_whole
from kinolab.problem import PlanningTask
from kinolab.runs import MODEL, PAGE
from kinolab.search.graph import SearchGraph
from kinolab.show.gltf.glb_scene import glb_scene
from kinolab.show.page import Content, page_html
from kinolab.show.view.scenes import content_of, facts_of, readiness
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory

FRAME_HEIGHT = 600  # pixels, in a notebook


def write_scene(
    folder: Path,
    problem: PlanningTask,
    trajectory: Trajectory,
    facts: Mapping[str, Any],
    graph: SearchGraph | None = None,
) -> None:
    """Write ``scene.html`` and ``result.glb`` of a motion, each atomically.

    Args:
        folder: The run's folder.
        problem: The machine in its world.
        trajectory: The motion.
        facts: The run's report.
        graph: The search graph.
    """
    content = content_of(problem, trajectory, facts, graph)
    write_page(folder, content)
    write_model(folder, content)


def write_page(folder: Path, content: Content) -> None:
    """Write ``scene.html`` to a run's folder, atomically."""
    write_whole(folder / PAGE, utf_8(page_html(content)))


def write_model(folder: Path, content: Content) -> None:
    """Write ``result.glb`` to a run's folder, atomically."""
    write_whole(folder / MODEL, glb_scene(content))


def save_page(problem: PlanningTask, plan: PlanResult | None, path: str | Path) -> Path:
    """Write the interactive page of a plan; with None that of the problem before planning.

    Args:
        problem: The planning problem.
        plan: The result of planning.
        path: Of the file, which is written atomically.

    Returns:
        The path.
    """
    target = Path(path)
    write_whole(target, utf_8(page_html(_content(problem, plan))))
    return target


def save_glb(problem: PlanningTask, plan: PlanResult, path: str | Path) -> Path:
    """Write the scene of a plan with its motion as binary glTF, which Blender opens.

    Args:
        problem: The planning problem.
        plan: The result of planning.
        path: Of the file, which is written atomically.

    Returns:
        The path.
    """
    target = Path(path)
    write_whole(target, glb_scene(_content(problem, plan)))
    return target


def notebook_frame(problem: PlanningTask, plan: PlanResult | None) -> str:
    """Return the interactive page as HTML for a notebook.

    It runs in a sandboxed frame without access to the notebook or a network.

    Args:
        problem: The machine in its world.
        plan: The result of planning; None shows the problem alone.
    """
    page = html.escape(page_html(_content(problem, plan)))
    style = f"width: 100%; height: {FRAME_HEIGHT}px; border: 0"
    return f'<iframe sandbox="allow-scripts" style="{style}" srcdoc="{page}"></iframe>'


def _content(problem: PlanningTask, plan: PlanResult | None) -> Content:
    if plan is None:
        return content_of(problem, None, readiness(problem))
    return content_of(problem, plan.trajectory, facts_of(problem, plan), plan.graph)

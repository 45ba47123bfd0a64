"""A plan, or a problem before planning, inside a notebook."""

from __future__ import annotations

import html

from kinolab.problem import Problem
from kinolab.show.page import page_html
from kinolab.show.view.scenes import content_of, facts_of, readiness
from kinolab.solve import Plan

HEIGHT = 600  # pixels


def notebook_frame(problem: Problem, plan: Plan | None) -> str:
    """Return the interactive page as HTML that a notebook shows and keeps.

    It runs in a frame of its own, from which neither the notebook nor a network can be reached.

    Args:
        problem: The machine in its world.
        plan: What came of planning; None shows the problem alone.
    """
    if plan is None:
        content = content_of(problem, None, readiness(problem))
    else:
        content = content_of(problem, plan.trajectory, facts_of(problem, plan), plan.graph)
    page = html.escape(page_html(content))
    style = f"width: 100%; height: {HEIGHT}px; border: 0"
    return f'<iframe sandbox="allow-scripts" style="{style}" srcdoc="{page}"></iframe>'

"""A notebook shows systems, problems and plans by themselves."""

from __future__ import annotations

import html
import re
from dataclasses import replace

import pytest

import kinolab
from kinolab import systems
from kinolab.problem import PlanningTask


@pytest.fixture(scope="module")
def problem() -> PlanningTask:
    return kinolab.load("pendulum_swingup")


def page_in(frame: str) -> str:
    found = re.fullmatch(
        r'<iframe sandbox="allow-scripts" style="[^"]*" srcdoc="([^"]*)"></iframe>', frame
    )
    assert found is not None
    return html.unescape(found[1])


def test_a_plan_shows_itself_in_the_world_it_was_made_for(problem: PlanningTask) -> None:
    plan = problem.solve(planner="rrt_fast", seed=1, max_iterations=5000, optimize=False)
    shown = plan._repr_html_()
    assert shown is not None
    page = page_in(shown)
    assert page.startswith("<!doctype html>")
    assert '"status": "solved"' in page
    assert replace(plan, problem=None)._repr_html_() is None  # a notebook then prints its text
    assert "problem=" not in repr(plan)


def test_a_problem_shows_its_world_before_planning(problem: PlanningTask) -> None:
    assert '"status": "ready"' in page_in(problem._repr_html_())


def test_a_system_shows_its_equations() -> None:
    latex = systems.get("pendulum")._repr_latex_()
    assert latex.startswith("$$")
    assert r"\ddot" in latex

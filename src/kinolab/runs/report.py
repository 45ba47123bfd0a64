"""The report of a run: a plan and what it was made with, as plain data."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import asdict
from functools import lru_cache
from typing import Any

from kinolab.lazy import versions_of
from kinolab.loading import find_system
from kinolab.numerics.arrays import finite_or_none
from kinolab.problem import PlanningTask
from kinolab.problem.goal_entries import distance_by_unit, goal_entries
from kinolab.problem.goals_reached import nearest_end
from kinolab.problem.warnings import problem_warnings
from kinolab.runs.assets import digest_of
from kinolab.simulation.held_law import law_sentence
from kinolab.solve import PlanResult
from kinolab.verification import Certificate, Check

RECORDED = ("numpy", "scipy", "sympy", "numba", "llvmlite", "ompl", "python-fcl")


def report_of(
    problem: PlanningTask,
    plan: PlanResult,
    assets: Mapping[str, bytes],
    certified: str | None = None,
) -> dict[str, Any]:
    """Return what ``report.json`` says; what is not finite becomes null.

    Args:
        problem: What was planned.
        plan: What came of it.
        assets: Content of the files below ``assets/``, by name.
        certified: SHA-256 of ``certificate.json``; None where nothing was verified.
    """
    return {
        "schema_version": 1,
        "scenario": problem.name,
        "system": problem.machine.name,
        **facts_of_plan(problem, plan),
        "jobs": plan.jobs,
        "attempts": [asdict(attempt) for attempt in plan.attempts],
        "refused": plan.refused,
        "interrupted": plan.interrupted,
        "improvements": [asdict(improvement) for improvement in plan.improvements],
        "timings": plan.timings,
        "statistics": plan.statistics,
        "notes": list(problem.notes),
        "warnings": [*warnings_before(problem), *plan.warnings],
        "duration_bound": None,
        "diagnosis": {"rejections": plan.rejections},
        "certificate": certified,
        "assets": {name: digest_of(content) for name, content in assets.items()},
        "versions": versions(),
    }


@lru_cache(maxsize=8)
def warnings_before(problem: PlanningTask) -> tuple[str, ...]:
    """Return what one should know before a search, in sentences."""
    settings = problem.scenario.integration
    law = law_sentence(problem.model, settings, lambda: find_system(problem.scenario))
    return (*problem_warnings(problem), *filter(None, (law,)))


def facts_of_plan(problem: PlanningTask, plan: PlanResult) -> dict[str, Any]:
    """Return the facts about a plan that its page shows, by the keys of a report."""
    checks = plan.certificate.checks if plan.certificate else ()
    return {
        "status": plan.status,
        "message": plan.message,
        "planner": plan.planner,
        "seed": plan.seed,
        "iterations": plan.iterations,
        "cost": plan.cost,
        "duration": plan.duration,
        "goal_distance": finite_or_none(plan.goal_distance),
        "goal_distance_by_unit": goal_distance_by_unit(problem, plan),
        "margin": margin_to_json(plan.certificate),
        "verification": [check_to_json(check) for check in checks],
    }


def check_to_json(check: Check) -> dict[str, Any]:
    """Return a check as plain data; what is not finite becomes null."""
    return {**asdict(check), "value": finite_or_none(check.value)}


def margin_to_json(certificate: Certificate | None) -> dict[str, Any] | None:
    """Return a verified motion's smallest clearance as plain data, in m and s; null without one."""
    if certificate is None or certificate.margin is None:
        return None
    return asdict(certificate.margin)


def goal_distance_by_unit(problem: PlanningTask, plan: PlanResult) -> dict[str, float] | None:
    """Return how far a plan ends from the goal's centre in each unit; null where it has no end.

    The report's ``goal_distance`` is the norm of these, of whatever units.
    """
    if plan.trajectory is None:
        return None
    end = plan.trajectory.x[-1]
    return distance_by_unit(goal_entries(nearest_end(problem, end), end))


def versions() -> dict[str, str]:
    """Return the versions of Python, kinolab and the libraries that figures depend on."""
    found = versions_of("kinolab", *RECORDED)
    known = {package: number or "absent" for package, number in found.items()}
    return {"python": platform.python_version(), **known}

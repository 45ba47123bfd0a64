"""Method and substeps for stiff machines, where the scenario says nothing of them.

Steps that are stable stay as they are. Others become unstable motions that no search gets through,
and one would have to know which of several keys to change together.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from kinolab.dynamics.codegen.methods import METHODS, ROSENBROCK
from kinolab.errors import SingularError
from kinolab.problem import PlanningTask
from kinolab.scenario.schema import IntegrationSection
from kinolab.simulation.stability import (
    FEW_STATES,
    UNLIMITED_INPUT,
    fastest_rate,
    step_too_long,
    stiffness,
)
from kinolab.simulation.step_error import REFINEMENTS, TOLERATED


def steady(problem: PlanningTask) -> PlanningTask:
    """Return a problem whose steps are stable: the same one where they are, or where told so."""
    settings = problem.scenario.integration
    if settings.truth == "discrete" or {"method", "substeps"} & settings.model_fields_set:
        return problem
    if step_too_long(settings, fastest_rate(problem.model)) is None:  # a few states: cheap
        return problem
    found = stiffness(problem)
    if found is None:
        return problem
    chosen = _chosen(problem, found.rate)
    integration = type(settings)(**settings.model_dump(exclude_unset=True), **chosen)
    scenario, origin = problem.scenario, problem.scenario.origin
    note = _sentence(settings, integration, found.rate)
    changed = scenario.model_copy(update={"integration": integration})
    located = changed.located(replace(origin, notes=(*origin.notes, note)))
    return replace(problem, scenario=located)


def _chosen(problem: PlanningTask, rate: float) -> dict[str, Any]:
    """Return keys of ``[integration]`` that make steps stable.

    A linearly implicit step takes a derivative, which is worth nx evaluations of the equations at
    most. Explicit substeps are taken where they take fewer than that.
    """
    settings = problem.scenario.integration
    own = METHODS[settings.method]
    count = math.ceil(settings.step * rate / own.stability)
    if count * own.stages <= ROSENBROCK.stages + problem.model.nx:
        return {"substeps": _fine(problem, settings.method, count)}
    return {"method": ROSENBROCK.name, "substeps": _fine(problem, ROSENBROCK.name, 1)}


def _fine(problem: PlanningTask, method: str, least: int) -> int:
    """Return substeps, at least so many, of which a step from the start errs tolerably.

    Half as many are compared with all, under random inputs; none is enough where all err too much.
    """
    model, generator = problem.model, np.random.default_rng(0)
    lower, upper = np.clip(model.control_bounds, -UNLIMITED_INPUT, UNLIMITED_INPUT).T
    u = generator.uniform(lower, upper, (FEW_STATES, model.nu))
    x, h = np.tile(problem.start, (len(u), 1)), np.full(len(u), problem.step)
    counts = [least * factor for factor in (1, *REFINEMENTS)]
    with suppress(SingularError):  # no step so long can be made
        coarse = model.step(x, u, h, method=method, substeps=counts[0])
        for count, finer in pairwise(counts):
            fine = model.step(x, u, h, method=method, substeps=finer)
            errors = np.abs(model.space.difference(coarse, fine)) / problem.scales
            if np.isfinite(errors).all() and errors.max() <= TOLERATED:
                return count
            coarse = fine
    return least


def _sentence(before: IntegrationSection, after: IntegrationSection, rate: float) -> str:
    """Say what was chosen, and why."""
    parts = f" in {after.substeps} substeps" if after.substeps > 1 else ""
    return (
        f"Something in this machine changes within {1.0 / rate:.2g} s, too fast for steps of "
        f"{before.step / before.substeps:.3g} s by {before.method}: {after.method}{parts} is taken "
        "instead. Give [integration] method or substeps to choose otherwise."
    )

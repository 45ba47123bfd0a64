"""Step, method and substeps, where the scenario says nothing of them.

A step that is long for the motion leaves a search nothing to choose, and one that is unstable ends
in motions that no search gets through; one would have to know which of several keys to change
together. Other steps stay as they are.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from kinolab.dynamics.codegen.methods import METHODS, ROSENBROCK
from kinolab.errors import KinolabError, SingularError
from kinolab.loading.well_posed import MIN_STEP
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.scenario.schema import IntegrationSection
from kinolab.simulation.stability import (
    FEW_STATES,
    RANDOM_STATES,
    UNLIMITED_INPUT,
    fastest_rate,
    step_too_long,
    stiffness,
)
from kinolab.simulation.step_error import REFINEMENTS, TOLERATED

if TYPE_CHECKING:
    from kinolab.trajopt.multistart.guesses import Guesses


def steady(problem: PlanningTask) -> PlanningTask:
    """Return a problem whose steps are short for its motion and stable.

    It is the same one where they are, or where the scenario says what they are.
    """
    if problem.scenario.integration.truth == "discrete":
        return problem
    return _stable(_stepped(problem))


def _stepped(problem: PlanningTask) -> PlanningTask:
    """Return a problem of which a guess of the quickest motion has as many steps as any guess."""
    from kinolab.trajopt.nlp.options import GUESS  # late: where no step is given

    settings = problem.scenario.integration
    if "step" in settings.model_fields_set or problem.machine.modes:
        return problem
    least = _least_time(problem)
    longest = GUESS.durations[0] * least / GUESS.min_guess_steps
    if not 0.0 < longest < settings.step:
        return problem
    unit = 10.0 ** math.floor(math.log10(longest))
    step = max(MIN_STEP, float(f"{math.floor(longest / unit) * unit:.1g}"))
    return _changed(
        problem,
        {"step": step},
        f"This motion may take as little as {least:.2g} s, which is short for steps of "
        f"{settings.step:g} s: steps of {step:g} s are taken instead. Give [integration] step to "
        "choose otherwise.",
    )


def _least_time(problem: PlanningTask) -> float:
    """Estimate the least time in [s] of a motion into the goal, from rest to rest.

    No coordinate can take less at its largest rate, nor by speeding up and slowing down as it does
    from the start at the limits of the inputs: that takes 2 sqrt(way / acceleration). The way is
    the straight one, or a coordinate's scale where that takes longer, since a goal nearby may need
    a long way. It is infinite where nothing tells.
    """
    from kinolab.trajopt.multistart.guesses import Guesses  # late: where no step is given

    generator, model, nq = np.random.default_rng(0), problem.model, problem.model.nq
    guesses, still = Guesses(problem, generator), problem.start.copy()
    still[nq:] = 0.0
    aside = still.copy()
    aside[:nq] += problem.scales[:nq]
    lower, upper = np.clip(model.control_bounds.T, -UNLIMITED_INPUT, UNLIMITED_INPUT)
    u = np.where(generator.random((RANDOM_STATES, model.nu)) < 0.5, lower, upper)
    x = np.tile(still, (len(u), 1))
    with suppress(KinolabError):  # some equations are singular somewhere
        risen = x.copy()
        risen[:, nq:] = model.f(x, u)[:, nq:]  # rates are linear in velocities
        gained = np.abs(model.f(risen, u) - model.f(x, u))[:, :nq].max(axis=0)
        ways = guesses.straight(), np.stack([still, aside])
        return max(_least(guesses, way, gained) for way in ways)
    return math.inf


def _least(guesses: Guesses, way: Array, accelerations: Array) -> float:
    """Return the least time in [s] of a way from rest to rest, shape (2, nx)."""
    moved = np.abs(way[1] - way[0])[: len(accelerations)]
    if (accelerations[moved > 0.0] == 0.0).any():
        return math.inf
    speeding = (moved[moved > 0.0] / accelerations[moved > 0.0]).max(initial=0.0)
    return max(guesses.quickest(way), 2.0 * math.sqrt(speeding))


def _stable(problem: PlanningTask) -> PlanningTask:
    """Return a problem whose steps are stable."""
    settings = problem.scenario.integration
    if {"method", "substeps"} & settings.model_fields_set:
        return problem
    if step_too_long(settings, fastest_rate(problem.model)) is None:  # a few states: cheap
        return problem
    found = stiffness(problem)
    if found is None:
        return problem
    chosen = _chosen(problem, found.rate)
    after = settings.model_copy(update=chosen)
    return _changed(problem, chosen, _sentence(settings, after, found.rate))


def _changed(problem: PlanningTask, chosen: dict[str, Any], note: str) -> PlanningTask:
    """Return a problem with keys of ``[integration]`` that were chosen, and a note that says so."""
    scenario, settings = problem.scenario, problem.scenario.integration
    integration = type(settings)(**settings.model_dump(exclude_unset=True), **chosen)
    changed = scenario.model_copy(update={"integration": integration})
    origin = replace(scenario.origin, notes=(*scenario.origin.notes, note))
    return replace(problem, scenario=changed.located(origin))


def _chosen(problem: PlanningTask, rate: float) -> dict[str, Any]:
    """Return keys of ``[integration]`` that make steps stable, and follow the motion if they can.

    Of the scenario's method and an implicit one, it is the one that then takes less work.
    """
    settings, nx = problem.scenario.integration, problem.model.nx
    own = METHODS[settings.method]
    least = math.ceil(settings.step * rate / own.stability)
    implicit = _fine(problem, ROSENBROCK.name, 1, REFINEMENTS[-1])
    worth = (implicit or 1) * ROSENBROCK.evaluations(nx) // own.evaluations(nx)
    explicit = _fine(problem, settings.method, least, worth)
    if explicit is None and implicit is None and least <= worth:
        explicit = least
    if explicit is not None:
        return {"substeps": explicit}
    return {"method": ROSENBROCK.name, "substeps": implicit or 1}


def _fine(problem: PlanningTask, method: str, least: int, most: int) -> int | None:
    """Return substeps within limits of which a step from the start errs tolerably, if any do.

    Twice as many are compared with them, under random inputs.
    """
    model, generator = problem.model, np.random.default_rng(0)
    lower, upper = np.clip(model.control_bounds, -UNLIMITED_INPUT, UNLIMITED_INPUT).T
    u = generator.uniform(lower, upper, (FEW_STATES, model.nu))
    x, h = np.tile(problem.start, (len(u), 1)), np.full(len(u), problem.step)
    counts = [least * factor for factor in (1, *REFINEMENTS)]
    if least > most:
        return None
    with suppress(SingularError):  # no step so long can be made
        coarse = model.step(x, u, h, method=method, substeps=least)
        for count, finer in pairwise(counts):
            fine = model.step(x, u, h, method=method, substeps=finer)
            errors = np.abs(model.space.difference(coarse, fine)) / problem.scales
            if np.isfinite(errors).all() and errors.max() <= TOLERATED:
                return count
            if finer > most:
                return None
            coarse = fine
    return None


def _sentence(before: IntegrationSection, after: IntegrationSection, rate: float) -> str:
    """Say what was chosen, and why."""
    parts = f" in {after.substeps} substeps" if after.substeps > 1 else ""
    return (
        f"Something in this machine changes within {1.0 / rate:.2g} s, too fast for steps of "
        f"{before.step / before.substeps:.3g} s by {before.method}: {after.method}{parts} is taken "
        "instead. Give [integration] method or substeps to choose otherwise."
    )

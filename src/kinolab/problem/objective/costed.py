"""The same problem, of a machine that has one state more: what its motion has cost so far.

So the cost is integrated by whatever integrates the motion, its derivatives are those of a state,
and a bound on it is a limit of that state (Mayer's form of an optimal control problem).

Source: Betts, Practical Methods for Optimal Control and Estimation Using Nonlinear Programming,
2nd ed., 2010, section 4.9 (forms of Bolza, Lagrange and Mayer).
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from kinolab.dynamics import Model
from kinolab.errors import InputError, SingularError
from kinolab.problem.machines.standing import with_machine
from kinolab.problem.task import PlanningTask
from kinolab.scenario import Issue, Scenario, mistake_at

if TYPE_CHECKING:
    from kinolab.dynamics.language.mechanism import Mechanism

COST = "cost"  # what the state is called


@lru_cache(maxsize=8)
def costed(problem: PlanningTask) -> PlanningTask | None:
    """Return a problem whose states have a further entry, the cost so far, 0 at the start.

    None without an [objective], whose cost is the duration.

    Raises:
        InputError: If the machine cannot have such terms, or a formula is none.
    """
    model, scenario = problem.model, problem.scenario
    if scenario.objective is None or problem.cost_entry is not None:
        return None
    content = json.dumps([model.key, COST, scenario.objective.model_dump(mode="json")])
    made = Model.described_by(content, partial(_with_cost, model, scenario))
    return replace(
        with_machine(problem, made, made),
        whole=None,
        cost_entry=made.state_names.index(COST),
    )


def without_objective(problem: PlanningTask) -> PlanningTask:
    """Return the same problem whose cost is the duration; itself without an [objective]."""
    scenario = problem.scenario
    if scenario.objective is None:
        return problem
    return replace(problem, scenario=scenario.model_copy(update={"objective": None}))


def require_costs(problem: PlanningTask) -> None:
    """Require that what [objective] says can be a cost: one that never falls, within all limits.

    Raises:
        InputError: If it is none, or where it falls: who searches gives up what costs more already.
    """
    priced = costed(problem)
    if priced is None or priced.cost_entry is None:
        return
    made, entry, generator = priced.model, priced.cost_entry, np.random.default_rng(0)
    # states at which a cost must not fall
    x = np.array([problem.start, *(problem.sample(generator) for _ in range(1000))])
    lower, upper = made.control_bounds.T
    u = generator.uniform(lower, upper, (len(x), made.nu))
    issue = ("objective", "expression")
    try:
        rates = made.f(np.insert(x, entry, 0.0, axis=1), u)[:, entry]
    except SingularError as error:
        what = f"what a second costs is no number everywhere: {error}"
        raise InputError([mistake_at(Issue(issue, what), problem.scenario.origin)]) from error
    k = int(np.argmin(rates))
    if rates[k] < 0.0:
        named = zip((*problem.model.state_names, *made.control_names), (*x[k], *u[k]), strict=True)
        where = ", ".join(f"{name} = {value:.3g}" for name, value in named)
        what = f"what a second costs is below 0 at {where}: {rates[k]:.3g}."
        remedy = "Add a constant, or take a square."
        raise InputError([mistake_at(Issue(issue, what, remedy), problem.scenario.origin)])


def _with_cost(model: Model, scenario: Scenario) -> Mechanism:
    """Return a machine with a state that its cost is the derivative of; its mode stays the last."""
    # Imported here: a machine that is in the cache needs no symbols.
    from kinolab.dynamics import State
    from kinolab.dynamics.language.modes import MODE
    from kinolab.problem.objective.running_cost import running_cost

    system = model.system
    spent = State(COST, running_cost(scenario, system))
    own = [entry for entry in system.states if entry.name != MODE]
    modes = [entry for entry in system.states if entry.name == MODE]
    return system.changed(states=[*own, spent, *modes], flat=None)

"""The planning task of a machine's kinematic reduction: a path first, its dynamics later."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from kinolab.dynamics import Model
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.problem.goal import Goal
from kinolab.problem.static_holding import static_holding
from kinolab.problem.task import PlanningTask
from kinolab.scenario import Issue, mistake_at

if TYPE_CHECKING:
    from kinolab.dynamics.language.mechanism import Mechanism


def kinematic_task(problem: PlanningTask) -> PlanningTask:
    """Return the task of finding a motion of a machine's kinematic reduction.

    Its states are the machine's configurations, its inputs the machine's independent velocities,
    within the same limits.

    Args:
        problem: Of the machine with its dynamics.

    Raises:
        InputError: If it has no reduction: where no constraint is nonholonomic, where the inputs do
            not accelerate the machine along each velocity that the constraints leave, or where it
            begins or ends in motion.
    """
    model = problem.model
    reason = _obstacle(problem)
    if reason:
        raise _refusal(problem, reason)
    limits = [(float(a), float(b)) for a, b in problem.bounds[model.nq : model.nq + model.nv]]
    content = json.dumps([model.key, "kinematic reduction", limits])
    reduction = Model.described_by(content, partial(_reduction, model, limits))
    if reduction.coordinate_names != model.coordinate_names or reduction.nx != model.nq:
        raise _refusal(problem, "its constraints need more than its velocities")
    own = slice(0, model.nq)
    return replace(
        problem,
        machine=reduction.machine,
        model=reduction,
        whole=None,
        start=problem.start[own],
        goal=_placed(problem.goal, model.nq),
        bounds=problem.bounds[own],
        rate_bounds=_all_rates(problem),
        scales=problem.scales[own],
        weights=problem.weights[own],
        circular=problem.circular[own],
    )


def follows_every_path(problem: PlanningTask) -> bool:
    """Say whether a machine can follow every path of its coordinates slowly, from rest to rest.

    So can one without constraints whose inputs accelerate it along all of them, such as an arm with
    a motor in each joint, if they hold it where it is.
    """
    model, machine, generator = problem.model, problem.machine, np.random.default_rng(0)
    # random configurations in which a machine must be held
    holdings = (static_holding(problem, problem.sample(generator)) for _ in range(10))
    return bool(
        not (machine.constraints or machine.modes or machine.states)
        and problem.scenario.integration.truth != "discrete"
        and model.nv == model.nq
        and _accelerates_all(problem)
        and _begins_and_ends_at_rest(problem)
        and all(held is not None and held.holds for held in holdings)
    )


def _reduction(model: Model, limits: list[tuple[float, float]]) -> Mechanism:
    from kinolab.dynamics.analysis.kinematic_reduction import kinematic_reduction  # uses SymPy

    return kinematic_reduction(model.system, limits)


def _refusal(problem: PlanningTask, reason: str) -> InputError:
    what = f"{problem.machine.name} has no kinematic reduction: {reason}."
    issue = Issue(("planner", "name"), what, "Take another planner, such as auto.")
    return InputError([mistake_at(issue, problem.scenario.origin)])


def _obstacle(problem: PlanningTask) -> str:
    """Say what keeps a machine from following the paths of a reduction; nothing where none does."""
    model, machine = problem.model, problem.machine
    if machine.references is not None or machine.states:
        return "it has feedback or states of its own"
    if model.clocks:
        return "its world moves on with time, and the dynamics follow more slowly"
    if problem.scenario.integration.truth == "discrete":
        return "its motion is defined by discrete steps"
    if not model.nv:
        return "its inputs are velocities already"
    if machine.all_rates or all(constraint.of_position for constraint in machine.constraints):
        return "no constraint takes velocities away from its state"
    if not _accelerates_all(problem):
        return "its inputs do not accelerate it along every velocity that the constraints leave"
    return (
        "" if _begins_and_ends_at_rest(problem) else "it does not rest at the start and in the goal"
    )


def _accelerates_all(problem: PlanningTask) -> bool:
    """Say whether inputs accelerate the machine along every independent velocity at its start."""
    model = problem.model
    if model.nv > model.nu:
        return False
    idle = model.null_control()
    ranges = np.ptp(model.control_bounds, axis=1)
    effect = model.jacobian(problem.start, idle)[1][model.nq :] * ranges
    if not np.isfinite(effect).all():
        return False
    sizes = np.linalg.svd(effect / problem.scales[model.nq :, None], compute_uv=False)
    # singular value of the inputs' effect, relative to the largest
    return bool(sizes[-1] > 1e-6 * sizes[0])


def _begins_and_ends_at_rest(problem: PlanningTask) -> bool:
    """Say whether the machine rests at the start, and may rest in the goal."""
    nq, goal = problem.model.nq, problem.goal
    wanted = [
        abs(target) <= tolerance
        for i, target, tolerance in zip(goal.indices, goal.targets, goal.tolerances, strict=True)
        if i >= nq
    ]
    return problem.rests(problem.start) and all(wanted)


def _placed(goal: Goal, nq: int) -> Goal:
    """Return what a goal says of configurations (nq,)."""
    kept = [k for k, i in enumerate(goal.indices) if i < nq]
    return replace(
        goal,
        indices=tuple(goal.indices[k] for k in kept),
        targets=goal.targets[kept],
        tolerances=goal.tolerances[kept],
        circular=goal.circular[kept],
    )


def _all_rates(problem: PlanningTask) -> Array:
    """Return the limits of all rates (nt, 2), those that are states of the machine included."""
    model, limits = problem.model, problem.rate_bounds.copy()
    for i, name in enumerate(model.rate_names):
        if name in model.state_names:
            limits[i] = problem.bounds[model.state_names.index(name)]
    return limits

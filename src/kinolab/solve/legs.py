"""Several goals: a plan for each leg, from where the one before it ends, and one motion of all.

In any order, legs between the goals' centres are planned first, and the order of the shortest way
through all of them is taken (the travelling salesman's path, by dynamic programming).

Source: Held, Karp, A dynamic programming approach to sequencing problems, Journal of the Society
for Industrial and Applied Mathematics 10(1), 1962.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np

from kinolab.errors import EndpointError, Mistake
from kinolab.problem import PlanningTask
from kinolab.problem.goal import Goal
from kinolab.problem.goals_reached import each_goal, ends, nearest_end
from kinolab.problem.static_holding import static_holding
from kinolab.problem.time_steps import covering_steps
from kinolab.scenario import place_at
from kinolab.scenario.issues import KeyPath
from kinolab.simulation.reference import DivergedError, price, resimulate, trajectory_under
from kinolab.solve.plan import REFUSED, Improvement, PlanResult
from kinolab.trajectory import Trajectory
from kinolab.verification import verify

Solve = Callable[[PlanningTask], PlanResult]


def solved_in_legs(problem: PlanningTask, solve: Solve, glance: Solve) -> PlanResult:
    """Return a plan that reaches each goal, and stays there as long as it must.

    Args:
        problem: With goals on the way, or one in which the machine stays.
        solve: Plans for one leg.
        glance: Does so with less work, to tell how far goals are apart.

    Raises:
        EndpointError: If a goal is impossible, or the machine cannot stay in it.
    """
    legs, places = each_goal(problem), list(problem.scenario.goals)
    holds = [section.hold for section in problem.scenario.goals.values()]
    _require_possible(problem, legs, places)
    order = list(range(len(legs)))
    if problem.scenario.goal.order == "any":
        order = _shortest_order(legs, glance)
    made: list[PlanResult] = []
    motions: list[Trajectory] = []
    before: PlanningTask | None = None
    for k in order:
        leg = legs[k] if not motions else replace(legs[k], start=motions[-1].x[-1])
        leg = _nearest_end(leg, glance)
        found = solve(leg)
        if found.status != "solved" and before is not None and not leg.rests(leg.start):
            resting = before.goal.changed(partial(Goal.at_rest, speeds=before.model.speeds))
            slower = solve(replace(before, goal=resting))  # it may have come too fast to its turn
            if slower.status == "solved" and slower.trajectory is not None:
                made[-1], motions[-1] = slower, slower.trajectory
                leg = replace(legs[k], start=motions[-1].x[-1])
                leg = _nearest_end(leg, glance)
                found = solve(leg)
        made.append(found)
        if found.status != "solved" or found.trajectory is None:
            return _without_end(problem, made, motions)
        motions.append(found.trajectory)
        if holds[k]:
            where = place_at((*places[k], "hold"), problem.scenario.origin)
            motions[-1] = _joined(
                problem, [motions[-1], _staying(legs[k], motions[-1].x[-1], holds[k], where)]
            )
        before = leg
    return _whole(problem, made, _joined(problem, motions))


def _require_possible(
    problem: PlanningTask, legs: Sequence[PlanningTask], places: Sequence[KeyPath]
) -> None:
    """Raise where the start or a goal is impossible, with all mistakes, each at its goal."""
    mistakes: dict[Mistake, None] = {}
    for leg, place in zip(legs, places, strict=True):
        own, here = (place_at(at, problem.scenario.origin) for at in (("goal",), place))
        wrong = [_impossible(one) for one in ends(leg)]
        told = [replace(m, where=m.where.replace(own, here)) for one in wrong for m in one]
        mistakes |= dict.fromkeys(told if all(wrong) else [])
    if mistakes:
        raise EndpointError(list(mistakes))


def _impossible(leg: PlanningTask) -> Sequence[Mistake]:
    """Return what makes the start or the goal impossible."""
    try:
        leg.check_endpoints()
    except EndpointError as error:
        return error.mistakes
    return ()


def _nearest_end(leg: PlanningTask, glance: Solve) -> PlanningTask:
    """Return the problem with that goal alone, of those of which any will do, that costs least."""
    each = ends(leg)
    return each[0] if len(each) == 1 else min(each, key=lambda one: _cost(one, glance))


def _cost(leg: PlanningTask, glance: Solve) -> float:
    """Return what a leg costs, planned with little work; infinity where no plan is found."""
    try:
        found = glance(leg)
    except EndpointError:  # what the goal leaves free does not fit
        return math.inf
    return found.cost or 0.0 if found.status == "solved" else math.inf


def _joined(problem: PlanningTask, motions: Sequence[Trajectory]) -> Trajectory:
    whole = motions[0]
    for further in motions[1:]:
        end = len(whole.u)
        whole = whole.with_piece(end, end, further, problem.space)
    return whole


def _staying(leg: PlanningTask, x: np.ndarray, seconds: float, where: str) -> Trajectory:
    """Return a motion that stays at a state for some seconds.

    Raises:
        EndpointError: If no inputs hold the machine there.
    """
    held = static_holding(leg, x)
    if held is None or not (held.holds and leg.rests(x)):
        what = "the machine cannot stay where it comes to."
        raise EndpointError([Mistake(where, what, "Write at_rest = true, or leave hold out.")])
    steps = covering_steps(seconds, leg.step)
    t = seconds / steps * np.arange(steps + 1.0)
    u = np.tile(list(held.inputs.values()), (steps, 1))
    return trajectory_under(leg.model, t, np.tile(x, (steps + 1, 1)), u)


def _shortest_order(legs: Sequence[PlanningTask], glance: Solve) -> list[int]:
    """Return the order of the goals of the least cost of all legs, by plans between their centres.

    A leg for which no plan is found costs infinitely much.
    """
    n = len(legs)
    starts = [leg.goal.centre(leg.start) for leg in legs]

    first = [_cost(leg, glance) for leg in legs]
    between = [
        [0.0 if i == k else _cost(replace(legs[k], start=starts[i]), glance) for k in range(n)]
        for i in range(n)
    ]
    best = {(frozenset([k]), k): (first[k], [k]) for k in range(n)}
    for size in range(2, n + 1):
        for chosen in map(frozenset, combinations(range(n), size)):
            for k in sorted(chosen):
                before = [
                    (best[chosen - {k}, i][0] + between[i][k], [*best[chosen - {k}, i][1], k])
                    for i in sorted(chosen - {k})
                ]
                best[chosen, k] = min(before)
    return min(best[frozenset(range(n)), k] for k in range(n))[1]


def _whole(problem: PlanningTask, made: Sequence[PlanResult], motion: Trajectory) -> PlanResult:
    """Return the plan of all legs, verified as one."""
    try:
        true = resimulate(problem, motion.t, motion.inputs)
    except DivergedError as error:
        return replace(_added(made), status=REFUSED, trajectory=motion, message=str(error))
    certificate = verify(problem, true)
    solved, last = certificate.passed, made[-1]
    plan = replace(
        _added(made),
        status="solved" if solved else REFUSED,
        message=last.message if solved else "The legs, joined, are no plan.",
        trajectory=true,
        certificate=certificate,
        goal_distance=nearest_end(problem, true.x[-1]).goal_distance(true.x[-1]),
        price=price(problem, true),
    )
    if not solved:
        return plan
    after = sum(plan.timings.values())
    found = Improvement(after, true.duration, plan.goal_distance, "search", plan.seed, plan.price)
    return replace(plan, improvements=(found,))


def _without_end(
    problem: PlanningTask, made: Sequence[PlanResult], motions: Sequence[Trajectory]
) -> PlanResult:
    """Return what there is of a plan: the legs that were found."""
    last, count = made[-1], len(motions) + 1
    known = _joined(problem, motions) if motions else last.trajectory
    return replace(
        _added(made),
        trajectory=known,
        certificate=None,
        message=f"Leg {count} of {len(problem.via) + 1}: {last.message}",
        goal_distance=problem.goal_distance(problem.start if known is None else known.x[-1]),
    )


def _added(made: Sequence[PlanResult]) -> PlanResult:
    """Return the last leg's plan with the times and iterations of all."""
    timings: dict[str, float] = {}
    for one in made:
        timings |= {key: timings.get(key, 0.0) + value for key, value in one.timings.items()}
    return replace(
        made[-1],
        timings=timings,
        statistics={},
        iterations=sum(one.iterations for one in made),
        interrupted=any(one.interrupted for one in made),
        graph=None,
        improvements=(),
    )

"""The planning pipeline: the one function behind ``problem.solve`` and ``plan SCENARIO``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from kinolab.arguments import require_fit
from kinolab.errors import InputError, Mistake
from kinolab.problem import PlanningTask
from kinolab.problem.goals_reached import in_legs
from kinolab.scenario import Effort, argument_mistakes
from kinolab.search import Budget
from kinolab.solve.legs import solved_in_legs
from kinolab.solve.parallel import solve_at_once
from kinolab.solve.plan import Listeners, PlanResult, Request, make_planner
from kinolab.solve.sequential_runs import sequential_runs
from kinolab.solve.solution_pool import SolutionPool
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from kinolab.verification.afterwards import hit_while_waiting
from kinolab.verification.checks.check import require_motion_of


def solve(
    problem: PlanningTask,
    planner: str | None = None,
    seed: int | None = None,
    time_limit: float | None = None,
    *,
    max_iterations: int | None = None,
    jobs: int = 1,
    anytime: bool = False,
    optimize: bool = True,
    improve: Effort | None = None,
    guess: Trajectory | None = None,
    contained: bool = False,
    robust: bool = True,
    progress: Callable[[int, float], None] | None = None,
    watch: Callable[[Budget], None] | None = None,
    improved: Callable[[PlanResult], None] | None = None,
    **settings: Any,
) -> PlanResult:
    """Search for a plan, re-simulate it, verify it, and make it exact and shorter.

    ``improve`` limits this last stage. Its seconds count work as an idle computer does it, so that
    the same seed gives the same plan on a busy one.

    Args:
        planner: Name of the planner; the scenario's when left out, as are the next four.
        time_limit: Of the search, in [s].
        max_iterations: Of the search with each seed.
        improve: Work on making the solution exact and shorter, in [s]; 0 for none, ``"auto"`` for
            more where the motion is long.
        jobs: Number of parallel searches, with this seed and the following ones: in threads with a
            compiled planner, else in processes. The first verified plan ends the others.
        anytime: Whether to continue until the time limit with further seeds and keep the verified
            plan of the shortest duration.
        optimize: Whether to make the solution exact and shorter, and search again; without it the
            plan is the planner's own, which may then use ``improve`` itself.
        guess: A motion of this machine, such as the last plan of a world that has changed: where it
            can be made to fit, nothing is searched for.
        contained: Whether each of several searches has a process of its own in any case, so that
            native code which crashes ends one of them.
        robust: Whether a plan is made that is proved under the scenario's [robust], if it has one.
        progress: Called during the search with the iterations and seconds so far.
        watch: Called with the budget before each search, so that it can be interrupted.
        improved: Called with each verified plan that is better than those before.
        settings: Settings of the planner.

    Raises:
        EndpointError: If the start or the goal is impossible.
        InputError: If the planner or a setting does not exist, an argument is no such value, or the
            guess is of another machine.
        JobsError: If no process of several completed.
    """
    _check_arguments(planner, jobs, seed=seed, time_limit=time_limit,
                     max_iterations=max_iterations, improve=improve)  # fmt: skip
    section = problem.scenario.planner
    request = Request(
        planner,
        settings,
        seed=section.seed if seed is None else seed,
        time_limit=section.time_limit if time_limit is None else time_limit,
        max_iterations=max_iterations or section.max_iterations,
        jobs=jobs,
        anytime=anytime,
        optimize=optimize,
        improve=improve,
        guess=guess,
        contained=contained,
        robust=robust,
    )
    return _planned(problem, request, Listeners(progress, watch, improved))


def _planned(problem: PlanningTask, request: Request, listeners: Listeners) -> PlanResult:
    """Plan leg by leg, for a proof, or at once, as the scenario asks."""
    inner = replace(listeners, improved=None)  # what is better of a part is none of the whole
    if in_legs(problem):
        if request.guess is not None:
            what, remedy = "a motion is no guess for several goals.", "Leave it out."
            raise InputError([Mistake("solve guess", what, remedy)])
        # [s] of work on each leg between goals, to tell how far these are apart
        glance = replace(request, improve=1.0)
        return solved_in_legs(
            problem,
            lambda leg: _planned(leg, request, inner),
            lambda leg: _planned(leg, glance, inner),
        )
    if not request.robust or problem.scenario.robust is None:
        return _searched(problem, request, listeners)
    if request.jobs > 1 or request.anytime:
        what = "plans that are proved are made one after the other."
        raise InputError([Mistake("solve", what, "Leave out jobs and anytime.")])
    from kinolab.solve.robustness.robust_plans import solved_robustly  # late: loads SymPy

    made, claim = solved_robustly(
        problem,
        lambda one, guess: _searched(one, replace(request, guess=guess), inner),
        request.guess,
    )
    if claim is None or made.trajectory is None:
        return made
    return replace(made, certificate=verify(problem, made.trajectory), claim=claim)


def _searched(problem: PlanningTask, request: Request, listeners: Listeners) -> PlanResult:
    """Return the best plan of one search or several."""
    searcher = make_planner(problem, request.planner, request.settings)
    problem.require_goal()
    problem.check_endpoints()
    if request.guess is not None:
        require_fit("solve guess", Trajectory, request.guess)
        require_motion_of(problem.model, request.guess, "solve guess")
    pool, budgets = SolutionPool(request.jobs, listeners.improved), list[Budget]()

    def watch(budget: Budget) -> None:
        budgets.append(budget)
        if listeners.watch:
            listeners.watch(budget)

    own = replace(listeners, watch=watch, improved=pool.compare)
    if request.jobs > 1:
        solve_at_once(problem, request, pool, searcher.in_threads and not request.contained, own)
    else:
        for found, after in sequential_runs(problem, searcher, request, own):
            pool.add(found, after)
    best = pool.plan(interrupted=any(budget.interrupted for budget in budgets))
    if best is not None and best.status == "solved" and best.trajectory is not None:
        hit = hit_while_waiting(problem, best.trajectory)
        return best if hit is None else replace(best, warnings=(*best.warnings, hit))
    return best or PlanResult(
        "interrupted",
        None,
        None,
        request.planner or problem.scenario.planner.name,
        request.seed,
        sum(attempt.iterations for attempt in pool.all),
        problem.goal_distance(problem.start),
        message="Interrupted before anything was found.",
        jobs=request.jobs,
        attempts=pool.all,
        interrupted=True,
    )


def _check_arguments(planner: object, jobs: int, **keys: object) -> None:
    """Hold the arguments of ``solve`` against the keys of [planner] that they stand for."""
    require_fit("solve jobs", int, jobs)
    given = {"planner": ("name", planner), **{key: (key, value) for key, value in keys.items()}}
    mistakes = list(
        argument_mistakes("solve", {k: told for k, told in given.items() if told[1] is not None})
    )
    if jobs < 1:
        mistakes.append(
            Mistake("solve jobs", f"{jobs} processes cannot search.", "Give 1 or more.")
        )
    if mistakes:
        raise InputError(mistakes)

"""Diagnosis of a failed search: findings, sentences about them, and what to try next."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kinolab.analyze.diagnose.growing_errors import growing_errors_sentence
from kinolab.analyze.diagnose.reached_rates import unreached_directions, unreached_sentences
from kinolab.analyze.diagnose.relaxation_trials import (
    RelaxationTrial,
    relaxation_trials,
    trial_sentences,
)
from kinolab.analyze.diagnose.relaxations import moving_obstacles
from kinolab.analyze.diagnose.state_clearance import (
    approach_sentences,
    clearance_sentences,
    largest_clearance,
    unmet_sentences,
)
from kinolab.analyze.diagnose.unmoved_goals import unmoved_goals, unmoved_sentences
from kinolab.analyze.diagnose.verification_summary import verification_sentences
from kinolab.arguments import require_fit
from kinolab.errors import InputError, Mistake
from kinolab.loading import find_system
from kinolab.planners.auto import MEMBERS, Auto
from kinolab.problem import PlanningTask
from kinolab.problem.goal_entries import GoalEntry, goal_entries
from kinolab.problem.goal_states import GoalStates, goal_states
from kinolab.problem.machines.standing import standing
from kinolab.problem.static_holding import (
    StaticHolding,
    best_static_holding,
    holding_sentences,
    start_holding,
)
from kinolab.simulation import Stiffness, stiffness
from kinolab.simulation.held_law import law_sentence
from kinolab.solve import PlanResult
from kinolab.verification.between_samples.clearance_margin import StateClearance, state_clearance

if TYPE_CHECKING:
    from kinolab.analyze.diagnose.narrow_passage.passage import Passage


LONGER = 4  # times as long as the search that failed


def rejection_sentences(rejections: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    """Name the main rejection sources, by cause.

    Args:
        rejections: Fraction of all rejected motions, by cause and source.
    """
    shares = [
        (fraction, cause, culprit)
        for cause, culprits in rejections.items()
        for culprit, fraction in culprits.items()
        if fraction >= 0.01  # of all rejected motions: smaller sources are not named
    ]
    named = [
        f"{cause}, {culprit} ({fraction:.0%})"
        for fraction, cause, culprit in sorted(shares, key=lambda entry: -entry[0])[:4]
    ]
    if named:
        yield f"Motions were refused for: {'; '.join(named)}."


LIMIT = "limit"  # the cause under which planners count limit violations
TOTAL_SECONDS = 15.0  # of the whole diagnosis
PASSAGE_SECONDS = 9.0  # of the geometric path search

# of ``solve``, each with what would work instead
SOLVE_ARGUMENTS: Mapping[str, str] = {
    "planner": "The plan's planner searches again; give another planner's plan.",
    "seed": "The plan's seed is taken again; give a plan of another seed.",
    "time_limit": f"A diagnosis takes {TOTAL_SECONDS:g} s at most; max_iterations makes its "
    "searches shorter.",
    "jobs": "Leave it out: one search is made at a time.",
    "anytime": "Leave it out: the first motion into the goal answers the question.",
    "optimize": "Leave it out: motions are not improved.",
    "improve": "Leave it out: motions are not improved.",
}

Say = Callable[[str], None]


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """Findings about a search; ``print`` shows them in words.

    Attributes:
        sentences: The findings in words, the most useful one first.
        rejections: Fraction of all rejected motions, by cause and source.
        approach: The goal's entries with targets and reached values, worst first.
        start_clearance: Clearance at the start.
        goal_clearance: Largest clearance in the goal; None if no goal state was found.
        start_held: How inputs hold the machine at the start; None if it cannot be evaluated.
        goal_held: The same, at the state of the goal region that is easiest to hold.
        stiffness: What makes the steps unstable; None if they are stable.
        unreached: Directions of velocity that no input changes, as components by name.
        unmoved: Entries of the goal that stay as they are in all motions from the start.
        retries: Searches with one relaxation each.
        passage: Result of the geometric path search; None if there was none.
        seconds: How long the diagnosis took.
    """

    sentences: tuple[str, ...]
    rejections: Mapping[str, Mapping[str, float]]
    approach: tuple[GoalEntry, ...]
    start_clearance: StateClearance
    goal_clearance: StateClearance | None
    start_held: StaticHolding | None
    goal_held: StaticHolding | None
    stiffness: Stiffness | None
    unreached: tuple[dict[str, float], ...]
    unmoved: tuple[GoalEntry, ...]
    retries: tuple[RelaxationTrial, ...]
    passage: Passage | None
    seconds: float

    def __repr__(self) -> str:
        """Name its first finding; ``print`` shows all of them."""
        return f"<Diagnosis: {' '.join(self.sentences[:1])}>"

    def __str__(self) -> str:
        """Return its findings, one a line."""
        return "\n".join(self.sentences)

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data; what is not finite becomes null."""
        plain: dict[str, Any] = _plain(asdict(self))
        return plain


def diagnose(
    problem: PlanningTask,
    plan: PlanResult,
    *,
    progress: Say | None = None,
    max_iterations: int | None = None,
    **settings: Any,
) -> Diagnosis:
    """Diagnose why a search found no plan; takes about 15 s of an idle computer at most.

    A plan that was found is described without further searches.

    Args:
        plan: Result of the search, by any planner.
        progress: Receives progress messages.
        max_iterations: Of each search with one thing changed; as many as the plan's search made
            when left out.
        settings: Planner settings in addition to the scenario's.

    Raises:
        InputError: If an argument is something else, or one of ``solve`` that means nothing here.
    """
    require_fit("diagnose problem", PlanningTask, problem)
    require_fit("diagnose plan", PlanResult, plan)
    require_fit("diagnose max_iterations", int | None, max_iterations)
    if max_iterations is not None and max_iterations < 1:
        what = f"{max_iterations} is no number of iterations."
        raise InputError([Mistake("diagnose max_iterations", what, "Give 1 or more.")])
    if wrong := [name for name in SOLVE_ARGUMENTS if name in settings]:
        what = "it is an argument of solve."
        raise InputError([Mistake(f"diagnose {n}", what, SOLVE_ARGUMENTS[n]) for n in wrong])
    begun, worked = time.monotonic(), time.thread_time()
    say = progress or (lambda _: None)
    say("looking at start and goal")
    goals = goal_states(problem)
    found = _described(problem, plan, goals)
    if plan.status != "solved":
        passage = _passage(problem, goals, say)
        left = TOTAL_SECONDS - (time.thread_time() - worked)
        most = plan.iterations if max_iterations is None else max_iterations
        trials = relaxation_trials(problem, plan, settings, left, say, most)
        found = replace(found, passage=passage, retries=trials)
    sentences = tuple(_sentences(problem, plan, goals, found))
    return replace(found, sentences=sentences, seconds=time.monotonic() - begun)


def _described(problem: PlanningTask, plan: PlanResult, goals: GoalStates) -> Diagnosis:
    """Return the findings that need no search."""
    checker, stored = problem.checker(), [np.empty((0, problem.model.nx))]
    stored += [] if plan.graph is None else [plan.graph.x]
    stored += [] if plan.trajectory is None else [plan.trajectory.x]
    end = problem.start if plan.trajectory is None else plan.trajectory.x[-1]
    return Diagnosis(
        sentences=(),
        rejections=plan.rejections,
        approach=goal_entries(problem, end),
        start_clearance=state_clearance(problem, problem.start, checker),
        goal_clearance=largest_clearance(problem, goals.inside, checker),
        start_held=start_holding(problem),
        goal_held=best_static_holding(problem, goals.inside),
        stiffness=stiffness(problem, np.concatenate(stored)),
        unreached=unreached_directions(problem),
        unmoved=unmoved_goals(problem),
        retries=(),
        passage=None,
        seconds=0.0,
    )


def _passage(problem: PlanningTask, goals: GoalStates, say: Say) -> Passage | None:
    """Search for a geometric path, if OMPL is installed; obstacles that move are left out."""
    moving = moving_obstacles(problem)
    try:
        from kinolab.analyze.diagnose.narrow_passage.passage import find_passage, is_applicable
    except ModuleNotFoundError:
        return None
    still = standing(problem)
    if still is not None:
        problem, goals = still, goal_states(still)
    if not goals.inside or not is_applicable(problem):
        return None
    found = find_passage(problem, goals.inside, PASSAGE_SECONDS, say)
    return replace(found, without=moving)


def _sentences(
    problem: PlanningTask, plan: PlanResult, goals: GoalStates, found: Diagnosis
) -> Iterator[str]:
    """Yield sentences about the findings, the most useful ones first."""
    if plan.status == "solved":
        yield "The plan was found and verified: nothing stopped it."
        return
    stiff, settings = found.stiffness, problem.scenario.integration
    if stiff is not None:
        yield stiff.sentence
    law = law_sentence(problem.model, settings, lambda: find_system(problem.scenario))
    if law:
        yield law
    if not goals.inside:
        yield from unmet_sentences(problem, goals.nearest)
    blocked = found.passage is not None and found.passage.blocked
    verdicts = list(verification_sentences(problem, plan)) if stiff is None else []
    if found.passage is not None and blocked:
        yield found.passage.sentence
    yield from unreached_sentences(found.unreached)
    yield from unmoved_sentences(found.unmoved)
    yield from holding_sentences(problem, found.start_held, found.goal_held)
    growing = growing_errors_sentence(problem, found.start_held)
    if growing:
        yield growing
    yield from verdicts
    yield from trial_sentences(found.retries)
    # Limits violated by unstable steps are not what stops the machine.
    limits = {LIMIT} if stiff is not None else set()
    told = {cause: of for cause, of in found.rejections.items() if cause not in limits}
    yield from rejection_sentences(told)
    moved = plan.trajectory is not None
    if moved or stiff is None:  # unstable steps make no valid approach, however near
        yield from approach_sentences(found.approach, moved=moved)
    yield from clearance_sentences(found.start_clearance, found.goal_clearance)
    if found.passage is not None and not blocked:
        yield found.passage.sentence
    causes = (stiff, law, growing, not goals.inside, blocked, found.unreached, found.unmoved)
    if not any((*causes, verdicts)) and not any(retry.solved for retry in found.retries):
        yield next_search_sentence(problem, plan)


def _plain(value: Any) -> Any:
    """Return nested data in JSON's types; what is not finite becomes null."""
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def next_search_sentence(problem: PlanningTask, plan: PlanResult) -> str:
    """Return which longer search, and which other planner, would be worth trying.

    Args:
        plan: Result of the search that failed.
    """
    section, seconds = problem.scenario.planner, plan.timings.get("search", 0.0)
    longer = f"--time-limit {math.ceil(LONGER * max(section.time_limit, seconds))}"
    most = section.max_iterations
    if most is not None and plan.iterations >= most:
        longer += f" --max-iterations {LONGER * most}"
    members = [member.name for member in MEMBERS]
    other = f"--planner {Auto.name}, in which {' and '.join(members)} take turns with shooting"
    if plan.planner == Auto.name:
        other = f"--planner {' or '.join(members)}, which then has all of the time"
    return (
        f"Nothing that was looked at rules a plan out: search longer than {seconds:.2g} s "
        f"({longer}), or with another planner ({other})."
    )

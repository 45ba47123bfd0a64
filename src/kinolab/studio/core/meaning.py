"""What a scenario's text means now: its problem, or what is wrong with it, and where."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from pathlib import Path

from kinolab.errors import EndpointError, InputError, KinolabError, Mistake
from kinolab.loading import built
from kinolab.problem import PlanningTask
from kinolab.scenario.load import check_document, toml_document
from kinolab.studio.core.scenario_text import FEWER

NO_GOAL = Mistake(
    "[goal]", "nothing says where the machine shall go.", "Ask for a coordinate, under Pose."
)


@dataclass(frozen=True, eq=False)
class ScenarioMeaning:
    """What a text means.

    Attributes:
        text: The text.
        problem: Its problem; where it has mistakes, that of the last text without any.
        mistakes: What is wrong with it, or with its start and goal.
        stale: Whether the problem is an earlier text's.
        touching: What touches at the start, by names of bodies and obstacles.
    """

    text: str
    problem: PlanningTask | None = None
    mistakes: tuple[Mistake, ...] = ()
    stale: bool = True
    touching: tuple[tuple[str, str], ...] = ()

    @property
    def ready(self) -> bool:
        """Whether it can be planned for."""
        return not self.mistakes and not self.stale


def meaning_of(text: str, path: Path, before: ScenarioMeaning | None = None) -> ScenarioMeaning:
    """Understand a text; nothing is raised, and the last good problem stays.

    Args:
        path: Of its file, below whose folder relative paths start.
        before: What the text before it meant.
    """
    former = None if before is None else before.problem
    try:
        with redirect_stdout(sys.stderr):  # code of users may print
            problem = built(*check_document(toml_document(text, path.name, FEWER), path))
    except InputError as error:
        return ScenarioMeaning(text, former, error.mistakes)
    except KinolabError as error:
        return ScenarioMeaning(text, former, (Mistake(path.name, str(error)),))
    return replace(_of_ends(problem), text=text)


def _of_ends(problem: PlanningTask) -> ScenarioMeaning:
    """Say what is wrong with start and goal of a problem."""
    contacts = problem.checker().contacts(*problem.placement(problem.start))
    touching = tuple((each.body, each.obstacle) for each in contacts)
    mistakes: tuple[Mistake, ...] = ()
    try:
        problem.check_endpoints()
    except EndpointError as error:
        mistakes = error.mistakes
    if not problem.asks:
        mistakes = (*mistakes, NO_GOAL)
    return ScenarioMeaning("", problem, mistakes, stale=False, touching=touching)

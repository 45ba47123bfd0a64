"""Search below a bound that falls: trees that are cheap to grow find shorter ways than the first.

The first motion of a search is often several times too long. Trees that keep nothing that would be
longer are small, and find in a second what takes trajectory optimisation ten; that then smooths
what they have found.

Source: Hauser, Zhou, Asymptotically optimal planning by feasible kinodynamic planning in a
state-cost space, IEEE Transactions on Robotics 32(6), 2016.
"""

from __future__ import annotations

from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner
from kinolab.search.tree import AbstractCompiledPlanner
from kinolab.trajopt.nlp.options import END

SHARE, PATIENCE = 0.25, 0.5  # of the improvement's work; of that, without a shorter motion
# The same where optimisation hardly shortens.
LARGE_SHARE, LARGE_PATIENCE = 0.75, 0.6
GUESSED_SHARE = 0.2  # of the work that is left, for guesses until one becomes a motion
HELD = ("min_steps", "max_steps")  # settings that hold for all trees of a scenario


def cost_bounded(problem: PlanningTask, searcher: AbstractPlanner) -> AbstractPlanner | None:
    """Return the planner that shortens by further trees what another one has found.

    Args:
        searcher: The planner whose motion is to be shortened.

    Returns:
        None if that one grows no compiled trees: a user who chose it may want to see its own ways.
    """
    if not isinstance(searcher, AbstractCompiledPlanner):
        return None
    # Cells say nothing of how far a gait has come; sparse trees, which compare costs, do better.
    name = "sst" if problem.machine.modes else "kpiece_fast"
    return planners.make(name, {setting: getattr(searcher, setting) for setting in HELD})


def guessing(problem: PlanningTask, searcher: AbstractPlanner) -> AbstractPlanner | None:
    """Return the planner that optimises guesses along paths shorter than the best motion.

    Trees that are not bounded find the widest way again and again, and bounded ones hardly squeeze
    through a narrow one. A path without dynamics does, and may become a motion.

    Args:
        searcher: The planner whose motion is to be shortened.

    Returns:
        None if that one makes no guesses, or none of them would become a motion in time.
    """
    if searcher.name != "auto" or problem.machine.modes or _hardly_optimised(problem):
        return None
    return planners.make("shooting", {})


def bounded_work(problem: PlanningTask, seconds: float) -> tuple[float, float]:
    """Return the work on these trees in [s], and that after which they end without any success.

    Args:
        seconds: Of work that the improvement may do.
    """
    large = LARGE_SHARE, LARGE_PATIENCE
    share, patience = large if _hardly_optimised(problem) else (SHARE, PATIENCE)
    return share * seconds, share * patience * seconds


def _hardly_optimised(problem: PlanningTask) -> bool:
    """Say whether optimisation hardly shortens: with very many states it takes too long."""
    return problem.model.nx >= END.many_states

"""Knots from which nothing is missing, near ones from which something is."""

from __future__ import annotations

from collections.abc import Callable

from kinolab.optimize.coarsening import closer
from kinolab.optimize.knots import Knots
from kinolab.optimize.restoration import restored
from kinolab.optimize.task import Task


def exact(
    task: Task,
    knots: Knots,
    late: Callable[[], bool],
    iterations: int = 40,
    *,
    held: bool = False,
) -> Knots | None:
    """Return knots near given ones from which nothing is missing; None where none are found.

    Steps keep their length where that is ``held`` and in discrete problems.
    """
    knots = closer(task, task.within_limits(knots), late)
    free = (0.5 * knots.h, max(task.problem.step, knots.h))
    lengths = None if held or task.discrete else free
    return restored(task, knots, late, iterations=iterations, lengths=lengths)

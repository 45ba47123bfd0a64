"""Goals that no motion from a start comes nearer to: all of them leave a coordinate as it is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.errors import KinolabError
from kinolab.problem import PlanningTask
from kinolab.problem.goal_entries import GoalEntry, goal_entries

MOTIONS, STEPS = 12, 100  # at random; a coordinate that stays in all of them is held


def unmoved_goals(problem: PlanningTask) -> tuple[GoalEntry, ...]:
    """Return the entries of a goal that are missed at the start, and do not change from there.

    Motions under random inputs are looked at: a pendulum that hangs at rest below a winch stays on
    the vertical, whatever the winch does, though its angle changes in all other motions.
    """
    model, generator = problem.model, np.random.default_rng(0)
    names = model.state_names
    missed = [e for e in goal_entries(problem, problem.start) if not e.reached and e.name in names]
    largest, spans = np.zeros(model.nx), np.full(STEPS, problem.step)
    settings, (lower, upper) = problem.scenario.integration, model.control_bounds.T
    for _ in range(MOTIONS if missed else 0):
        u = generator.uniform(lower, upper, (STEPS, model.nu))
        try:
            x = model.steps(
                problem.start, u, spans, method=settings.method, substeps=settings.substeps
            )
        except KinolabError:
            return ()  # it cannot be said where it leads
        largest = np.maximum(largest, np.abs(x - problem.start).max(axis=0))
    still = largest <= 1e-9 * problem.scales  # of its scale
    return tuple(entry for entry in missed if still[names.index(entry.name)])


def unmoved_sentences(entries: Sequence[GoalEntry]) -> Iterator[str]:
    """Say what no input moves from the start."""
    if entries:
        names = " and ".join(entry.name for entry in entries)
        stays = "stays where it is" if len(entries) == 1 else "stay where they are"
        yield (
            f"From this start {names} {stays} in all motions that were tried, whatever the inputs, "
            f"and the goal wants another value. Begin where that is different, such as "
            f"[start] {entries[0].name} = {entries[0].value + 0.1:.3g}."
        )

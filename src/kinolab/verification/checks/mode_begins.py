"""Check that a mode begins where its constraints on positions hold: nothing jumps into it."""

from __future__ import annotations

import numpy as np

from kinolab.verification.checks.check import Check, CheckContext, worst_entry


def transitions(context: CheckContext) -> Check | None:
    """Check h(q) where a mode begins; None of machines without such modes."""
    problem, motion = context.problem, context.motion
    machine, plant = problem.machine, problem.model.plant
    if not (machine.modes and machine.closes_loops):
        return None
    times, states, knots = motion.landings
    held = context.trajectory.u[knots]
    residual = np.abs(plant.constraint_residual(states, held)) if len(knots) else np.zeros((0, 0))

    def words(k: int, i: int) -> str:
        mode = machine.modes[int(states[k, -1])]
        return (
            f"at t = {times[k]:.6g} s the mode {mode} begins where {plant.residual_names[i]} does "
            "not hold, and what it holds would jump there: let the transition's until or provided "
            "wait for it, or its reset set it"
        )

    # [m] or [rad]: between two knots, at which drift is mended, positions drift by less
    return worst_entry("transitions", residual, 1e-6, words)

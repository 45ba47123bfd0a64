"""Do the stored knots keep the machine's constraints?"""

from __future__ import annotations

import numpy as np

from kinolab.dynamics.analysis.consistent_states import CONSTRAINT_TOLERANCE
from kinolab.verification.check import Check, CheckContext, worst_entry


def constraints(context: CheckContext) -> Check:
    """Check w(q) q_dot and h(q) at every knot, under the inputs that are held from it on."""
    problem, trajectory = context.problem, context.trajectory
    plant, u, residual = problem.model.plant, trajectory.u, np.zeros((0, 0))
    if problem.system.constraints and len(u):
        held = np.vstack([u, u[-1:]])
        residual = np.abs(plant.constraint_residual(trajectory.x, held))

    def words(k: int, i: int) -> str:
        return f"at t = {trajectory.t[k]:.6g} s {plant.residual_names[i]} is broken"

    return worst_entry("constraints", residual, CONSTRAINT_TOLERANCE, words)

"""Driftless machines: their inputs are velocities, and without inputs they stand."""

from __future__ import annotations

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.trajopt.nlp.dynamics_constraint import is_discrete


def is_driftless(problem: PlanningTask) -> bool:
    """Say whether a machine's inputs are velocities within limits, and it stands without them."""
    model = problem.model
    return bool(
        not (model.nv or problem.machine.states or problem.machine.modes)
        and model.plant is model
        and model.nu
        and not is_discrete(problem)
        and np.isfinite(model.control_bounds).all()
        and not model.f(problem.start, model.null_control()).any()
    )

"""Do errors grow faster than a machine can move?

What is computed beforehand then cannot be repeated, however long one searches.
"""

from __future__ import annotations

import math

import numpy as np

from kinolab.errors import KinolabError
from kinolab.problem import PlanningTask
from kinolab.problem.static_holding import StaticHolding
from kinolab.scenario.values import ROBOT_FORMATS
from kinolab.simulation.reference import MAX_ERROR_AMPLIFICATION


def growing_errors_sentence(problem: PlanningTask, start: StaticHolding | None) -> str:
    """Say that errors grow too much on any way into the goal; nothing where they do not.

    They grow as where the machine is held at the start, for the least time of the straight way.

    Args:
        start: How inputs hold the machine at its start.
    """
    from kinolab.trajopt.multistart.guesses import Guesses  # late: only where a search fails

    if start is None or not start.holds or problem.machine.modes:
        return ""
    guesses = Guesses(problem, np.random.default_rng(0))
    try:
        slope = problem.model.jacobian(problem.start, np.array([*start.inputs.values()]))[0]
        least = guesses.quickest(guesses.straight())
    except KinolabError:
        return ""
    rate = float(np.linalg.eigvals(slope).real.max(initial=0.0))
    if rate * least <= math.log(MAX_ERROR_AMPLIFICATION):
        return ""
    remedy = "or give it a law (System(..., feedback=...))"
    if str(problem.scenario.system.file).endswith(ROBOT_FORMATS):
        remedy = "or plan for its speeds (kinematic = true below [system])"
    return (
        f"Small errors grow e-fold within {1.0 / rate:.2g} s where it starts, and the way takes "
        f"{least:.2g} s at least: no inputs that are computed beforehand lead there twice. Let it "
        f"move faster ([bounds]), {remedy}."
    )

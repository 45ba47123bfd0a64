"""How far one step of the planner's integrator errs, and which steps would not.

Too coarse a step is no mistake of the plan: what is verified is the reference motion. But what
the planner expects of an input and what the input does differ, and the search pays for it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.codegen.methods import METHODS
from kinolab.dynamics.model.units import state_units
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.stability import fastest_rate
from kinolab.trajectory import Trajectory

TOLERATED = 1e-3  # error of one step, of a state's scale
REFINEMENTS = (2, 4, 8, 16, 32, 64)  # factors by which substeps are multiplied


@dataclass(frozen=True)
class StepError:
    """The largest error of one step along a motion.

    Attributes:
        share: Of the entry that errs most, over one propagation step, as a share of its scale.
        substeps: A number that keeps the share tolerable and is stable; None if none was found.
        other: Another method that does so at the present step; empty if there is none.
        sentence: What errs, by how much, and what would not.
    """

    share: float
    substeps: int | None
    other: str
    sentence: str


def step_error(problem: PlanningTask, motion: Trajectory) -> StepError | None:
    """Return the largest error of the planner's steps along a motion; None where it is tolerable.

    Each step is made from a state of the reference motion and compared with where that goes. None,
    too, where the steps themselves are what counts as true.

    Args:
        problem: Provides the machine and the integration settings.
        motion: A reference motion with the planner's own steps as intervals.
    """
    settings = problem.scenario.integration
    if settings.truth == "discrete" or not len(motion.u):
        return None
    errors = _errors(problem, motion, settings.method, settings.substeps)
    if errors is None or not (worst := float(errors.max())) > TOLERATED:
        return None
    k = int(np.unravel_index(errors.argmax(), errors.shape)[1])
    step = settings.step / settings.substeps
    rate = fastest_rate(problem.model)  # shorter steps must be stable wherever it moves, too
    stable = math.ceil(settings.step * rate / METHODS[settings.method].stability)
    counts = sorted({max(stable, settings.substeps * factor) for factor in REFINEMENTS})
    substeps = next((n for n in counts if _fine(problem, motion, settings.method, n)), None)
    cures = []
    if substeps is not None:
        cures.append(f"substeps = {substeps} (steps of {settings.step / substeps:.3g} s)")
    others = (name for name, m in METHODS.items() if rate * step <= m.stability)
    others = (name for name in others if name != settings.method)
    other = next((one for one in others if _fine(problem, motion, one, settings.substeps)), "")
    if other:
        cures.append(f'method = "{other}"')
    size = f"{worst * problem.scales[k]:.2g} {state_units(problem.model)[k]}".rstrip()
    cure = f"[integration] {' or '.join(cures)} would not." if cures else "Take shorter steps."
    sentence = (
        f"The search's steps of {step:.3g} s by {settings.method} err by up to {size} in "
        f"{problem.model.state_names[k]} each, {worst:.2g} of its scale. {cure}"
    )
    return StepError(worst, substeps, other, sentence)


def _fine(problem: PlanningTask, motion: Trajectory, method: str, substeps: int) -> bool:
    """Whether a method errs tolerably with a number of substeps."""
    errors = _errors(problem, motion, method, substeps)
    return errors is not None and bool(errors.max() <= TOLERATED)


def _errors(problem: PlanningTask, motion: Trajectory, method: str, substeps: int) -> Array | None:
    """Return the errors of all steps as shares of the scales, shape (N, nx); None if one fails."""
    model, begin, end = problem.model, motion.x[:-1], motion.x[1:]
    try:
        reached = model.step(
            begin, motion.inputs, np.diff(motion.t), method=method, substeps=substeps
        )
    except KinolabError:
        return None
    errors: Array = np.abs(model.space.difference(reached, end)) / problem.scales
    return errors if np.isfinite(errors).all() else None

"""What a plan keeps back, so that feedback can correct what is uncertain.

Source: Chisci, Rossiter, Zappa, Systems with persistent disturbances: predictive control with
restricted constraints, Automatica 37(7), 2001 (limits less what feedback needs).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinolab import loading
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.tube.proof import Prover
from kinolab.verification.tube.reachability import Tube
from kinolab.verification.tube.tube_poses import TubePoses
from kinolab.verification.tube.uncertainty import Uncertainty


@dataclass(frozen=True)
class Reserves:
    """What a plan keeps back.

    Attributes:
        inputs: Of each input's limits, by name.
        states: Of each coordinate's limits, by name.
        distance: Of limits of the workspace and from obstacles, in [m].
    """

    inputs: dict[str, float] = field(default_factory=dict)
    states: dict[str, float] = field(default_factory=dict)
    distance: float = 0.0

    def joined(self, other: Reserves) -> Reserves:
        """Return the larger of each."""

        def larger(a: dict[str, float], b: dict[str, float]) -> dict[str, float]:
            return {name: max(a.get(name, 0.0), b.get(name, 0.0)) for name in a | b}

        distance = max(self.distance, other.distance)
        inputs, states = larger(self.inputs, other.inputs), larger(self.states, other.states)
        return Reserves(inputs, states, distance)

    def kept(self, problem: PlanningTask) -> PlanningTask:
        """Return the problem in which so much is kept back.

        Raises:
            InputError: If nothing is left.
        """
        scenario, whole = problem.scenario, problem.whole or problem.model
        values: dict[str, object] = {}
        limits = dict(zip(whole.control_names, whole.control_bounds.tolist(), strict=True))
        limits |= dict(zip(whole.state_names, whole.state_bounds.tolist(), strict=True))
        for name, reserve in (self.inputs | self.states).items():
            low, high = limits[name]
            own = scenario.bounds.get(name, (low, high))
            values[f"bounds.{name}"] = [max(own[0], low + reserve), min(own[1], high - reserve)]
        if self.distance:
            values["world.clearance"] = scenario.world.clearance + self.distance
        for axis, (low, high) in scenario.world.bounds.items():
            values[f"world.bounds.{axis}"] = [low + self.distance, high - self.distance]
        return loading.built(*loading.read_changed(scenario, values)) if values else problem


def needed(prover: Prover, expected: Tube, uncertainty: Uncertainty, factor: float) -> Reserves:
    """Return what a plan needs, a factor larger than the linear part of its tube says.

    Args:
        expected: The linear part of its tube.
        uncertainty: Under which.
        factor: At least 1.
    """
    problem = prover.problem
    model = problem.whole or problem.model
    half = 0.5 * np.ptp(model.control_bounds, axis=1)
    # of half an input's range that is kept back at most: plans with less are hardly motions
    inputs = np.minimum(factor * input_needs(expected), 0.6 * half)
    poses = TubePoses.of(problem, prover.about, expected, uncertainty.radii(problem))
    off = factor * poses.displacements(problem)
    bounds = expected.bounds
    states = factor * np.maximum(-bounds.low, bounds.high).max(axis=0)
    limited = np.isfinite(model.state_bounds).all(axis=1) & ~problem.circular
    limited[model.speeds] = False
    at = np.minimum(_clearances(prover), 1e6)  # [m]: nothing is as far off as that
    most = off.max(axis=0)
    short = np.vstack([off, most]) - at
    wanted = np.where(short > 0.0, at.min(axis=0) + short, 0.0)  # of the whole machine
    return Reserves(
        dict(zip(model.control_names, inputs.tolist(), strict=True)),
        {model.state_names[i]: float(states[i]) for i in np.flatnonzero(limited)},
        float(wanted.max(initial=0.0)),
    )


def input_needs(tube: Tube) -> Array:
    """Return how far inputs are from the planned ones at most, shape (nu,)."""
    most = np.max([np.maximum(-one.low, one.high) for one in tube.inputs], axis=0)
    return np.asarray(np.where(np.isnan(most), np.inf, most))


def _clearances(prover: Prover) -> Array:
    """Return the clearances of the plan in each step, at its ends, as ``ContactSearch`` does."""
    at = prover.contacts.clearances(prover.about.nominal.x)
    return np.asarray(np.minimum(at[:, 1:], at[:, :-1]))

"""What a scenario says of each entry of a state, in arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics import Model
from kinolab.dynamics.facts.machine_facts import members
from kinolab.numerics.arrays import Array
from kinolab.scenario import Scenario


class StateArrays(NamedTuple):
    """Limits, weights and topology of a problem, as ``PlanningTask`` names them."""

    bounds: Array  # (nx, 2)
    rate_bounds: Array  # (nt, 2)
    weights: Array  # (nx,)
    circular: NDArray[np.bool_]  # (nx,)


def state_arrays(scenario: Scenario, model: Model) -> StateArrays:
    """Gather what a scenario and its machine say; names that nothing has are left out."""
    limited = np.array([name in scenario.bounds for name in model.state_names])
    return StateArrays(
        _bounds(scenario, model),
        _rate_bounds(scenario, model),
        _weights(scenario, model),
        model.circular & ~limited,  # an angle that the scenario limits does not come round
    )


def _bounds(scenario: Scenario, model: Model) -> Array:
    """Intersect the machine's limits with the scenario's and, for positions, the world's.

    Unit vectors have none: their length is 1 but for rounding.
    """
    bounds = model.state_bounds.copy()
    for part in model.space.spheres:
        bounds[part.own] = -np.inf, np.inf
    lengths = {c.name for c in model.machine.coordinates if c.unit == "m"}
    workspace = {
        name: given
        for axis, given in scenario.world.bounds.items()
        for name in (axis, *(f"{machine}_{axis}" for machine in members(model.machine.name)))
        if name in lengths
    }
    for limits in (scenario.bounds, workspace):
        for i, name in enumerate(model.state_names):
            lower, upper = limits.get(name, (-np.inf, np.inf))
            bounds[i] = max(bounds[i, 0], lower), min(bounds[i, 1], upper)
    return bounds


def _rate_bounds(scenario: Scenario, model: Model) -> Array:
    """Limit the rates that follow from others; those of the state have theirs there."""
    bounds = np.tile([-np.inf, np.inf], (model.nt, 1))
    speeds = [c.speed for c in model.machine.coordinates for _ in c.rates]
    for i, (name, speed) in enumerate(zip(model.rate_names, speeds, strict=True)):
        if name not in model.state_names:
            lower, upper = scenario.bounds.get(name, (-np.inf, np.inf))
            bounds[i] = max(-speed, lower), min(speed, upper)
    return bounds


def _weights(scenario: Scenario, model: Model) -> Array:
    """Return what differences are multiplied by: [metric], else one over the scale."""
    weights: Array = 1 / model.state_scales
    spheres = {part.name: part.own for part in model.space.spheres}
    for name, weight in scenario.metric.items():
        if name in model.state_names:
            weights[model.state_names.index(name)] = weight
        elif name in spheres:
            weights[spheres[name]] = weight
    return weights

"""Velocity directions that no input changes, by controllability of linearisations.

Source: Kalman, Ho, Narendra, Controllability of linear dynamical systems, Contributions to
Differential Equations 1(2), 1963.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import scipy

from kinolab.dynamics.analysis.fields.linear_controllability import reachable_subspace
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

RANDOM_STATES = 12  # random samples; a direction unreached at all of them is never reached
RANK_TOLERANCE = 1e-7  # of the largest singular value: smaller ones count as zero


def unreached_directions(problem: PlanningTask) -> tuple[dict[str, float], ...]:
    """Return the directions of velocity that no input changes, as components by name.

    A direction counts if it is uncontrollable in the linearisations at all of several random states
    and inputs, and no constraint keeps it at zero. A kinematic machine has none.
    """
    names = problem.model.state_names
    rates = list(range(problem.model.nq, problem.model.nq + problem.model.nv))
    generator, model = np.random.default_rng(0), problem.model
    parts, held = [], np.zeros((len(rates), len(rates)))
    for k in range(RANDOM_STATES):
        x = problem.sample(generator)
        if modes := len(model.machine.modes):
            x[-1] = k % modes
        x = model.project(x)
        u = np.asarray(generator.uniform(*model.control_bounds.T))
        parts.append(_reached(problem, x, u)[rates])
        held += _held(problem, x, rates) / RANDOM_STATES
    parts = [part for part in parts if part.size]
    if not rates or not parts:
        return ()
    missing = scipy.linalg.null_space(np.concatenate(parts, axis=1).T, RANK_TOLERANCE)
    # What constraints keep at zero everywhere is no surprise: there the mean projection is 1.
    shares, turned = np.linalg.eigh(missing.T @ held @ missing)
    missing = missing @ turned[:, shares < 1.0 - RANK_TOLERANCE]
    return tuple(
        {
            names[i]: float(value)
            for i, value in zip(rates, z, strict=True)
            if abs(value) > 1e-3  # smaller components are left out of a direction
        }
        for z in missing.T
    )


def unreached_sentences(directions: Sequence[dict[str, float]]) -> Iterator[str]:
    """Say which velocities no input changes."""
    for direction in directions:
        name = max(direction, key=lambda key: abs(direction[key]))
        # 0.999: component of a unit vector beyond which it stands for one velocity alone
        if abs(direction[name]) < 0.999:
            name = " ".join(f"{value:+.2g} {key}" for key, value in direction.items())
        yield f"No input ever changes {name}."


def _held(problem: PlanningTask, x: Array, rates: Sequence[int]) -> Array:
    """Return the projection onto the rates that constraints keep at zero, shape (nv, nv)."""
    plant = problem.model.plant
    if not plant.machine.all_rates:
        return np.zeros((len(rates), len(rates)))  # the others follow from those that are states
    still = np.array(x)
    still[list(rates)] = 0.0
    moved = still + np.eye(len(x))[list(rates)] * problem.scales[list(rates), None]
    slips = (plant.constraint_residual(moved) - plant.constraint_residual(still)).T
    return np.asarray(np.linalg.pinv(slips, rcond=RANK_TOLERANCE) @ slips)


def _reached(problem: PlanningTask, x: Array, u: Array) -> Array:
    """Return a basis of the controllable subspace of a linearisation, shape (nx, rank)."""
    model, scales = problem.model, problem.scales
    try:
        A, B = model.jacobian(x, u)
    except KinolabError:
        return np.zeros((model.nx, 0))
    strength = np.ptp(model.control_bounds, axis=1) / 2
    A, B = A * scales / scales[:, None], B * strength / scales[:, None]
    if not (np.isfinite(A).all() and np.isfinite(B).all()):
        return np.zeros((model.nx, 0))
    return reachable_subspace(A, B, RANK_TOLERANCE)

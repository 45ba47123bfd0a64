"""Leading bodies: the bodies guided to the goal, and the length coordinates that move them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.world import BodyGeometry, triangles


@dataclass(frozen=True, eq=False)
class LeadingBody:
    """A body that others follow, or that follows no other.

    Attributes:
        body: Its index.
        lengths: Entries of the state that move it, each a coordinate in [m].
        centre: Centre of its bounding box in its own frame, in [m], shape (3,).
        reach: Half extents along its axes, in [m], shape (3,).
    """

    body: int
    lengths: tuple[int, ...]
    centre: Array
    reach: Array


def leading_bodies(problem: PlanningTask) -> list[LeadingBody]:
    """Return the leading bodies: those whose lengths are no subset of another body's.

    A crane's load leads its trolley and its bridge. Of bodies moved by the same lengths the first
    in the system leads. If no length moves any body, as in an arm, all lead.
    """
    states = sample_states(problem, 24)  # sampled configurations
    found = [
        LeadingBody(k, _lengths_of(problem, k, states[:3]), *_extent(body))
        for k, body in enumerate(problem.bodies)
        if body.shapes
    ]
    found.sort(key=lambda c: -len(c.lengths))  # keeps the system's order
    kept: list[LeadingBody] = []
    for carrier in found:
        if not any(set(carrier.lengths) <= set(other.lengths) for other in kept if other.lengths):
            kept.append(carrier)
    return kept


def sample_states(problem: PlanningTask, count: int) -> Array:
    """Sample states with configurations uniform within limits, shape (count, nx)."""
    generator, nq = np.random.default_rng(0), problem.model.nq
    states = np.tile(problem.start, (count, 1))
    lower, upper = problem.sampling_bounds[:nq].T
    states[:, :nq] = generator.uniform(lower, upper, size=(count, nq))
    for part in problem.space.spheres:
        states[:, part.own] = [part.random(generator) for _ in range(count)]
    return problem.model.project(states)


def _lengths_of(problem: PlanningTask, body: int, states: Array) -> tuple[int, ...]:
    """Return the entries of the state that are coordinates in [m] and move a body."""
    found, names = [], problem.model.state_names
    for entry in [names.index(c.name) for c in problem.machine.coordinates if c.unit == "m"]:
        moved = states.copy()
        moved[:, entry] += 1.0
        shift = (problem.frames(moved) - problem.frames(states))[:, body]
        # [m] displacement from which a point counts as moved
        if np.abs(shift[:, [3, 7, 11]]).max() > 1e-6:
            found.append(entry)
    return tuple(found)


def _extent(body: BodyGeometry) -> tuple[Array, Array]:
    corners = np.concatenate([triangles(shape)[0] for shape in body.shapes])
    low, high = corners.min(axis=0), corners.max(axis=0)
    return (low + high) / 2, (high - low) / 2

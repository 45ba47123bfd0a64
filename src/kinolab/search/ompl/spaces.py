"""OMPL state and control spaces from topologies, limits and weights."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import singledispatch
from itertools import groupby
from typing import Any, TypeAlias

import numpy as np
from ompl import base as ob
from ompl import control as oc

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.state_parts import (
    Circle,
    Part,
    RealLine,
    Rotations,
    UnitSphere,
    spheres_of,
)
from kinolab.problem import PlanningTask

Subspace: TypeAlias = tuple[Any, float, Callable[[Any, Sequence[int], Any], None]]


class Layout:
    """Maps entries of the state to subspaces; it does not refer to the whole space.

    Args:
        entries: Entries in the space, in increasing order; the others stay as at the start. All of
            them when left out.
    """

    def __init__(self, problem: PlanningTask, entries: Sequence[int] | None = None) -> None:
        self._start = problem.start.tolist()
        groups = _groups(problem, range(problem.model.nx) if entries is None else entries)
        self._groups = [
            (p, own, *subspace(p, problem.sampling_bounds[list(own)])) for p, own in groups
        ]

    def read(self, state: Any) -> list[float]:
        """Return the entries of an OMPL state in the machine's order."""
        values: list[float] = self._start.copy()
        for k, (_, own, _, _, read) in enumerate(self._groups):
            read(state[k], own, values)
        return values


class StateCodec(Layout):
    """The compound state space of a problem, and conversion to and from its states.

    Attributes:
        space: One subspace per circle, one per sphere, and one per run of adjacent real entries
            of equal weight.
    """

    def __init__(self, problem: PlanningTask, entries: Sequence[int] | None = None) -> None:
        super().__init__(problem, entries)
        self._order = [entry for _, own, *_ in self._groups for entry in own]
        parts = [part for part, *_ in self._groups]
        self._circles = [part.first for part in parts if isinstance(part, Circle)]
        self._spheres = [part.own for part in spheres_of(parts)]
        self.space = ob.CompoundStateSpace()
        for _, own, space, factor, _ in self._groups:
            self.space.addSubspace(space, factor * float(problem.weights[own[0]]))
        self.space.lock()
        self.space.setup()

    def write(self, state: Any, values: Sequence[float]) -> None:
        """Set an OMPL state from entries in the machine's order.

        Angles are wrapped and unit vectors normalised.
        """
        whole = list(values)
        for entry in self._circles:
            whole[entry] = float(wrapped(whole[entry]))
        for own in self._spheres:
            length = math.sqrt(sum(q * q for q in whole[own]))
            whole[own] = [q / length for q in whole[own]]
        self.space.copyFromReals(state, [whole[entry] for entry in self._order])


def control_space(problem: PlanningTask, states: StateCodec) -> Any:
    """Return the control space, a box given by the input limits."""
    bounds = ob.RealVectorBounds(problem.model.nu)
    for i, (lower, upper) in enumerate(problem.model.control_bounds):
        bounds.setLow(i, float(lower))
        bounds.setHigh(i, float(upper))
    space = oc.RealVectorControlSpace(states.space, problem.model.nu)
    space.setBounds(bounds)
    return space


def _groups(problem: PlanningTask, chosen: Sequence[int]) -> list[tuple[Part, tuple[int, ...]]]:
    """Group adjacent entries of the state: lines by equal weight, other parts by themselves."""
    owners = problem.space.owners

    def key(i: int) -> tuple[Part, float]:
        line = isinstance(owners[i], RealLine)
        return (RealLine("", 0), float(problem.weights[i])) if line else (owners[i], 0.0)

    return [(part, tuple(entries)) for (part, _), entries in groupby(chosen, key)]


@singledispatch
def subspace(_: Part, bounds: Array) -> Subspace:
    """Return OMPL's space of a part, or of several lines.

    Args:
        bounds: Limits of its entries, shape (n, 2).

    Returns:
        The space, the part's distance as a multiple of OMPL's, and what writes a state of it into
        some entries of another one.
    """
    limits = ob.RealVectorBounds(len(bounds))
    for k, (lower, upper) in enumerate(bounds.tolist()):
        limits.setLow(k, lower)
        limits.setHigh(k, upper)
    space = ob.RealVectorStateSpace(len(bounds))
    space.setBounds(limits)
    return space, 1.0, _read_line


@subspace.register
def _(_: Circle, bounds: Array) -> Subspace:  # noqa: ARG001
    return ob.SO2StateSpace(), 1.0, _read_circle


@subspace.register
def _(_: UnitSphere, bounds: Array) -> Subspace:
    """Return the cube around the sphere, to which steps return."""
    return subspace(RealLine("", 0), np.tile([-1.0, 1.0], (len(bounds), 1)))


@subspace.register
def _(_: Rotations, bounds: Array) -> Subspace:  # noqa: ARG001
    """OMPL's distance of two attitudes is half the angle between them."""
    return ob.SO3StateSpace(), 2.0, _read_rotation


def _read_line(state: Any, entries: Sequence[int], values: Any) -> None:
    for k, entry in enumerate(entries):
        values[entry] = state[k]


def _read_circle(state: Any, entries: Sequence[int], values: Any) -> None:
    values[entries[0]] = state.value


def _read_rotation(q: Any, entries: Sequence[int], values: Any) -> None:
    values[entries[0] : entries[0] + 4] = q.x, q.y, q.z, q.w

"""OMPL state and control spaces from topologies, limits and weights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto
from itertools import groupby
from typing import Any

from ompl import base as ob
from ompl import control as oc

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.problem import PlanningTask


class SpaceKind(Enum):
    """Topology of a subspace."""

    LINE = auto()
    CIRCLE = auto()
    ATTITUDE = auto()


@dataclass(frozen=True)
class Part:
    """A subspace and its entries of the state."""

    kind: SpaceKind
    entries: tuple[int, ...]


class Layout:
    """Maps entries of the state to subspaces; it does not refer to the space itself.

    Args:
        problem: The planning problem.
        entries: Entries in the space, in increasing order; the others stay as at the start. All of
            them when left out.
    """

    def __init__(self, problem: PlanningTask, entries: Sequence[int] | None = None) -> None:
        self._start = problem.start.tolist()
        self._parts = _parts(problem, range(problem.model.nx) if entries is None else entries)

    def read(self, state: Any) -> list[float]:
        """Return the entries of an OMPL state in the machine's order."""
        values: list[float] = self._start.copy()
        for k, part in enumerate(self._parts):
            substate, first = state[k], part.entries[0]
            if part.kind is SpaceKind.CIRCLE:
                values[first] = substate.value
            elif part.kind is SpaceKind.ATTITUDE:
                values[first : first + 4] = substate.x, substate.y, substate.z, substate.w
            else:
                for i, entry in enumerate(part.entries):
                    values[entry] = substate[i]
        return values


class StateCodec(Layout):
    """The compound state space of a problem, and conversion to and from its states.

    Attributes:
        space: One subspace per circle, one per attitude, and one per run of adjacent real entries
            of equal weight.
    """

    def __init__(self, problem: PlanningTask, entries: Sequence[int] | None = None) -> None:
        super().__init__(problem, entries)
        self._order = [entry for part in self._parts for entry in part.entries]
        self._circles = [p.entries[0] for p in self._parts if p.kind is SpaceKind.CIRCLE]
        self._attitudes = [p.entries[0] for p in self._parts if p.kind is SpaceKind.ATTITUDE]
        self.space = ob.CompoundStateSpace()
        for part in self._parts:
            self.space.addSubspace(_subspace(problem, part), _weight(problem, part))
        self.space.lock()
        self.space.setup()

    def write(self, state: Any, values: Sequence[float]) -> None:
        """Set an OMPL state from entries in the machine's order.

        Angles are wrapped and quaternions normalised.
        """
        whole = list(values)
        for entry in self._circles:
            whole[entry] = float(wrapped(whole[entry]))
        for first in self._attitudes:
            quaternion = whole[first : first + 4]
            length = math.sqrt(sum(q * q for q in quaternion))
            whole[first : first + 4] = [q / length for q in quaternion]
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


def _parts(problem: PlanningTask, chosen: Sequence[int]) -> list[Part]:
    """Group adjacent entries of the state: circles alone, real entries by equal weight."""
    owner = {first + k: name for name, first in problem.model.attitudes.items() for k in range(4)}

    def key(i: int) -> tuple[SpaceKind, object]:
        if i in owner:
            return SpaceKind.ATTITUDE, owner[i]
        return (
            (SpaceKind.CIRCLE, i)
            if problem.circular[i]
            else (SpaceKind.LINE, float(problem.weights[i]))
        )

    groups = groupby(chosen, key)
    return [Part(kind, tuple(entries)) for (kind, _), entries in groups]


def _weight(problem: PlanningTask, part: Part) -> float:
    """Return the weight of a subspace in OMPL's distance.

    OMPL's distance of two attitudes is half the angle between them.
    """
    weight = float(problem.weights[part.entries[0]])
    return 2 * weight if part.kind is SpaceKind.ATTITUDE else weight


def _subspace(problem: PlanningTask, part: Part) -> Any:
    if part.kind is SpaceKind.CIRCLE:
        return ob.SO2StateSpace()
    if part.kind is SpaceKind.ATTITUDE:
        return ob.SO3StateSpace()
    bounds = ob.RealVectorBounds(len(part.entries))
    for k, entry in enumerate(part.entries):
        bounds.setLow(k, float(problem.bounds[entry, 0]))
        bounds.setHigh(k, float(problem.bounds[entry, 1]))
    space = ob.RealVectorStateSpace(len(part.entries))
    space.setBounds(bounds)
    return space

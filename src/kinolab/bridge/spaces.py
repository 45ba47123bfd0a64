"""State and control spaces from topologies, limits and weights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import Any

from ompl import base as ob
from ompl import control as oc

from kinolab.problem import Problem


class States:
    """The compound state space of a problem, and the way into and out of its states.

    Attributes:
        space: One subspace per circle, and one per run of neighbours on the line of one weight.
    """

    def __init__(self, problem: Problem) -> None:
        self._size = problem.model.nx
        self._parts = _runs(problem)
        self._order = [(entry, circle) for entries, circle in self._parts for entry in entries]
        self.space = ob.CompoundStateSpace()
        for entries, circle in self._parts:
            weight = float(problem.weights[entries[0]])
            self.space.addSubspace(_subspace(problem, entries, circle), weight)
        self.space.lock()
        self.space.setup()

    def read(self, state: Any) -> list[float]:
        """Return the entries of an OMPL state in the machine's order."""
        values = [0.0] * self._size
        for part, (entries, circle) in enumerate(self._parts):
            substate = state[part]
            if circle:
                values[entries[0]] = substate.value
            else:
                for k, entry in enumerate(entries):
                    values[entry] = substate[k]
        return values

    def write(self, state: Any, values: Sequence[float]) -> None:
        """Set an OMPL state from entries in the machine's order; angles are wrapped."""
        reals = [_wrap(values[entry]) if circle else values[entry] for entry, circle in self._order]
        self.space.copyFromReals(state, reals)


def control_space(problem: Problem, states: States) -> Any:
    """Return the box of inputs within their limits."""
    bounds = ob.RealVectorBounds(problem.model.nu)
    for i, (lower, upper) in enumerate(problem.model.control_bounds):
        bounds.setLow(i, float(lower))
        bounds.setHigh(i, float(upper))
    space = oc.RealVectorControlSpace(states.space, problem.model.nu)
    space.setBounds(bounds)
    return space


def _runs(problem: Problem) -> list[tuple[list[int], bool]]:
    """Group neighbouring entries of the state: circles alone, lines by equal weight."""

    def kind(i: int) -> tuple[int, float]:
        return (i if problem.circular[i] else -1, float(problem.weights[i]))

    groups = groupby(range(problem.model.nx), kind)
    return [(list(entries), circle >= 0) for (circle, _), entries in groups]


def _subspace(problem: Problem, entries: list[int], circle: bool) -> Any:
    if circle:
        return ob.SO2StateSpace()
    bounds = ob.RealVectorBounds(len(entries))
    for k, entry in enumerate(entries):
        bounds.setLow(k, float(problem.bounds[entry, 0]))
        bounds.setHigh(k, float(problem.bounds[entry, 1]))
    space = ob.RealVectorStateSpace(len(entries))
    space.setBounds(bounds)
    return space


def _wrap(angle: float) -> float:
    """Return an angle in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi

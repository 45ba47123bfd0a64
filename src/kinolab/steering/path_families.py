"""Which ways a machine knows from one place to another."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from kinolab.dynamics.language.flatness import FlatOutputs, PlaneCurves
from kinolab.dynamics.language.symbols import Coordinate
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.flat_outputs import FlatOutputPaths
from kinolab.steering.path_motion import Path
from kinolab.steering.plane_curves import PlanePaths


class StraightLines:
    """Straight lines, which a machine may or may not be able to follow; attitudes know none.

    Attributes:
        coordinates: What the paths give.
    """

    def __init__(self, problem: PlanningTask) -> None:
        coordinates = problem.system.coordinates
        self.coordinates = tuple(c for c in coordinates if isinstance(c, Coordinate))
        self._can = len(self.coordinates) == len(coordinates)
        self._nq = problem.model.nq

    def detours(self, x0: Array, x1: Array) -> Iterator[list[Path]]:  # noqa: ARG002
        """Yield nothing: there are no others."""
        yield from ()

    def straightened(self, x: Array) -> Array:
        """Return the state as it is: nothing is steered."""
        return x

    def paths(self, x0: Array, x1: Array) -> Iterator[list[Path]]:
        """Yield the straight way from x0 to x1, both at rest."""
        begin, path = x0[: self._nq], (x1 - x0)[: self._nq]
        if self._can and np.abs(path).max(initial=0.0) > 0:
            yield [lambda fraction, _rate, _slope: begin + fraction[:, None] * path]


class PathFamily(Protocol):
    """Ways from rest to rest."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """What the paths give."""

    def paths(self, x0: Array, x1: Array) -> Iterator[list[Path]]:
        """Yield lists of paths from x0 to x1; the machine stops at the end of each path."""

    def detours(self, x0: Array, x1: Array) -> Iterator[list[Path]]:
        """Yield longer ways, for where none of the others is free."""

    def straightened(self, x: Array) -> Array:
        """Return a state whose steering stands straight, where a machine has any."""


def path_family(problem: PlanningTask) -> PathFamily:
    """Return the ways of a machine: those of its flat map, or straight lines."""
    match problem.system.flat:
        case PlaneCurves() as flat:
            return PlanePaths(problem, flat)
        case FlatOutputs() as flat:
            return FlatOutputPaths(problem, flat)
    return StraightLines(problem)

"""Path families: the kinds of paths that a machine can be steered along."""

from __future__ import annotations

from collections.abc import Iterator
from typing import final

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.flat_outputs import FlatOutputPaths
from kinolab.steering.path_motion import AbstractPathFamily, Path
from kinolab.steering.plane_curves import PlanePaths


@final
class StraightLines(AbstractPathFamily):
    """Straight lines, which a machine may be unable to follow; none for attitudes."""

    def __init__(self, problem: PlanningTask) -> None:
        coordinates = problem.machine.coordinates
        self.coordinates = tuple(c.name for c in coordinates if len(c.entries) == 1)
        self._can = len(self.coordinates) == len(coordinates)
        self._nq = problem.model.nq

    def paths(self, x0: Array, x1: Array) -> Iterator[list[Path]]:
        """Yield the straight path from x0 to x1, both at rest, shape (nx,)."""
        begin, path = x0[: self._nq], (x1 - x0)[: self._nq]
        if self._can and np.abs(path).max(initial=0.0) > 0:
            yield [lambda fraction, _rate, _slope: begin + fraction[:, None] * path]


def path_family(problem: PlanningTask) -> AbstractPathFamily:
    """Return the machine's path family: that of its flat map, or straight lines."""
    flat = problem.machine.flat
    if flat is None:
        return StraightLines(problem)
    if flat.plane_curves:
        return PlanePaths(problem, flat)
    return FlatOutputPaths(problem, flat)

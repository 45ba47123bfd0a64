"""Path families: the kinds of paths that a machine can be steered along."""

from __future__ import annotations

from collections.abc import Iterator
from typing import final

import numpy as np

from kinolab.dynamics.facts.machine_facts import FlatFacts
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
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


@final
class FlatOutputPaths(AbstractPathFamily):
    """Paths along straight lines of the flat outputs.

    Source: Fliess, Levine, Martin, Rouchon, Int. J. Control 61(6), 1995, section 4.1.
    """

    def __init__(self, problem: PlanningTask, flat: FlatFacts) -> None:
        self._problem, self._flat = problem, flat
        self.coordinates = flat.coordinates

    def paths(self, x0: Array, x1: Array) -> Iterator[list[Path]]:
        """Yield the straight path from x0 to x1, both at rest, shape (nx,)."""
        begin, end = self._outputs(x0), self._outputs(x1)
        if np.abs(end - begin).max() > 0:
            yield [self._path(begin, end)]

    def _outputs(self, x: Array) -> Array:
        values = dict(
            zip(self._problem.model.coordinate_names, x[: self._problem.model.nq], strict=True)
        )
        return np.array([float(value) for value in self._flat.defined(values)])

    def _path(self, begin: Array, end: Array) -> Path:
        def path(fraction: Array, rate: Array, slope: Array) -> Array:
            values: dict[str, Array] = {}
            for name, first, change in zip(self._flat.outputs, begin, end - begin, strict=True):
                line = (first + fraction * change, rate * change, slope * change)
                values |= {name + "'" * order: value for order, value in enumerate(line)}
            columns = self._flat.determined(values)
            return np.column_stack([np.broadcast_to(c, fraction.shape) for c in columns])

        return path


def path_family(problem: PlanningTask) -> AbstractPathFamily:
    """Return the machine's path family: that of its flat map, or straight lines."""
    flat = problem.machine.flat
    if flat is None:
        return StraightLines(problem)
    if flat.plane_curves:
        return PlanePaths(problem, flat)
    return FlatOutputPaths(problem, flat)

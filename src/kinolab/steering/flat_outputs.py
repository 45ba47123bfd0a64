"""Rest-to-rest steering along straight lines in flat-output space."""

from __future__ import annotations

from collections.abc import Iterator
from typing import final

import numpy as np

from kinolab.dynamics.machine_facts import FlatFacts
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.path_motion import AbstractPathFamily, Path


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

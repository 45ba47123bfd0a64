"""Rest-to-rest steering along straight lines in flat-output space."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import sympy

from kinolab.dynamics.derivation.lowering import evaluate
from kinolab.dynamics.language.flatness import FlatOutputs, output
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.path_motion import Path


class FlatOutputPaths:
    """Paths along straight lines of the flat outputs.

    Attributes:
        coordinates: Names of the coordinates that the paths determine.

    Source: Fliess, Levine, Martin, Rouchon, Int. J. Control 61(6), 1995, section 4.1.
    """

    def __init__(self, problem: PlanningTask) -> None:
        flat = problem.system.flat
        assert isinstance(flat, FlatOutputs)
        self._problem, self._flat = problem, flat
        self.coordinates = tuple(c.name for c in flat.coordinates)
        system = problem.system
        self._parameters = {p: system.parameter_values[p.name] for p in system.parameters}

    def detours(self, x0: Array, x1: Array) -> Iterator[list[Path]]:  # noqa: ARG002
        """Yield nothing: there are no alternatives."""
        yield from ()

    def straightened(self, x: Array) -> Array:
        """Return the state unchanged: there is no steering angle."""
        return x

    def paths(self, x0: Array, x1: Array) -> Iterator[list[Path]]:
        """Yield the straight path from x0 to x1, both at rest, shape (nx,)."""
        begin, end = self._outputs(x0), self._outputs(x1)
        if np.abs(end - begin).max() > 0:
            yield [self._path(begin, end)]

    def _outputs(self, x: Array) -> Array:
        names = self._problem.model.coordinate_names
        by_name = {c.name: c for c in self._flat.coordinates}
        values = {by_name[name]: x[i] for i, name in enumerate(names) if name in by_name}
        return np.array(
            [float(evaluate(e, values | self._parameters)) for _, e in self._flat.outputs]
        )

    def _path(self, begin: Array, end: Array) -> Path:
        def path(fraction: Array, rate: Array, slope: Array) -> Array:
            values: dict[sympy.Symbol, Any] = dict(self._parameters)
            for k, (name, _) in enumerate(self._flat.outputs):
                path = end[k] - begin[k]
                line = (begin[k] + fraction * path, rate * path, slope * path)
                values |= {output(name, order): line[order] for order in range(3)}
            columns = []
            for coordinate, expression in self._flat.determined:
                columns.append(np.broadcast_to(evaluate(expression, values), fraction.shape))
                values[coordinate] = columns[-1]
            return np.column_stack(columns)

        return path

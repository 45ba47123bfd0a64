"""Where planners that cover a grid look: the first coordinates of the configuration."""

from __future__ import annotations

from typing import Any

from ompl import base as ob

from kinolab.bridge.spaces import Layout
from kinolab.problem import Problem

CELLS = 20  # along each coordinate of the projection
MOST = 3  # coordinates; more would have too many cells


class Projection(ob.ProjectionEvaluator):  # type: ignore[misc]
    """A state as its first positions, then angles, each divided into cells.

    The space keeps it, so that it must not refer to the space.
    """

    def __init__(self, problem: Problem, space: Any) -> None:
        super().__init__(space)
        self._layout = Layout(problem)
        self._entries = projected(problem)
        lower, upper = problem.sampling_bounds[self._entries].T
        self._sizes = ((upper - lower) / CELLS).tolist()

    def set_cells(self) -> None:
        """Set the size of the cells; OMPL wants the space to be set up before."""
        self.inferCellSizes()  # makes room for them
        for k, size in enumerate(self._sizes):
            self.setCellSizes(k, size)

    def getDimension(self) -> int:
        """Return how many coordinates there are."""
        return len(self._entries)

    def project(self, state: Any, projection: Any) -> None:
        """Write the coordinates of a state."""
        values = self._layout.read(state)
        for k, entry in enumerate(self._entries):
            projection[k] = values[entry]


def projected(problem: Problem) -> list[int]:
    """Return the entries of the state that describe where a machine is: lengths before angles.

    What the metric hardly weighs, such as how far a wheel has rolled, comes last.
    """
    model = problem.model
    units = {c.name: c.unit for c in problem.system.coordinates}
    spans = problem.sampling_bounds[:, 1] - problem.sampling_bounds[:, 0]

    def rank(i: int) -> tuple[bool, float]:
        is_length = units.get(model.state_names[i]) == "m"
        return not is_length, 0.0 if is_length else -float(problem.weights[i] * spans[i])

    return sorted(range(model.nq), key=rank)[:MOST]

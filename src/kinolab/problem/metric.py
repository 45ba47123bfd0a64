"""Projection of states onto few coordinates, which planners discretise into cells."""

from __future__ import annotations

from kinolab.problem.task import PlanningTask

CELLS_AROUND_GOAL = 1000  # total over the box of the goal's tolerances


def projected_coordinates(problem: PlanningTask, *, angles: bool = True) -> list[int]:
    """Return the state entries of the projection: lengths before angles.

    Angles of little weight in the metric, such as a wheel's, come last.

    Args:
        angles: Whether to include angles where there are lengths.
    """
    model = problem.model
    units = {c.name: c.unit for c in problem.machine.coordinates}
    spans = problem.sampling_bounds[:, 1] - problem.sampling_bounds[:, 0]
    lengths = [i for i in range(model.nq) if units.get(model.state_names[i]) == "m"]
    others = [i for i in range(model.nq) if i not in lengths]
    others.sort(key=lambda i: -float(problem.weights[i] * spans[i]))
    # a projection onto more would make too many cells
    return (lengths if lengths and not angles else lengths + others)[:3]

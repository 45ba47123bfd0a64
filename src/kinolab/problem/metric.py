"""Which coordinates say where a machine is: what planners divide into cells."""

from __future__ import annotations

from kinolab.problem.task import PlanningTask

MAX_COORDINATES = 3  # coordinates; more would have too many cells
CELLS_AROUND_GOAL = 1000  # of one size, over all of the goal's tolerances


def projected_coordinates(problem: PlanningTask, *, angles: bool = True) -> list[int]:
    """Return the entries of the state that describe where a machine is: lengths before angles.

    What the metric hardly weighs, such as how far a wheel has rolled, comes last.

    Args:
        problem: Whose machine.
        angles: Whether angles are wanted where there are lengths.
    """
    model = problem.model
    units = {c.name: c.unit for c in problem.system.coordinates}
    spans = problem.sampling_bounds[:, 1] - problem.sampling_bounds[:, 0]
    lengths = [i for i in range(model.nq) if units.get(model.state_names[i]) == "m"]
    others = [i for i in range(model.nq) if i not in lengths]
    others.sort(key=lambda i: -float(problem.weights[i] * spans[i]))
    return (lengths if lengths and not angles else lengths + others)[:MAX_COORDINATES]

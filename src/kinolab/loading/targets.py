"""Where a scenario's plan starts, where it must end, and where bodies must never point."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.arguments import require_numbers
from kinolab.dynamics import Model
from kinolab.loading.goal_regions import aim_of, name_of
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import unit
from kinolab.problem.goal import DirectionTarget, Goal, KeepOutCone, PartTarget, PointTarget
from kinolab.scenario import Scenario, axis_vector
from kinolab.scenario.schema import GoalChoice, GoalSection

if TYPE_CHECKING:
    from kinolab.dynamics import System


def start_of(scenario: Scenario, model: Model) -> Array:
    """Return the state at time zero, at rest where the scenario says nothing, shape (nx,)."""
    start, spheres = model.rest(), {part.name: part for part in model.space.spheres}
    for name, value in scenario.start.items():
        if isinstance(value, tuple):
            start[spheres[name].own] = unit(value)
        else:
            start[model.state_names.index(name)] = value
    return start


def stated_start(scenario: Scenario, system: System) -> Array | None:
    """Return the start (nx,) that a scenario states; None where it says nothing of this machine."""
    if not scenario.start:
        return None
    model = system.model()
    known = {*model.state_names, *(part.name for part in model.space.spheres)}
    return start_of(scenario, model) if known >= {*scenario.start} else None


def start_table(model: Model, x: ArrayLike) -> dict[str, float | list[float]]:
    """Return what ``[start]`` says of a state (nx,): unit vectors as lists, all else as numbers.

    Raises:
        InputError: If it is no such state.
    """
    state = require_numbers(f"start ({', '.join(model.state_names)})", x, (model.nx,))
    table: dict[str, float | list[float]] = dict(zip(model.state_names, state, strict=True))
    for part in model.space.spheres:
        for name in model.state_names[part.own]:
            del table[name]
        table[part.name] = state[part.own].tolist()
    return table


def goal_of(section: GoalSection, model: Model, circular: NDArray[np.bool_]) -> Goal:
    """Return the goal region, or of several the first, which knows the others.

    Each is smaller than the scenario's by what is held in reserve.

    Args:
        section: What was asked for.
        circular: Which entries of the state are angles on the circle, shape (nx,).
    """
    first, *others = (_region(one, model, circular) for one in section.any_of or [section])
    return replace(first, any_of=tuple(others))


def _region(section: GoalChoice, model: Model, circular: NDArray[np.bool_]) -> Goal:
    kept = 1.0 - section.reserve
    values = {name: v for name, v in section.values.items() if not isinstance(v, tuple)}
    spheres = {part.name: part for part in model.space.spheres}
    speeds = (model.state_names[i] for i in model.speeds)
    values = dict.fromkeys(filter(section.rests, speeds), 0.0) | values
    indices = [model.state_names.index(name) for name in values]
    bodies = [body.name for body in model.machine.bodies]
    return Goal(
        indices=tuple(indices),
        targets=np.array(list(values.values()), dtype=float),
        tolerances=kept * np.array([section.tolerance_of(name) for name in values]),
        circular=circular[indices],
        points=tuple(
            PointTarget(bodies.index(p.body), p.at, p.position, kept * p.tolerance)
            for p in section.point
        ),
        directions=tuple(
            DirectionTarget(
                bodies.index(d.body),
                axis_vector(d.axis),
                tuple(unit(d.target).tolist()),
                kept * d.tolerance,
            )
            for d in section.direction
        ),
        parts=tuple(
            PartTarget(
                spheres[name], tuple(unit(value).tolist()), kept * section.tolerance_of(name)
            )
            for name, value in section.values.items()
            if isinstance(value, tuple)
        ),
        formulas=tuple(
            PointTarget(bodies.index(name_of(one)), (0.0, 0.0, 0.0), (aim, 0.0, 0.0), kept * reach)
            for one in section.region
            for aim, reach in [aim_of(one)]
        ),
        norm=section.norm,
    )


def keep_outs_of(scenario: Scenario, model: Model) -> tuple[KeepOutCone, ...]:
    """Return the forbidden cones, wider by the clearance that plans keep from them."""
    bodies = [body.name for body in model.machine.bodies]
    return tuple(
        KeepOutCone(
            bodies.index(cone.body),
            axis_vector(cone.axis),
            tuple(unit(cone.direction).tolist()),
            min(cone.half_angle + cone.clearance, math.pi),
            min(cone.clearance, math.pi - cone.half_angle),
        )
        for cone in scenario.keep_out
    )

"""Goals of formulas: each formula is the place along x of a frame, which nothing has to carry.

So a formula's value comes with the poses of bodies, derivatives and all, for whoever asks how far
a point is from its goal. Below one limit alone the frame's place is how far the formula is from
where it is aimed at, and 0 beyond.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from kinolab.dynamics import Model
from kinolab.errors import InputError, Mistake
from kinolab.scenario import Scenario, place_at
from kinolab.scenario.schema import RegionGoal

if TYPE_CHECKING:
    from kinolab.dynamics.language.mechanism import Mechanism


def name_of(region: RegionGoal) -> str:
    """Return what a region is called: ``1 <= x + y <= 2``."""
    least = "" if region.least is None else f"{region.least:g} <= "
    most = "" if region.most is None else f" <= {region.most:g}"
    return f"{least}{region.expression}{most}"


def aim_of(region: RegionGoal) -> tuple[float, float]:
    """Return the place that a region's frame is wanted at, and how far it may be from there."""
    if region.least is None or region.most is None:
        return 0.0, region.tolerance
    return 0.5 * (region.least + region.most), 0.5 * (region.most - region.least)


def with_regions(scenario: Scenario, model: Model) -> Model:
    """Return a machine with a frame for each formula of a goal; itself where there is none.

    Raises:
        InputError: If a formula is none, or is not one of coordinates alone.
    """
    known = {body.name for body in model.machine.bodies}
    regions = {
        name_of(region): (region, place_at((*at, "region", k, "expression"), scenario.origin))
        for at, goal in scenario.goal_tables.items()
        for k, region in enumerate(goal.region)
        if name_of(region) not in known  # as in the machine of a run
    }
    if not regions:
        return model
    content = json.dumps([model.key, "regions", [one.model_dump() for one, _ in regions.values()]])
    return Model.described_by(content, partial(_with_frames, model, regions))


def _with_frames(model: Model, regions: Mapping[str, tuple[RegionGoal, str]]) -> Mechanism:
    # Imported here: a machine that is in the cache needs no symbols.
    import sympy

    from kinolab.dynamics import Body, move
    from kinolab.dynamics.language.mechanism_parts import configuration_symbols
    from kinolab.problem.objective.formula import formula

    system = model.system
    known = {*configuration_symbols(system), *system.parameters}
    made = []
    for name, (region, where) in regions.items():
        value = formula(region.expression, system, where)
        if others := sorted(map(str, value.free_symbols - known)):
            what = f"{', '.join(others)} is no coordinate."
            remedy = "Write rates below [goal] themselves: x_dot = 0.0."
            raise InputError([Mistake(where, what, remedy)])
        if region.least is None and region.most is not None:
            value = sympy.Max(value - region.most + region.tolerance, 0)
        elif region.most is None and region.least is not None:
            value = sympy.Max(region.least + region.tolerance - value, 0)
        made.append(Body(name, move(value, 0, 0), located=False))
    return system.changed(bodies=[*system.bodies, *made])

"""What makes a scenario's problem impossible to plan for, before anything is searched."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from kinolab import planners
from kinolab.dynamics import Model
from kinolab.dynamics.facts.machine_facts import MachineFacts
from kinolab.dynamics.language.shapes import MAX_COORDINATE
from kinolab.dynamics.model.units import units_by_name
from kinolab.errors import InputError, MissingPlannerError, Mistake, listed
from kinolab.loading.state_arrays import StateArrays
from kinolab.numerics.arrays import MULTIPLIABLE
from kinolab.scenario import Issue, Scenario, check_angles, check_names
from kinolab.scenario.issues import KeyPath
from kinolab.scenario.values import ROBOT_FORMATS
from kinolab.search.plugins import full_reference
from kinolab.world import Obstacle
from kinolab.world.meshes.mesh_hints import FAR_TOO_LARGE, likely_scale

MIN_STEP = 1e-6  # [s]


def name_mistakes(
    scenario: Scenario, machine: MachineFacts, quasi_velocities: Sequence[str] = ()
) -> list[Mistake]:
    """List the names in a scenario that its machine does not have, and angles that are none."""
    return check_angles(scenario, units_by_name(machine)) + check_names(
        scenario,
        [coordinate.name for coordinate in machine.coordinates],
        [*machine.rate_names, *quasi_velocities, *(state.name for state in machine.states)],
        list(machine.parameter_names),
        [body.name for body in machine.bodies],
        chosen_names(machine),
        dict(machine.notes),
    )


def chosen_names(machine: MachineFacts) -> list[str]:
    """Return the names of inputs, and of the references of feedback."""
    return [entry.name for entry in (*machine.inputs, *(machine.references or ()))]


def parameter_issues(machine: MachineFacts) -> Iterator[Issue]:
    """Yield parameters whose products are no numbers of a computer; 0 is one."""
    least, largest = MULTIPLIABLE  # in SI units
    for name, value in machine.parameters:
        if value and not least <= abs(value) <= largest:
            beyond = "more" if abs(value) > largest else "less"
            what = f"{name} = {value:g} is {beyond} than can be computed with."
            remedy = f"Give 0, or a size from {least:g} to {largest:g}."
            yield Issue(("system", "parameters", name), what, remedy)


def planner_issues(scenario: Scenario) -> Iterator[Issue]:
    """Yield what is wrong with the planner's name, and the names and values of its settings."""
    section = scenario.planner
    try:
        planner = planners.get(full_reference(section.name, scenario.folder))
        for key, what, remedy in planners.misfits(planner, section.settings):
            yield Issue(("planner", key), what, remedy)
    except MissingPlannerError:
        return  # the machine and the world can be looked at without it
    except InputError as error:
        for wrong in error.mistakes:
            yield Issue(("planner", "name"), wrong.what, wrong.remedy)


def mesh_issues(scenario: Scenario, obstacles: Mapping[int, Sequence[Obstacle]]) -> Iterator[Issue]:
    """Yield meshes and clouds that are in another unit than their world, by their size.

    Args:
        scenario: Of which only bounds and given scales are looked at.
        obstacles: By their place in the scenario.
    """
    spans = [high - low for low, high in scenario.world.bounds.values()]
    entries = scenario.world.obstacle
    files = [k for k in obstacles if entries[k].kind in ("mesh", "cloud")]
    if not spans or not files:
        return
    sizes = {
        k: float(max(np.ptp(o.bounding_box(), axis=0).max() for o in some))
        for k, some in obstacles.items()
    }
    world, largest = max(spans), max(sizes.values())
    small = largest <= world / FAR_TOO_LARGE
    for k in files:
        entry, size = entries[k], sizes[k]
        if entry.scale != 1.0 or not (small or size >= FAR_TOO_LARGE * world):
            continue
        found = likely_scale(size, world)
        if found is not None:
            what = f"it is {size:.3g} m wide in a world of {world:.3g} m."
            unit = f" if the file is in {found[1]}" if found[1] else ""
            remedy = f"Write scale = {found[0]:g}{unit}, or change [world] bounds."
            yield Issue(("world", "obstacle", k, entry.kind), what, remedy)


def limit_issues(scenario: Scenario, model: Model, arrays: StateArrays) -> Iterator[Issue]:
    """Yield what no planner could work with: no inputs, no limits, limits that exclude others, …"""
    unlimited: list[str] = []
    if not model.nu:
        remedy = "Give it some; plan simulate shows how it moves without."
        if str(scenario.system.file).endswith(ROBOT_FORMATS):
            remedy = "Give joints an effort in the file, or write kinematic = true below [system]."
        yield Issue(("system",), "it has no inputs, so that there is nothing to plan.", remedy)
    for i in np.flatnonzero(~model.space.limited(arrays.circular).turns):
        name, (lower, upper) = model.state_names[i], arrays.bounds[i].tolist()
        if not lower < upper:
            what = f"the limits of {name} exclude each other: {lower:g} to {upper:g}."
            remedy = "Compare [bounds], [world] bounds and the machine's own limits."
            yield Issue(("bounds", name), what, remedy)
        elif not np.isfinite([lower, upper]).all():
            if i not in model.clocks:
                unlimited.append(name)
        elif max(abs(lower), abs(upper)) > MAX_COORDINATE:
            what = f"{name} may be as large as {max(abs(lower), abs(upper)):g}."
            yield Issue(("bounds", name), what, f"Keep limits below {MAX_COORDINATE:g}.")
    if unlimited:
        yield Issue(("bounds",), *unlimited_sentences(model, unlimited))
    if not arrays.weights.any():
        what = "all weights are 0, so that every state is as near as any other."
        yield Issue(("metric",), what, "Leave one positive.")
    if scenario.integration.step < MIN_STEP:
        what = f"{scenario.integration.step:g} s is too short a step."
        yield Issue(("integration", "step"), what, f"Take {MIN_STEP:g} s or more.")


def unlimited_sentences(model: Model, names: Sequence[str]) -> tuple[str, str]:
    """Say that nothing limits states, and of quasi-velocities what they are; and what would."""
    known = {v.name: f", the {v.direction}, in {v.unit}" for v in model.quasi_velocities}
    told = listed(f"{name}{known.get(name, '')}" for name in names)
    it, likewise = ("them", ", and the others likewise,") if len(names) > 1 else ("it", "")
    what = f"nothing limits {told}, so a planner cannot sample {it}."
    return what, f"Write {names[0]} = [lower, upper]{likewise} below [bounds]."


def endpoint_issues(scenario: Scenario, model: Model) -> Iterator[Issue]:
    """Yield what start and goal cannot have: dependent rates, wrong kinds.

    Nor can tolerances and weights of dependent rates count: they are no part of the state.
    """
    spheres = {part.name: part for part in model.space.spheres}
    for name, part in spheres.items():
        if name in scenario.bounds:
            what = f"{name} is a {part.word}, which has no limits."
            yield Issue(("bounds", name), what, "Limit its rates, or use [[keep_out]].")
    free = ", ".join(model.velocity_names)
    modes = {model.state_names[-1]: model.machine.modes} if model.machine.modes else {}
    sections: dict[KeyPath, Any] = {("start",): scenario.start}
    sections |= {place: goal.values for place, goal in scenario.goal_tables.items()}
    for section, values in sections.items():
        for name, value in values.items():
            if isinstance(value, tuple) and name not in spheres:
                what = f"{name} is a single number, not a rotation."
                yield Issue((*section, name), what, "Give one number.")
            elif not isinstance(value, tuple) and name in spheres:
                what = f"{name} is a {spheres[name].word}, not a single number."
                yield Issue((*section, name), what, f"Give {spheres[name].example}.")
            elif name in modes and value not in range(len(modes[name])):
                named = (f"{k} for {mode}" for k, mode in enumerate(modes[name]))
                what = f"{value} is no mode of {model.machine.name}."
                yield Issue((*section, name), what, f"Give {', '.join(named)}.")
    tables = sections | {("metric",): scenario.metric}
    for place, goal in scenario.goal_tables.items():
        tables[*place, "tolerance"] = goal.tolerance if isinstance(goal.tolerance, dict) else {}
    for place, table in tables.items():
        for name in table:
            if name in model.rate_names and name not in model.state_names:
                what = f"{name} follows from the other rates by the constraints."
                yield Issue((*place, name), what, f"Give one of {free} instead.")

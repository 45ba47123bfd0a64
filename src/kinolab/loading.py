"""From a scenario to a problem: scenario -> system -> model, scenario -> world -> problem."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from kinolab import planners, systems
from kinolab.dynamics import Model, System
from kinolab.dynamics.language.json.machine_file import load_machine
from kinolab.dynamics.language.mechanism_parts import MechanismParts, tangent_symbols
from kinolab.dynamics.language.symbols import RateSymbol
from kinolab.dynamics.language.tightened_limits import with_tightened_limits
from kinolab.errors import InputError, MissingPlannerError, Mistake, UnknownNameError
from kinolab.numerics.quaternions import unit
from kinolab.problem import PlanningTask
from kinolab.problem.goal import (
    AttitudeTarget,
    DirectionTarget,
    Goal,
    KeepOutCone,
    PointTarget,
)
from kinolab.scenario import (
    Issue,
    ObstacleEntry,
    Scenario,
    axis_vector,
    builtin_scenarios,
    check_names,
    load_scenario,
    mistake_at,
    read_scenario,
    scenario_from,
)
from kinolab.scenario.dynobench import is_environment, read_environment
from kinolab.scenario.user_code import blamed, run_file
from kinolab.search.plugins import full_reference
from kinolab.world import (
    Obstacle,
    World,
    box_obstacle,
    cylinder_obstacle,
    mesh_obstacle,
    sphere_obstacle,
)

T = TypeVar("T")

MAX_LIMIT = 1e9  # of a limit, in its own unit: beyond it nothing in the world has a size
MIN_STEP = 1e-6  # [s]


def load(source: str | Path, *, overrides: Sequence[str] = ()) -> PlanningTask:
    """Read a scenario, or an environment of dynobench, and build its problem.

    Raises:
        InputError: With every mistake that was found.
    """
    read = read_environment if is_environment(source) else read_scenario
    scenario, mistakes = read(source, overrides=overrides)
    scenario = None if scenario is None else _for_another_planner(scenario)
    if scenario is None or mistakes:
        found = [] if scenario is None else _mistakes(scenario)
        raise InputError(dict.fromkeys([*mistakes, *found]))
    return build_problem(scenario)


def _for_another_planner(scenario: Scenario) -> Scenario:
    """Leave out what a file says to its own planner, where an override names another one."""
    section, overrides = scenario.planner, scenario.origin.overrides
    named = [o.before for o in overrides if o.path == ("planner", "name")]
    own = type(section).model_fields["name"].default
    if not named or section.name == (own if named[0] is None else named[0]):
        return scenario
    typed = {o.path[1] for o in overrides if o.path[:1] == ("planner",) and len(o.path) > 1}
    kept = {key: value for key, value in section.settings.items() if key in typed}
    shared = {key: getattr(section, key) for key in section.model_fields_set}
    shared = {key: value for key, value in shared.items() if key in type(section).model_fields}
    return scenario.model_copy(update={"planner": type(section)(**shared, **kept)}).located(
        scenario.origin
    )


def build_problem(
    scenario: Scenario, *, planning: bool = True, planner: bool = True
) -> PlanningTask:
    """Build the problem of a scenario.

    Args:
        scenario: What to build.
        planning: Whether it will be planned for, which needs limits on everything; a machine that
            is only simulated needs none.
        planner: Whether the planner that it names must be here and its settings fit. Where not, no
            code of a planner's is run.

    Raises:
        InputError: With every mistake in the machine, the meshes and the names.
    """
    mistakes: list[Mistake] = []
    system, obstacles = _parts(scenario, mistakes, planner=planner)
    whole = None if system is None else _collect(mistakes, system.model)
    model = (
        None
        if whole is None
        else _collect(mistakes, lambda: _with_narrower_limits(scenario, whole))
    )
    if model is not None:
        mistakes += _ill_posed(scenario, model) if planning else ()
        mistakes += _misplaced(scenario, model)
    if mistakes or whole is None or model is None:
        raise InputError(mistakes)
    world = World(
        tuple(obstacle for obstacle in obstacles if obstacle is not None),
        scenario.world.ground == "plane",
        dict(scenario.world.bounds),
        scenario.world.clearance,
    )
    return _problem(scenario, whole, model, world)


def _with_narrower_limits(scenario: Scenario, whole: Model) -> Model:
    """Return the machine with the limits of inputs and references that a scenario sets."""
    limits = {n: scenario.bounds[n] for n in _chosen(whole.system) if n in scenario.bounds}
    try:
        return Model(with_tightened_limits(whole.system, limits)) if limits else whole
    except InputError as error:
        raise InputError(
            _at(scenario, ("bounds", wrong.where), wrong.what, wrong.remedy)
            for wrong in error.mistakes
        ) from error


def _mistakes(scenario: Scenario) -> list[Mistake]:
    """List what is wrong with the machine, the meshes and the names of a damaged scenario."""
    mistakes: list[Mistake] = []
    _parts(scenario, mistakes)
    return mistakes


def _parts(
    scenario: Scenario, mistakes: list[Mistake], *, planner: bool = True
) -> tuple[System | None, list[Obstacle | None]]:
    """Return machine and obstacles, None for what is broken, and add what is wrong to a list."""
    obstacles = [
        _collect(mistakes, partial(_obstacle, scenario, entry)) for entry in scenario.world.obstacle
    ]
    if scenario.system.name is None and scenario.system.file is None:
        return None, obstacles  # it is among the mistakes already
    system = _collect(mistakes, lambda: find_system(scenario))
    if system is not None:
        mistakes += _name_mistakes(scenario, system)
    if planner:
        mistakes += _planner_mistakes(scenario)
    return system, obstacles


def find_system(scenario: Scenario) -> System:
    """Return the machine of a scenario: a registered one, a user's, or one from a file.

    Raises:
        InputError: If it does not exist, or a parameter of it does not.
    """
    section = scenario.system
    if section.name is not None:
        where = _at(scenario, ("system", "name"), "").where
        if section.name not in systems.names():
            raise UnknownNameError("system", section.name, known=systems.names(), where=where)
        system = systems.get(section.name)
    else:
        where = _at(scenario, ("system", "file"), "").where
        system = _system_from_file(scenario.folder, str(section.file), where)
    known = [parameter.name for parameter in system.parameters]
    if all(name in known for name in section.parameters):
        return system.with_parameters(**section.parameters)
    return system  # the unknown ones are reported with all other names


def _at(scenario: Scenario, path: tuple[str, ...], what: str, remedy: str = "") -> Mistake:
    """Return a mistake at a key of a scenario, or at the override that set it."""
    return mistake_at(Issue(path, what, remedy), scenario.origin)


def system_from_python(path: Path, function: str, where: str) -> System:
    """Run a user's Python file and return the system that one of its functions makes."""
    module = run_file(path, where)
    factory = getattr(module, function, None)
    if not callable(factory):
        known = sorted(name for name, value in vars(module).items() if callable(value))
        raise UnknownNameError(f"function of {path.name}", function, known=known, where=where)
    with blamed(f"running {function}() of {path.name}", where, path.resolve()):
        system = factory()
    if not isinstance(system, System):
        what = f"{function}() returned {type(system).__name__}, not a System."
        raise InputError([Mistake(where, what)])
    return system


def _system_from_file(folder: Path, text: str, where: str) -> System:
    if text.endswith(".json"):
        path = folder / text
        if not path.is_file():
            raise InputError([Mistake(where, f"there is no file {text}.")])
        return System.of(load_machine(path))
    file, _, function = text.rpartition(":")
    return system_from_python(folder / file, function, where)


def _collect(mistakes: list[Mistake], make: Callable[[], T]) -> T | None:
    """Return what a function makes, or None after adding its mistakes to the list."""
    try:
        return make()
    except InputError as error:
        mistakes.extend(error.mistakes)
        return None


def _obstacle(scenario: Scenario, entry: ObstacleEntry) -> Obstacle:
    name = entry.name
    pose = (entry.position, entry.rpy)
    if entry.box is not None:
        return box_obstacle(name, entry.box, *pose)
    if entry.sphere is not None:
        return sphere_obstacle(name, entry.sphere, *pose)
    if entry.cylinder is not None:
        return cylinder_obstacle(name, *entry.cylinder, *pose)
    return mesh_obstacle(
        name,
        str(entry.mesh),
        scenario.folder,
        *pose,
        scale=entry.scale,
        up=entry.up,
        solid=entry.solid,
    )


def _name_mistakes(scenario: Scenario, system: System) -> list[Mistake]:
    return check_names(
        scenario,
        [coordinate.name for coordinate in system.coordinates],
        [rate.name for rate in tangent_symbols(system)] + [state.name for state in system.states],
        [parameter.name for parameter in system.parameters],
        [body.name for body in system.bodies],
        _chosen(system),
    )


def _chosen(system: MechanismParts) -> list[str]:
    """Return the names of inputs, and of the references of feedback."""
    references = () if system.feedback is None else system.feedback.references
    return [entry.name for entry in (*system.inputs, *references)]


def _planner_mistakes(scenario: Scenario) -> list[Mistake]:
    """Check the planner's name, and the names and values of its settings."""
    section = scenario.planner
    name = full_reference(section.name, scenario.folder)
    try:
        planner = planners.get(name)
        misfits = planners.misfits(planner, section.settings)
    except MissingPlannerError:
        return []  # the machine and the world can be looked at without it
    except InputError as error:
        path = ("planner", "name")
        return [_at(scenario, path, wrong.what, wrong.remedy) for wrong in error.mistakes]
    return [_at(scenario, ("planner", key), what, remedy) for key, what, remedy in misfits]


def _ill_posed(scenario: Scenario, model: Model) -> Iterator[Mistake]:
    """Name what no planner could work with: no limits, limits that exclude each other, …"""
    bounds, unlimited = _bounds(scenario, model), _circular(scenario, model)
    for own in model.space.quaternions:
        unlimited[own] = True
    for name, (lower, upper), free in zip(model.state_names, bounds, unlimited, strict=True):
        if free:
            continue
        if not lower < upper:
            what = f"the limits of {name} exclude each other: {lower:g} to {upper:g}."
            remedy = "Compare [bounds], [world] bounds and the machine's own limits."
            yield _at(scenario, ("bounds", name), what, remedy)
        elif not np.isfinite(upper) or not np.isfinite(lower):
            remedy = f"Write {name} = [lower, upper] below [bounds]."
            what = f"nothing limits {name}, so a planner cannot sample it."
            yield _at(scenario, ("bounds",), what, remedy)
        elif max(abs(lower), abs(upper)) > MAX_LIMIT:
            what = f"{name} may be as large as {max(abs(lower), abs(upper)):g}."
            yield _at(scenario, ("bounds", name), what, f"Keep limits below {MAX_LIMIT:g}.")
    weights = _weights(scenario, model)
    if not weights.any():
        what = "all weights are 0, so that every state is as near as any other."
        yield _at(scenario, ("metric",), what, "Leave one positive.")
    if scenario.integration.step < MIN_STEP:
        what = f"{scenario.integration.step:g} s is too short a step."
        yield _at(scenario, ("integration", "step"), what, f"Take {MIN_STEP:g} s or more.")


def _misplaced(scenario: Scenario, model: Model) -> Iterator[Mistake]:
    """Name values in start and goal that are not free: dependent rates, and wrong kinds."""
    for name in model.attitudes:
        if name in scenario.bounds:
            what = f"{name} is a rotation, which has no limits."
            yield _at(scenario, ("bounds", name), what, "Limit its rates, or use [[keep_out]].")
    free = ", ".join(name for name in model.state_names if name in model.rate_names)
    sections: dict[str, Any] = {"start": scenario.start, "goal": scenario.goal.values}
    for section, values in sections.items():
        for name, value in values.items():
            if isinstance(value, tuple) and name not in model.attitudes:
                what = f"{name} is a single number, not a rotation."
                yield _at(scenario, (section, name), what, "Give one number.")
            elif not isinstance(value, tuple) and name in model.attitudes:
                what = f"{name} is a rotation, not a single number."
                remedy = "Give its quaternion [x, y, z, w]; [0, 0, 0, 1] is not turned."
                yield _at(scenario, (section, name), what, remedy)
            elif name in model.rate_names and name not in model.state_names:
                what = f"{name} follows from the other rates by the constraints."
                remedy = f"Give one of {free} instead."
                yield _at(scenario, (section, name), what, remedy)


def _problem(scenario: Scenario, whole: Model, model: Model, world: World) -> PlanningTask:
    system = whole.system
    scales = model.state_scales
    start = model.rest()
    for name, value in _scalars(scenario.start).items():
        start[model.state_names.index(name)] = value
    for name, quaternion in _rotations(scenario.start).items():
        first = model.attitudes[name]
        start[first : first + 4] = unit(quaternion)
    rate_bounds = np.tile([-np.inf, np.inf], (model.nt, 1))
    for i, rate in enumerate(tangent_symbols(system)):
        if rate.name not in model.state_names:
            speed = (rate.coordinate if isinstance(rate, RateSymbol) else rate.attitude).speed
            lower, upper = scenario.bounds.get(rate.name, (-np.inf, np.inf))
            rate_bounds[i] = max(-speed, lower), min(speed, upper)
    return PlanningTask(
        scenario=scenario,
        system=system,
        model=model,
        whole=whole,
        world=world,
        start=start,
        goal=_goal(scenario, model),
        bounds=_bounds(scenario, model),
        rate_bounds=rate_bounds,
        scales=scales,
        weights=_weights(scenario, model),
        circular=_circular(scenario, model),
        keep_outs=tuple(
            KeepOutCone(
                [body.name for body in system.bodies].index(cone.body),
                axis_vector(cone.axis),
                _unit(cone.direction),
                min(cone.half_angle + cone.clearance, math.pi),
                min(cone.clearance, math.pi - cone.half_angle),
            )
            for cone in scenario.keep_out
        ),
    )


def _scalars(values: Mapping[str, float | tuple[float, ...]]) -> dict[str, float]:
    """Return the values of coordinates on lines and circles, and of rates."""
    return {name: value for name, value in values.items() if not isinstance(value, tuple)}


def _rotations(
    values: Mapping[str, float | tuple[float, ...]],
) -> dict[str, tuple[float, ...]]:
    """Return the quaternions of coordinates on SO(3)."""
    return {name: value for name, value in values.items() if isinstance(value, tuple)}


def _bounds(scenario: Scenario, model: Model) -> np.ndarray:
    """Intersect the machine's limits with the scenario's and, for positions, the world's.

    Quaternions have none: their length is 1 but for rounding.
    """
    bounds = model.state_bounds.copy()
    for own in model.space.quaternions:
        bounds[own] = -np.inf, np.inf
    lengths = [c.name for c in model.system.coordinates if c.unit == "m"]
    workspace: Mapping[str, tuple[float, float]] = dict(scenario.world.bounds)
    for i, name in enumerate(model.state_names):
        given = [scenario.bounds[name]] if name in scenario.bounds else []
        if name in lengths and name in workspace:
            given.append(workspace[name])
        for lower, upper in given:
            bounds[i] = max(bounds[i, 0], lower), min(bounds[i, 1], upper)
    return bounds


def _weights(scenario: Scenario, model: Model) -> np.ndarray:
    """Return what differences are multiplied by: [metric], else one over the scale."""
    weights = 1 / model.state_scales
    for name, weight in scenario.metric.items():
        if name in model.state_names:
            weights[model.state_names.index(name)] = weight
        elif name in model.attitudes:
            weights[model.attitudes[name] : model.attitudes[name] + 4] = weight
    return weights


def _circular(scenario: Scenario, model: Model) -> np.ndarray:
    """Say which states wrap; an angle that the scenario limits does not."""
    limited = np.array([name in scenario.bounds for name in model.state_names])
    free: np.ndarray = model.circular & ~limited
    return free


def _goal(scenario: Scenario, model: Model) -> Goal:
    section, kept = scenario.goal, 1.0 - scenario.goal.reserve
    values = _scalars(section.values)
    if section.at_rest:
        values = dict.fromkeys((model.state_names[i] for i in model.speeds), 0.0) | values
    indices = tuple(model.state_names.index(name) for name in values)
    bodies = [body.name for body in model.system.bodies]
    return Goal(
        indices=indices,
        targets=np.array(list(values.values()), dtype=float),
        tolerances=kept * np.array([section.tolerance_of(name) for name in values]),
        circular=_circular(scenario, model)[list(indices)],
        points=tuple(
            PointTarget(bodies.index(p.body), p.at, p.position, kept * p.tolerance)
            for p in section.point
        ),
        directions=tuple(
            DirectionTarget(
                bodies.index(d.body), axis_vector(d.axis), _unit(d.target), kept * d.tolerance
            )
            for d in section.direction
        ),
        attitudes=tuple(
            _attitude_target(name, model.attitudes[name], value, kept * section.tolerance_of(name))
            for name, value in _rotations(section.values).items()
        ),
        norm=section.norm,
    )


def _attitude_target(
    name: str, index: int, quaternion: tuple[float, ...], tolerance: float
) -> AttitudeTarget:
    x, y, z, w = unit(quaternion).tolist()
    return AttitudeTarget(name, index, (x, y, z, w), tolerance)


def _unit(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = unit(vector).tolist()
    return x, y, z


def find_scenario(what: str, *, overrides: Sequence[str] = ()) -> Scenario:
    """Return the scenario that a text names, or an empty world for the machine that it names.

    Args:
        what: A scenario (name or path), a system's name, or ``machine.py:function``.
        overrides: ``KEY=VALUE`` texts that replace keys.

    Raises:
        InputError: If nothing has this name, or it has mistakes.
    """
    if is_environment(what):
        return _environment(what, overrides)
    if what.endswith(".toml") or what in builtin_scenarios():
        return load_scenario(what, overrides=overrides)
    system = find_machine(what)  # says what exists, where nothing has this name
    file = f"{what}:{Path(what).stem}" if what.endswith(".py") else what
    source = {"name": what} if what in systems.names() else {"file": file}
    document = {"schema": 1, "title": f"{system.name} by itself", "system": source}
    return scenario_from(document, Path(f"{system.name}.toml"), overrides=overrides)


def find_machine(what: str) -> System:
    """Return the machine that a text names.

    Args:
        what: A system's name, a scenario (name or path), or ``machine.py:function``, the function
            being named like the file where it is left out.

    Raises:
        InputError: If nothing has this name, naming the systems and scenarios there are.
    """
    if what in systems.names():
        return systems.get(what)
    file, _, function = what.rpartition(":")
    if what.endswith(".py"):
        return system_from_python(Path(what), Path(what).stem, what)
    if file.endswith(".py"):
        return system_from_python(Path(file), function, what)
    if what.endswith(".json"):
        return System.of(load_machine(Path(what)))
    if is_environment(what):
        return find_system(_environment(what))
    if not what.endswith(".toml") and what not in builtin_scenarios():
        known = [*systems.names(), *builtin_scenarios()]
        raise UnknownNameError("system or scenario", what, known=known)
    return find_system(load_scenario(what))


def _environment(what: str, overrides: Sequence[str] = ()) -> Scenario:
    scenario, mistakes = read_environment(what, overrides=overrides)
    if scenario is None or mistakes:
        raise InputError(mistakes)
    return scenario

"""From a scenario to a problem: scenario -> system -> model, scenario -> world -> problem."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from kinolab import planners, systems
from kinolab.dynamics import Coordinate, Model, System
from kinolab.dynamics.machine_file import load_machine
from kinolab.errors import (
    InputError,
    KinolabError,
    MissingPlannerError,
    Mistake,
    UnknownNameError,
    unknown_name,
)
from kinolab.goal import DirectionTarget, Goal, PointTarget
from kinolab.problem import Problem
from kinolab.scenario import (
    Finding,
    ObstacleEntry,
    Scenario,
    axis_vector,
    builtin_scenarios,
    check_names,
    load_scenario,
    mistake_at,
    read_scenario,
)
from kinolab.world import (
    Obstacle,
    World,
    box_obstacle,
    cylinder_obstacle,
    mesh_obstacle,
    sphere_obstacle,
)

T = TypeVar("T")


def load(source: str | Path, *, overrides: Sequence[str] = ()) -> Problem:
    """Read a scenario and build its problem.

    Args:
        source: Path of a TOML file, or the name of a built-in scenario.
        overrides: ``KEY=VALUE`` texts that replace keys of the file.

    Raises:
        InputError: With every mistake that was found.
    """
    scenario, mistakes = read_scenario(source, overrides=overrides)
    if scenario is None or mistakes:
        found = [] if scenario is None else _mistakes(scenario)
        raise InputError(dict.fromkeys([*mistakes, *found]))
    return build_problem(scenario)


def build_problem(scenario: Scenario) -> Problem:
    """Build the problem of a scenario.

    Raises:
        InputError: With every mistake in the machine, the meshes and the names.
    """
    mistakes: list[Mistake] = []
    system, obstacles = _parts(scenario, mistakes)
    model = None if system is None else _collect(mistakes, system.model)
    if model is not None:
        mistakes += _unlimited(scenario, model)
        mistakes += _misplaced(scenario, model)
    if mistakes or system is None or model is None:
        raise InputError(mistakes)
    world = World(
        tuple(obstacle for obstacle in obstacles if obstacle is not None),
        scenario.world.ground == "plane",
        dict(scenario.world.bounds),
    )
    return _problem(scenario, system, model, world)


def _mistakes(scenario: Scenario) -> list[Mistake]:
    """List what is wrong with the machine, the meshes and the names of a damaged scenario."""
    mistakes: list[Mistake] = []
    _parts(scenario, mistakes)
    return mistakes


def _parts(
    scenario: Scenario, mistakes: list[Mistake]
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
    return mistake_at(Finding(path, what, remedy), scenario.origin)


def system_from_python(path: Path, function: str, where: str) -> System:
    """Run a user's Python file and return the system that one of its functions makes."""
    specification = importlib.util.spec_from_file_location(f"kinolab_user_{path.stem}", path)
    if specification is None or specification.loader is None or not path.is_file():
        raise InputError([Mistake(where, f"there is no Python file {path}.")])
    module = importlib.util.module_from_spec(specification)
    sys.modules[specification.name] = module
    try:
        specification.loader.exec_module(module)
    except KinolabError:
        raise
    except Exception as error:
        what = f"running {path.name} failed ({type(error).__name__}: {error})."
        raise InputError([Mistake(where, what)]) from error
    factory = getattr(module, function, None)
    if not callable(factory):
        known = sorted(name for name, value in vars(module).items() if callable(value))
        raise UnknownNameError(f"function of {path.name}", function, known=known, where=where)
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
        return load_machine(path)
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
    coordinates = [coordinate.name for coordinate in system.coordinates]
    return check_names(
        scenario,
        coordinates,
        [f"{name}_dot" for name in coordinates],
        [parameter.name for parameter in system.parameters],
        [body.name for body in system.bodies],
    )


def _planner_mistakes(scenario: Scenario) -> list[Mistake]:
    """Check the planner's name, and the names and values of its settings."""
    section = scenario.planner
    if section.name not in planners.names():
        unknown = unknown_name("planner", section.name, known=planners.names())
        return [_at(scenario, ("planner", "name"), unknown.what, unknown.remedy)]
    try:
        planner = planners.get(section.name)
    except MissingPlannerError:
        return []  # the machine and the world can be looked at without it
    return [
        _at(scenario, ("planner", key), what, remedy)
        for key, what, remedy in planner.misfits(section.settings)
    ]


def _unlimited(scenario: Scenario, model: Model) -> Iterator[Mistake]:
    """Name the states that a planner could not sample because nothing limits them."""
    bounds = _bounds(scenario, model)
    circular = _circular(model)
    for name, (lower, upper), circle in zip(model.state_names, bounds, circular, strict=True):
        if not circle and not (np.isfinite(lower) and np.isfinite(upper)):
            remedy = f"Write {name} = [lower, upper] below [bounds]."
            what = f"nothing limits {name}, so a planner cannot sample it."
            yield _at(scenario, ("bounds",), what, remedy)


def _misplaced(scenario: Scenario, model: Model) -> Iterator[Mistake]:
    """Name values in start and goal that are not free: dependent rates, and wrong kinds."""
    free = ", ".join(name for name in model.state_names if name in model.rate_names)
    sections: dict[str, Any] = {"start": scenario.start, "goal": scenario.goal.values}
    for section, values in sections.items():
        for name, value in values.items():
            if isinstance(value, tuple):
                what = f"{name} is a single number, not a rotation."
                yield _at(scenario, (section, name), what, "Give one number.")
            elif name in model.rate_names and name not in model.state_names:
                what = f"{name} follows from the other rates by the constraints."
                remedy = f"Give one of {free} instead."
                yield _at(scenario, (section, name), what, remedy)


def _problem(scenario: Scenario, system: System, model: Model, world: World) -> Problem:
    scales = _scales(model)
    start = np.zeros(model.nx)
    for name, value in _scalars(scenario.start).items():
        start[model.state_names.index(name)] = value
    weights = 1 / scales
    for name, weight in scenario.metric.items():
        if name in model.state_names:
            weights[model.state_names.index(name)] = weight
    dependent = [i for i in range(model.nq) if i not in model.independent]
    rate_bounds = np.tile([-np.inf, np.inf], (model.nq, 1))
    for i in dependent:
        speed = system.coordinates[i].speed
        lower, upper = scenario.bounds.get(model.rate_names[i], (-np.inf, np.inf))
        rate_bounds[i] = max(-speed, lower), min(speed, upper)
    return Problem(
        scenario=scenario,
        system=system,
        model=model,
        world=world,
        start=start,
        goal=_goal(scenario, model),
        bounds=_bounds(scenario, model),
        rate_bounds=rate_bounds,
        scales=scales,
        weights=weights,
        circular=_circular(model),
    )


def _scalars(values: Mapping[str, float | tuple[float, ...]]) -> dict[str, float]:
    """Return the values of coordinates on lines and circles; there are no others yet."""
    return {name: value for name, value in values.items() if not isinstance(value, tuple)}


def _bounds(scenario: Scenario, model: Model) -> np.ndarray:
    """Intersect the machine's limits with the scenario's and, for positions, the world's."""
    bounds = model.state_bounds.copy()
    for i, name in enumerate(model.state_names):
        given = [scenario.bounds[name]] if name in scenario.bounds else []
        coordinate = model.system.coordinates[i] if i < model.nq else None
        if coordinate is not None and coordinate.unit == "m" and name in scenario.world.bounds:
            given.append(scenario.world.bounds[name])
        for lower, upper in given:
            bounds[i] = max(bounds[i, 0], lower), min(bounds[i, 1], upper)
    return bounds


def _state_coordinates(model: Model) -> list[Coordinate]:
    """Return the coordinate that each entry of the state belongs to."""
    coordinates = model.system.coordinates
    return [*coordinates, *(coordinates[i] for i in model.independent)]


def _circular(model: Model) -> np.ndarray:
    coordinates = _state_coordinates(model)
    return np.array([i < model.nq and c.topology == "circle" for i, c in enumerate(coordinates)])


def _scales(model: Model) -> np.ndarray:
    """Return the scale of each state; a rate's is its speed limit, or its coordinate's per s."""
    return np.array(
        [
            c.speed if i >= model.nq and np.isfinite(c.speed) else c.scale
            for i, c in enumerate(_state_coordinates(model))
        ]
    )


def _goal(scenario: Scenario, model: Model) -> Goal:
    section = scenario.goal
    values = _scalars(section.values)
    if section.at_rest:
        rates = (name for name in model.state_names if name in model.rate_names)
        values = dict.fromkeys(rates, 0.0) | values
    indices = tuple(model.state_names.index(name) for name in values)
    bodies = [body.name for body in model.system.bodies]
    return Goal(
        indices=indices,
        targets=np.array(list(values.values()), dtype=float),
        tolerances=np.array([section.tolerance_of(name) for name in values]),
        circular=_circular(model)[list(indices)],
        points=tuple(
            PointTarget(bodies.index(p.body), p.at, p.position, p.tolerance) for p in section.point
        ),
        directions=tuple(
            DirectionTarget(bodies.index(d.body), axis_vector(d.axis), _unit(d.target), d.tolerance)
            for d in section.direction
        ),
    )


def _unit(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = np.asarray(vector) / np.linalg.norm(vector)
    return float(x), float(y), float(z)


def find_machine(what: str) -> System:
    """Return the machine that a text names.

    Args:
        what: A system's name, a scenario (name or path), or ``machine.py:function``.

    Raises:
        InputError: If nothing has this name, naming the systems and scenarios there are.
    """
    if what in systems.names():
        return systems.get(what)
    file, _, function = what.rpartition(":")
    if file.endswith(".py"):
        return system_from_python(Path(file), function, what)
    if what.endswith(".json"):
        return load_machine(Path(what))
    if not what.endswith(".toml") and what not in builtin_scenarios():
        known = [*systems.names(), *builtin_scenarios()]
        raise UnknownNameError("system or scenario", what, known=known)
    return find_system(load_scenario(what))

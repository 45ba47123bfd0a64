"""Build the problem of a scenario, or say everything that is wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from kinolab.arguments import require_fit
from kinolab.dynamics import Model
from kinolab.errors import InputError, Mistake
from kinolab.loading.chosen_integration import steady
from kinolab.loading.foreign_files import read_any
from kinolab.loading.goal_regions import with_regions
from kinolab.loading.kept_machines import ScenarioMachine, with_limits
from kinolab.loading.moving_obstacles import among_moving, among_runs, path_error
from kinolab.loading.state_arrays import state_arrays
from kinolab.loading.tables import read_table
from kinolab.loading.targets import goal_of, keep_outs_of, start_of
from kinolab.loading.well_posed import (
    chosen_names,
    endpoint_issues,
    limit_issues,
    mesh_issues,
    name_mistakes,
    parameter_issues,
    planner_issues,
)
from kinolab.problem import PlanningTask
from kinolab.problem.objective.costed import require_costs
from kinolab.scenario import Issue, ObstacleEntry, Scenario, mistake_at
from kinolab.untrusted import ELEMENTS
from kinolab.world import (
    Obstacle,
    World,
    box_obstacle,
    capsule_obstacle,
    cylinder_obstacle,
    mesh_obstacle,
    sphere_obstacle,
)
from kinolab.world.distances.placed_shapes import near_each_other
from kinolab.world.obstacles.floors import without_floor
from kinolab.world.obstacles.obstacle import ORIGIN

T = TypeVar("T")


def load(source: str | Path | Mapping[str, Any], *, overrides: Sequence[str] = ()) -> PlanningTask:
    """Read a scenario, as a file or a table, or a file of another tool; build its problem.

    Raises:
        InputError: With every mistake that was found.
    """
    require_fit("load source", str | Path | Mapping[str, Any], source)
    if isinstance(source, Mapping):
        return built(*read_table(source, overrides=overrides))
    return built(*read_any(source, overrides=overrides))


def built(
    scenario: Scenario | None, mistakes: list[Mistake], *, planning: bool = True
) -> PlanningTask:
    """Build the problem of a scenario that was read, or say all that is wrong with it.

    Args:
        scenario: What was read, or what is left of it.
        mistakes: What was found while it was read.
        planning: As for ``build_problem``.

    Raises:
        InputError: With every mistake that was found.
    """
    if scenario is not None:
        scenario = _for_another_planner(scenario)
        if not mistakes:
            return build_problem(scenario, planning=planning)
        _parts(scenario, mistakes)
    raise InputError(dict.fromkeys(mistakes))


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
    machine, made = _parts(scenario, mistakes, planner=planner)
    entries = scenario.world.obstacle
    moving = [o for k, some in made.items() for o in some if entries[k].motion is not None]
    obstacles = [o for k, some in made.items() for o in some if entries[k].motion is None]
    planned = [entry for entry in entries if entry.run is not None]
    models = None
    if machine is not None and len(made) + len(planned) == len(entries):
        models = _collect(mistakes, partial(_models, scenario, machine, moving))
    if models is None:
        raise InputError(mistakes)
    (whole, model), *others = models
    arrays = state_arrays(scenario, model)
    issues = [*limit_issues(scenario, model, arrays)] if planning else []
    issues += endpoint_issues(scenario, model)
    mistakes += [mistake_at(issue, scenario.origin) for issue in issues]
    if mistakes:
        raise InputError(mistakes)
    section = scenario.world
    grounded = section.ground == "plane"
    # The ground lets cables pass, which may meet what is below it.
    floors = grounded and not any(cable.collides for cable in whole.machine.cables)
    divided = [without_floor(o) if floors else (o, None) for o in obstacles]
    problem = PlanningTask(
        scenario=scenario,
        machine=whole.machine,
        model=model,
        whole=whole,
        alone=others[0] if others else None,
        world=World(
            tuple(near_each_other([rest for rest, _ in divided if rest is not None])),
            grounded,
            dict(section.bounds),
            section.clearance + max([path_error(scenario), *(o.error for o in obstacles)]),
            tuple(floor for _, floor in divided if floor is not None),
        ),
        start=start_of(scenario, model),
        goal=goal_of(scenario.goal, model, arrays.circular),
        via=tuple(goal_of(section, model, arrays.circular) for section in scenario.via),
        scales=model.state_scales,
        keep_outs=keep_outs_of(scenario, model),
        **arrays._asdict(),
    )
    if planning:
        problem = steady(problem)
        require_costs(problem)
    return problem


def _parts(
    scenario: Scenario, mistakes: list[Mistake], *, planner: bool = True
) -> tuple[ScenarioMachine | None, dict[int, tuple[Obstacle, ...]]]:
    """Return machine and obstacles without what is broken, and add what is wrong to a list."""
    made = {
        k: _collect(mistakes, partial(_obstacles, scenario, entry))
        for k, entry in enumerate(scenario.world.obstacle)
        if entry.run is None
    }
    there = {k: some for k, some in made.items() if some is not None}
    mistakes += [mistake_at(issue, scenario.origin) for issue in mesh_issues(scenario, there)]
    if not any((scenario.system.name, scenario.system.file, scenario.system.machines)):
        return None, there  # it is among the mistakes already
    machine = _collect(mistakes, partial(ScenarioMachine, scenario))
    if machine is not None:
        wrong = name_mistakes(scenario, machine.facts)
        if wrong and (further := machine.quasi_velocities()):
            wrong = name_mistakes(scenario, machine.facts, further)
        mistakes += wrong
        issues = parameter_issues(machine.facts)
        mistakes += [mistake_at(issue, scenario.origin) for issue in issues]
    if planner:
        mistakes += [mistake_at(issue, scenario.origin) for issue in planner_issues(scenario)]
    return machine, there


def _collect(mistakes: list[Mistake], make: Callable[[], T]) -> T | None:
    """Return what a function makes, or None after adding its mistakes to the list."""
    try:
        return make()
    except InputError as error:
        mistakes.extend(error.mistakes)
        return None


def _models(
    scenario: Scenario, machine: ScenarioMachine, moving: Sequence[Obstacle]
) -> list[tuple[Model, Model]]:
    """Return the machine, and with the limits of inputs that a scenario sets; twice if things move.

    First as it is among them, then as it is without them.
    """
    alone = with_regions(scenario, machine.model())
    whole = among_runs(alone, scenario, load)
    whole = among_moving(whole, scenario, moving) if moving else whole
    made = [alone] if whole is alone else [whole, alone]
    limits = {n: scenario.bounds[n] for n in chosen_names(alone.machine) if n in scenario.bounds}
    try:
        return [(whole, with_limits(whole, limits) if limits else whole) for whole in made]
    except InputError as error:
        raise InputError(
            mistake_at(Issue(("bounds", wrong.where), wrong.what, wrong.remedy), scenario.origin)
            for wrong in error.mistakes
        ) from error


def _obstacles(scenario: Scenario, entry: ObstacleEntry) -> tuple[Obstacle, ...]:
    """Make what an entry describes: one obstacle, but of a map whose unknown cells are another."""
    pose = (entry.position, entry.rpy) if entry.motion is None else (ORIGIN, ORIGIN)
    name = entry.name
    if entry.box is not None:
        return (box_obstacle(name, entry.box, *pose),)
    if entry.sphere is not None:
        return (sphere_obstacle(name, entry.sphere, *pose),)
    if entry.cylinder is not None:
        return (cylinder_obstacle(name, *entry.cylinder, *pose),)
    if entry.capsule is not None:
        return (capsule_obstacle(name, *entry.capsule, *pose),)
    file = (str(entry.file), scenario.folder)
    given: dict[str, Any] = {"scale": entry.scale, "up": entry.up, "solid": entry.solid}
    if entry.map is not None:
        return _mapped(entry, *file)
    if entry.cloud is not None:
        return (_scanned(entry, *file),)
    if entry.simplify is None:
        return (mesh_obstacle(name, *file, *pose, **given),)
    from kinolab.world.mesh_simplification import simplified  # late: few meshes need it

    whole = mesh_obstacle(
        name, *file, *pose, **given, most=ELEMENTS["triangles that are simplified"]
    )
    return (simplified(whole, entry.simplify),)


def _mapped(entry: ObstacleEntry, path: str, root: Path) -> tuple[Obstacle, ...]:
    from kinolab.world.sensed.map_obstacles import map_obstacles, relief_obstacle  # late, as above

    place = (entry.name, path, root, entry.position, entry.rpy)
    size: dict[str, Any] = {"resolution": entry.resolution, "height": entry.height}
    if entry.relief is None:
        return map_obstacles(*place, **size, unknown=entry.unknown)
    return (relief_obstacle(*place, **size, relief=entry.relief, max_slope=entry.max_slope),)


def _scanned(entry: ObstacleEntry, path: str, root: Path) -> Obstacle:
    from kinolab.world.sensed.point_cloud import cloud_obstacle  # late, as above

    assert entry.radius is not None  # by the rules of scenarios
    balls: dict[str, Any] = {"radius": entry.radius, "voxel": entry.voxel}
    place = (entry.name, path, root, entry.position, entry.rpy)
    return cloud_obstacle(*place, **balls, scale=entry.scale, up=entry.up)

"""The files below ``assets/`` of a run and their hashes, which show what was changed since."""

from __future__ import annotations

import hashlib
from pathlib import Path

from kinolab.dynamics.language.json.machine_folder import FEEDBACK_FILE, MACHINE_FILE
from kinolab.loading.build import load
from kinolab.loading.moving_obstacles import among_runs, path_error
from kinolab.problem import PlanningTask
from kinolab.scenario import ObstacleEntry, Origin, Scenario
from kinolab.scenario.schema import WorldSection
from kinolab.scenario.user_code import python_reference, text_of
from kinolab.scenario.values import ROBOT_ONLY
from kinolab.world.meshes.obj_materials import materials_file, with_materials
from kinolab.world.sensed.map_file import image_file, with_image


def assets_of(problem: PlanningTask) -> dict[str, bytes]:
    """Return the files below assets/ by name: the machine, copies of the world's and a planner."""
    world: dict[str, bytes] = {}
    for (index, _), path in _world_files(problem.scenario).items():
        content = path.read_bytes()
        beside = _beside(path, content, problem.scenario.folder)
        if beside is not None:
            name = _copy_name(index, beside)
            world[name] = beside.read_bytes()
            rename = with_materials if path.suffix.lower() == ".obj" else with_image
            content = rename(content, name)
        world[_copy_name(index, path)] = content
    file = _planner_file(problem.scenario)
    code = {file.name: text_of(file)} if file is not None else {}
    # whose feedback is a law, its gains included; the machines of other plans are part of it
    model = problem.whole or problem.model
    if problem.alone is not None:
        model = among_runs(problem.alone[0], problem.scenario, load)
    machine = {name: text.encode() for name, text in model.files.items()}
    return {**machine, **world, **code}


def _world_files(scenario: Scenario) -> dict[tuple[int, str], Path]:
    """Return the files that obstacles name, by the obstacle and whether it is shape or motion."""
    named = {
        (index, key): holder.file
        for index, entry in enumerate(scenario.world.obstacle)
        for key, holder in (("shape", entry), ("motion", entry.motion))
        if holder is not None
    }
    return {at: scenario.folder / file for at, file in named.items() if file is not None}


def _beside(path: Path, content: bytes, root: Path) -> Path | None:
    """Return the file that one of the world names: materials of a mesh, the picture of a map."""
    return materials_file(path, content, root) or image_file(path, content, root)


def _planner_file(scenario: Scenario) -> Path | None:
    """Return the file of the user's that the planner is in, if it is in one."""
    reference = python_reference(scenario.planner.name)
    return scenario.folder / reference[0] if reference else None


def _copy_name(index: int, path: Path) -> str:
    return f"{index + 1}_{path.name}"


def portable_scenario(problem: PlanningTask) -> Scenario:
    """Return the scenario with all that other files have of it taken from assets/."""
    scenario = problem.scenario
    files = _world_files(scenario)
    copies = {at: f"assets/{_copy_name(at[0], path)}" for at, path in files.items()}
    obstacles = tuple(
        _among_assets(entry, copies.get((index, "shape")), copies.get((index, "motion")))
        for index, entry in enumerate(scenario.world.obstacle)
        if entry.run is None
    )
    machine: dict[str, str | None] = {"file": f"assets/{MACHINE_FILE}"}
    machine |= {"name": None, "machines": None}
    machine |= {key: None for key, *_ in ROBOT_ONLY}
    return scenario.model_copy(
        update={
            "system": scenario.system.model_copy(update=machine),
            "planner": scenario.planner.model_copy(update={"name": _portable_planner(scenario)}),
            "world": _keeping_clearance(problem, obstacles),
        }
    ).located(Origin(Path("scenario.toml")))


def _keeping_clearance(problem: PlanningTask, kept: tuple[ObstacleEntry, ...]) -> WorldSection:
    """Return the world without other plans' machines, and with the clearance that these ask for."""
    scenario = problem.scenario
    world = scenario.world.model_copy(update={"obstacle": kept})
    left = path_error(scenario.model_copy(update={"world": world}))
    errors = [obstacle.error for obstacle in problem.world.obstacles]
    more = max([path_error(scenario), *errors]) - max([left, *errors])
    return world.model_copy(update={"clearance": world.clearance + more})


def _among_assets(entry: ObstacleEntry, shape: str | None, motion: str | None) -> ObstacleEntry:
    """Return an obstacle with its files, where it has some, taken from others."""
    changed: dict[str, object] = {} if shape is None else {entry.kind: shape}
    if entry.motion is not None and motion is not None:
        changed["motion"] = entry.motion.model_copy(update={"file": motion})
    return entry.model_copy(update=changed)


def _portable_planner(scenario: Scenario) -> str:
    """Return the planner's name, its file taken from assets/ if it has one."""
    file, name = _planner_file(scenario), scenario.planner.name
    return name if file is None else f"assets/{file.name}:{name.rpartition(':')[2]}"


def used_assets(folder: Path, problem: PlanningTask) -> set[str]:
    """Return the names of the files below ``assets/`` that a run's own scenario uses.

    Args:
        problem: Built from its scenario.
    """
    scenario = problem.scenario
    world = list(_world_files(scenario).values())
    libraries = [
        _beside(path, path.read_bytes(), folder)
        for path in world
        # endings of files that name another one
        if path.suffix.lower() in (".obj", ".yaml", ".yml") and path.is_file()
    ]
    files = [*world, *libraries, _planner_file(scenario)]
    machine = {MACHINE_FILE} | (
        {FEEDBACK_FILE} if problem.machine.references is not None else set()
    )
    return {*machine, *(path.name for path in files if path is not None)}


def digest_of(content: bytes) -> str:
    """Return the SHA-256 of a file's content."""
    return hashlib.sha256(content).hexdigest()

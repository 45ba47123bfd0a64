"""The files below ``assets/`` of a run and their hashes, which show what was changed since."""

from __future__ import annotations

import hashlib
from pathlib import Path

from kinolab.dynamics.language.json.machine_folder import FEEDBACK_FILE, MACHINE_FILE
from kinolab.loading.build import load
from kinolab.loading.moving_obstacles import among_runs
from kinolab.problem import PlanningTask
from kinolab.scenario import Origin, Scenario
from kinolab.scenario.user_code import python_reference, text_of
from kinolab.scenario.values import ROBOT_ONLY
from kinolab.world.meshes.obj_materials import materials_file, with_materials
from kinolab.world.sensed.map_file import image_file, with_image

NAMING = (".obj", ".yaml", ".yml")  # endings of files that name another one


def assets_of(problem: PlanningTask) -> dict[str, bytes]:
    """Return the files below assets/ by name: the machine, copies of the world's and a planner."""
    meshes: dict[str, bytes] = {}
    for index, path in _meshes(problem.scenario).items():
        content = path.read_bytes()
        beside = _beside(path, content, problem.scenario.folder)
        if beside is not None:
            name = _mesh_name(index, beside)
            meshes[name] = beside.read_bytes()
            rename = with_materials if path.suffix.lower() == ".obj" else with_image
            content = rename(content, name)
        meshes[_mesh_name(index, path)] = content
    file = _planner_file(problem.scenario)
    code = {file.name: text_of(file)} if file is not None else {}
    # whose feedback is a law, its gains included; the machines of other plans are part of it
    model = problem.whole or problem.model
    if problem.alone is not None:
        model = among_runs(problem.alone[0], problem.scenario, load)
    machine = {name: text.encode() for name, text in model.files.items()}
    return {**machine, **meshes, **code}


def _meshes(scenario: Scenario) -> dict[int, Path]:
    return {
        index: scenario.folder / entry.file
        for index, entry in enumerate(scenario.world.obstacle)
        if entry.file is not None
    }


def _beside(path: Path, content: bytes, root: Path) -> Path | None:
    """Return the file that one of the world names: materials of a mesh, the picture of a map."""
    return materials_file(path, content, root) or image_file(path, content, root)


def _planner_file(scenario: Scenario) -> Path | None:
    """Return the file of the user's that the planner is in, if it is in one."""
    reference = python_reference(scenario.planner.name)
    return scenario.folder / reference[0] if reference else None


def _mesh_name(index: int, path: Path) -> str:
    return f"{index + 1}_{path.name}"


def portable_scenario(problem: PlanningTask) -> Scenario:
    """Return the scenario with the machine, the meshes and the planner taken from assets/."""
    scenario = problem.scenario
    meshes = _meshes(scenario)
    obstacles = tuple(
        entry.model_copy(update={entry.kind: f"assets/{_mesh_name(index, meshes[index])}"})
        if index in meshes
        else entry
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
            "world": scenario.world.model_copy(update={"obstacle": obstacles}),
        }
    ).located(Origin(Path("scenario.toml")))


def _portable_planner(scenario: Scenario) -> str:
    """Return the planner's name, its file taken from assets/ if it has one."""
    file, name = _planner_file(scenario), scenario.planner.name
    return name if file is None else f"assets/{file.name}:{name.rpartition(':')[2]}"


def used_assets(folder: Path, problem: PlanningTask) -> set[str]:
    """Return the names of the files below ``assets/`` that a run's own scenario uses.

    Args:
        folder: Of the run.
        problem: Built from its scenario.
    """
    scenario = problem.scenario
    meshes = [path for path in _meshes(scenario).values() if path.is_file()]
    libraries = [
        _beside(path, path.read_bytes(), folder) for path in meshes if path.suffix.lower() in NAMING
    ]
    files = [*_meshes(scenario).values(), *libraries, _planner_file(scenario)]
    machine = {MACHINE_FILE} | (
        {FEEDBACK_FILE} if problem.machine.references is not None else set()
    )
    return {*machine, *(path.name for path in files if path is not None)}


def digest_of(content: bytes) -> str:
    """Return the SHA-256 of a file's content."""
    return hashlib.sha256(content).hexdigest()

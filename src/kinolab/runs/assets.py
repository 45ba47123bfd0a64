"""The files below ``assets/`` of a run and their hashes, which show what was changed since."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from kinolab.dynamics.language.json.machine_folder import FEEDBACK_FILE, MACHINE_FILE
from kinolab.problem import PlanningTask
from kinolab.scenario import Origin, Scenario
from kinolab.scenario.user_code import python_reference, text_of
from kinolab.verification import Check
from kinolab.world.meshes.obj_materials import materials_file, with_materials


def assets_of(problem: PlanningTask) -> dict[str, bytes]:
    """Return the files below assets/ by name: the machine, copies of meshes and of a planner."""
    meshes: dict[str, bytes] = {}
    for index, path in _meshes(problem.scenario).items():
        content = path.read_bytes()
        library = materials_file(path, content, problem.scenario.folder)
        if library is not None:
            meshes[_mesh_name(index, library)] = library.read_bytes()
            content = with_materials(content, _mesh_name(index, library))
        meshes[_mesh_name(index, path)] = content
    file = _planner_file(problem.scenario)
    code = {file.name: text_of(file)} if file is not None else {}
    model = problem.whole or problem.model  # whose feedback is a law, its gains included
    machine = {name: text.encode() for name, text in model.files.items()}
    return {**machine, **meshes, **code}


def _meshes(scenario: Scenario) -> dict[int, Path]:
    return {
        index: scenario.folder / entry.mesh
        for index, entry in enumerate(scenario.world.obstacle)
        if entry.mesh is not None
    }


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
        entry.model_copy(update={"mesh": f"assets/{_mesh_name(index, meshes[index])}"})
        if index in meshes
        else entry
        for index, entry in enumerate(scenario.world.obstacle)
    )
    machine = {"name": None, "file": f"assets/{MACHINE_FILE}"}
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


def hashes_of(assets: Mapping[str, bytes]) -> dict[str, str]:
    """Return the SHA-256 of each file, by name."""
    return {name: _digest(content) for name, content in assets.items()}


def unchanged(folder: Path, problem: PlanningTask, report: Mapping[str, Any]) -> Check:
    """Compare the files that a run's scenario uses with the hashes in its report."""
    recorded = report.get("assets")
    hashes = recorded if isinstance(recorded, dict) else {}
    scenario = problem.scenario
    meshes = [path for path in _meshes(scenario).values() if path.is_file()]
    libraries = [
        materials_file(path, path.read_bytes(), folder)
        for path in meshes
        if path.suffix.lower() == ".obj"
    ]
    files = [*_meshes(scenario).values(), *libraries, _planner_file(scenario)]
    machine = {MACHINE_FILE} | (
        {FEEDBACK_FILE} if problem.machine.references is not None else set()
    )
    used = {*machine, *(path.name for path in files if path is not None)}
    changed = [
        name
        for name in sorted(used | set(hashes))
        if _digest_of(folder / "assets" / Path(name).name) != hashes.get(name)
    ]
    detail = f"changed since the run, or not listed: {', '.join(changed)}" if changed else ""
    return Check("assets", float(len(changed)), 0.0, not changed, detail)


def _digest_of(path: Path) -> str | None:
    if not path.is_file():
        return None
    with path.open("rb") as file:  # which may be larger than memory
        return hashlib.file_digest(file, "sha256").hexdigest()


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()

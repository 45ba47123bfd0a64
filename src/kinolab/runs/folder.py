"""The folder of a run: everything needed to check, draw and mail a plan.

Every file is written whole or not at all. The folder is self-contained: the scenario in it points
at copies of the machine, of all meshes and of a planner's file below ``assets/``. Reading it back
runs no code: the machine is data, and the planner is not asked again.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from kinolab.dynamics.language.json.machine_file import (
    FEEDBACK_FILE,
    feedback_to_json,
    machine_to_json,
)
from kinolab.errors import InputError, Mistake
from kinolab.files import utf_8, write_whole
from kinolab.loading import build_problem
from kinolab.problem import Problem
from kinolab.problem.goal_entries import distance_by_unit, goal_entries
from kinolab.problem.unwrapping import unwrapped
from kinolab.runs.dynobench_result import has_its_steps, result_text
from kinolab.runs.plot_files import FILES
from kinolab.scenario import Origin, Scenario, load_scenario, write_scenario
from kinolab.scenario.dynobench import is_environment
from kinolab.search.graph import SearchGraph, read_graph
from kinolab.solve import Plan
from kinolab.trajectory import Trajectory, read_csv
from kinolab.user_code import python_reference, text_of
from kinolab.verification import Certificate, Check, verify

SCHEMA_VERSION = 1
PAGE, MODEL = "scene.html", "result.glb"  # the plan in three dimensions
EXECUTION = ("execution.json", "execution.png")  # of the plan in the folder, by ``plan execute``
RECORDED = ("numpy", "scipy", "sympy", "numba", "llvmlite", "ompl", "python-fcl")
MOTION = ("trajectory.csv", "trajectory.npz", "search.npz")
PLOTS = tuple(f"plots/{name}" for name in FILES)  # by ``plan plot``
PICTURES = ("animation.gif", "animation.mp4", PAGE, MODEL)
OPTIONAL = (*MOTION, "result.yaml", *PICTURES, *EXECUTION, *PLOTS)


@dataclass(frozen=True)
class Run:
    """A finished run, read back from its folder."""

    folder: Path
    problem: Problem
    report: dict[str, Any]
    trajectory: Trajectory

    @property
    def graph(self) -> SearchGraph | None:
        """What the search explored, None where that was not kept.

        Raises:
            InputError: If its file is damaged.
        """
        path = self.folder / "search.npz"
        return read_graph(path, self.problem.model.state_names) if path.is_file() else None


def write_run(folder: Path, problem: Problem, plan: Plan) -> dict[str, Any]:
    """Write all files of a run but its pictures, and return its report.

    Files of an earlier run in the same folder are replaced; what this run does not have is
    removed, so that the folder never mixes two runs.
    """
    assets = _assets(problem)
    report = _report(problem, plan, assets)
    files: dict[str, bytes] = {f"assets/{name}": content for name, content in assets.items()}
    files["scenario.toml"] = write_scenario(_portable(problem)).encode()
    if plan.trajectory is not None:
        files["trajectory.csv"] = plan.trajectory.to_csv().encode()
        files["trajectory.npz"] = plan.trajectory.to_npz()
        files |= _benchmark_result(problem, plan.trajectory) if plan.status == "solved" else {}
    if plan.graph is not None:
        files["search.npz"] = plan.graph.to_npz(problem.model.state_names)
    files["report.json"] = _json(report)
    stale = {*OPTIONAL, *_recorded_assets(folder)} - set(files)
    (folder / "assets").mkdir(parents=True, exist_ok=True)
    (folder / "report.json").unlink(missing_ok=True)  # a report vouches for the files beside it
    for name in stale:
        (folder / name).unlink(missing_ok=True)
    for name, content in files.items():
        write_whole(folder / name, content)
    return report


def _benchmark_result(problem: Problem, trajectory: Trajectory) -> dict[str, bytes]:
    """Return the file that the benchmark reads, for its own environments."""
    if not is_environment(problem.scenario.origin.file) or not has_its_steps(problem, trajectory):
        return {}
    return {"result.yaml": result_text(problem, trajectory).encode()}


def add_diagnosis(
    folder: Path, report: Mapping[str, Any], diagnosis: Mapping[str, Any]
) -> dict[str, Any]:
    """Write the report of a run once more, with what was found out since, and return it.

    Args:
        folder: Of the run, whose other files stay.
        report: As ``write_run`` returned it.
        diagnosis: What is added to its ``diagnosis``.
    """
    whole = {**report, "diagnosis": {**report["diagnosis"], **diagnosis}}
    write_whole(folder / "report.json", _json(whole))
    return whole


def _json(report: Mapping[str, Any]) -> bytes:
    return utf_8(json.dumps(report, indent=1, ensure_ascii=False) + "\n")


def _recorded_assets(folder: Path) -> set[str]:
    """Return the assets of an earlier run, as its report lists them."""
    try:
        recorded = json.loads((folder / "report.json").read_text(encoding="utf-8"))["assets"]
        return {f"assets/{Path(name).name}" for name in recorded}
    except (OSError, LookupError, RecursionError, TypeError, ValueError):
        return set()


def writable(folder: Path) -> bool:
    """Whether a folder can be written, or made, before hours of search end in its refusal."""
    place = folder.absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    return place.is_dir() and os.access(place, os.W_OK | os.X_OK)


def read_run(folder: Path) -> Run:
    """Read a run back from its files alone.

    Raises:
        InputError: If a file is missing or damaged.
    """
    missing = [
        Mistake(str(folder / name), "there is no such file.", "Give the folder of a finished run.")
        for name in ("scenario.toml", "report.json", "trajectory.csv")
        if not (folder / name).is_file()
    ]
    if missing:
        raise InputError(missing)
    try:
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        if not isinstance(report, dict):
            raise ValueError("it is not an object")
    except (RecursionError, ValueError) as error:
        what = f"the report is damaged ({error})."
        raise InputError([Mistake(str(folder / "report.json"), what)]) from error
    scenario = load_scenario(folder / "scenario.toml")
    if not (scenario.system.file or "").endswith(".json"):
        where = str(folder / "scenario.toml [system] file")
        what = "a finished run carries its machine as data, in assets/machine.json."
        raise InputError([Mistake(where, what, "Nothing was run.")])
    problem = build_problem(scenario, planner=False)
    model, plant = problem.model, problem.model.plant
    references = () if plant is model else model.control_names
    trajectory = read_csv(
        folder / "trajectory.csv", model.state_names, plant.control_names, references
    )
    return Run(folder, problem, report, unwrapped(problem, trajectory))


def check_run(folder: Path) -> Certificate:
    """Verify a finished run from its files alone.

    Raises:
        InputError: If a file is missing or damaged.
    """
    run = read_run(folder)
    certificate = verify(run.problem, run.trajectory)
    return replace(certificate, checks=(_intact(run), *certificate.checks))


def _intact(run: Run) -> Check:
    """Compare the files that the scenario uses with the hashes in the report."""
    recorded = run.report.get("assets")
    hashes = recorded if isinstance(recorded, dict) else {}
    scenario = run.problem.scenario
    files = [*_meshes(scenario).values(), _planner_file(scenario)]
    machine = {"machine.json"} | ({FEEDBACK_FILE} if run.problem.system.feedback else set())
    used = {*machine, *(path.name for path in files if path is not None)}
    changed = [
        name
        for name in sorted(used | set(hashes))
        if _digest_of(run.folder / "assets" / Path(name).name) != hashes.get(name)
    ]
    detail = f"changed since the run, or not listed: {', '.join(changed)}" if changed else ""
    return Check("assets", float(len(changed)), 0.0, not changed, detail)


def _digest_of(path: Path) -> str | None:
    return _digest(path.read_bytes()) if path.is_file() else None


def _assets(problem: Problem) -> dict[str, bytes]:
    """Return the files below assets/ by name: the machine, copies of meshes and of a planner."""
    meshes = {
        _mesh_name(index, path): path.read_bytes()
        for index, path in _meshes(problem.scenario).items()
    }
    file = _planner_file(problem.scenario)
    code = {file.name: text_of(file)} if file is not None else {}
    system = problem.system  # whose feedback is a law, its gains included
    machine = {"machine.json": machine_to_json(system.with_feedback(None)).encode()}
    if system.feedback is not None:
        machine[FEEDBACK_FILE] = feedback_to_json(system.feedback).encode()
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


def _portable(problem: Problem) -> Scenario:
    """Return the scenario with the machine, the meshes and the planner taken from assets/."""
    scenario = problem.scenario
    meshes = _meshes(scenario)
    obstacles = tuple(
        entry.model_copy(update={"mesh": f"assets/{_mesh_name(index, meshes[index])}"})
        if index in meshes
        else entry
        for index, entry in enumerate(scenario.world.obstacle)
    )
    machine = {"name": None, "file": "assets/machine.json"}
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


def _report(problem: Problem, plan: Plan, assets: Mapping[str, bytes]) -> dict[str, Any]:
    certificate = plan.certificate
    return {
        "schema_version": SCHEMA_VERSION,
        "scenario": problem.name,
        "system": problem.system.name,
        "status": plan.status,
        "message": plan.message,
        "planner": plan.planner,
        "seed": plan.seed,
        "iterations": plan.iterations,
        "cost": plan.cost,
        "duration": plan.cost,
        "goal_distance": _finite(plan.goal_distance),
        "goal_distance_by_unit": goal_distance_by_unit(problem, plan),
        "jobs": plan.jobs,
        "attempts": [asdict(attempt) for attempt in plan.attempts],
        "refused": plan.refused,
        "interrupted": plan.interrupted,
        "improvements": [asdict(improvement) for improvement in plan.improvements],
        "timings": plan.timings,
        "statistics": plan.statistics,
        "verification": [
            check_to_json(check) for check in (certificate.checks if certificate else ())
        ],
        "margin": margin_to_json(certificate),
        "warnings": list(problem.world.warnings),
        "diagnosis": {"rejections": plan.rejections},
        "assets": {name: _digest(content) for name, content in assets.items()},
        "versions": _versions(),
    }


def check_to_json(check: Check) -> dict[str, Any]:
    """Return a check as plain data; what is not finite becomes null."""
    return {**asdict(check), "value": _finite(check.value)}


def margin_to_json(certificate: Certificate | None) -> dict[str, Any] | None:
    """Return a verified motion's smallest clearance as plain data, in m and s; null without one."""
    if certificate is None or certificate.margin is None:
        return None
    return asdict(certificate.margin)


def goal_distance_by_unit(problem: Problem, plan: Plan) -> dict[str, float] | None:
    """Return how far a plan ends from the goal's centre in each unit; null where it has no end.

    The report's ``goal_distance`` is the norm of these, of whatever units.
    """
    if plan.trajectory is None:
        return None
    return distance_by_unit(goal_entries(problem, plan.trajectory.x[-1]))


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for package in ("kinolab", *RECORDED):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "absent"
    return found


def _finite(value: float) -> float | None:
    """JSON has neither NaN nor infinity."""
    return value if math.isfinite(value) else None


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()

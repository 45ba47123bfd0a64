"""The folder of a run: everything needed to check, draw and mail a plan.

Every file is written whole or not at all. The folder is self-contained: the scenario in it points
at copies of the machine and of all meshes below ``assets/``.
"""

from __future__ import annotations

import hashlib
import json
import math
import platform
import secrets
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from kinolab.dynamics.machine_file import machine_to_json
from kinolab.errors import InputError, Mistake
from kinolab.loading import load
from kinolab.planning import Plan
from kinolab.problem import Problem
from kinolab.scenario import Origin, Scenario, write_scenario
from kinolab.trajectory import Trajectory, read_csv
from kinolab.verification import Certificate, Check, verify

SCHEMA_VERSION = 1
RECORDED = ("kinolab", "numpy", "scipy", "sympy", "numba", "llvmlite", "ompl", "python-fcl")
OPTIONAL = ("trajectory.csv", "trajectory.npz", "animation.gif")


@dataclass(frozen=True)
class Run:
    """A finished run, read back from its folder."""

    folder: Path
    problem: Problem
    report: dict[str, Any]
    trajectory: Trajectory


def write_run(
    folder: Path, problem: Problem, plan: Plan, *, animation: bytes | None = None
) -> dict[str, Any]:
    """Write all files of a run and return its report.

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
    if animation is not None:
        files["animation.gif"] = animation
    files["report.json"] = (json.dumps(report, indent=1, ensure_ascii=False) + "\n").encode()
    (folder / "assets").mkdir(parents=True, exist_ok=True)
    (folder / "report.json").unlink(missing_ok=True)  # a report vouches for the files beside it
    for name in OPTIONAL:
        if name not in files:
            (folder / name).unlink(missing_ok=True)
    for name, content in files.items():
        _write_whole(folder / name, content)
    return report


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
    except ValueError as error:
        what = f"the report is damaged ({error})."
        raise InputError([Mistake(str(folder / "report.json"), what)]) from error
    problem = load(folder / "scenario.toml")
    model = problem.model
    trajectory = read_csv(folder / "trajectory.csv", model.state_names, model.control_names)
    return Run(folder, problem, report, trajectory)


def check_run(folder: Path) -> Certificate:
    """Verify a finished run from its files alone.

    Raises:
        InputError: If a file is missing or damaged.
    """
    run = read_run(folder)
    certificate = verify(run.problem, run.trajectory)
    return Certificate((_intact(run), *certificate.checks))


def _intact(run: Run) -> Check:
    """Compare the assets with the hashes in the report."""
    recorded = run.report.get("assets")
    changed = []
    for name, digest in recorded.items() if isinstance(recorded, Mapping) else ():
        path = run.folder / "assets" / name
        if not path.is_file() or _digest(path.read_bytes()) != digest:
            changed.append(name)
    if not recorded:
        changed.append("the list of assets is missing")
    detail = f"changed since the run: {', '.join(changed)}" if changed else ""
    return Check("assets", float(len(changed)), 0.0, not changed, detail)


def _assets(problem: Problem) -> dict[str, bytes]:
    """Return the files below assets/ by name: the machine, and a copy of every mesh."""
    meshes = {
        _mesh_name(index, path): path.read_bytes()
        for index, path in _meshes(problem.scenario).items()
    }
    return {"machine.json": machine_to_json(problem.system).encode(), **meshes}


def _meshes(scenario: Scenario) -> dict[int, Path]:
    return {
        index: scenario.folder / entry.mesh
        for index, entry in enumerate(scenario.world.obstacle)
        if entry.mesh is not None
    }


def _mesh_name(index: int, path: Path) -> str:
    return f"{index + 1}_{path.name}"


def _portable(problem: Problem) -> Scenario:
    """Return the scenario with the machine and the meshes taken from assets/."""
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
            "world": scenario.world.model_copy(update={"obstacle": obstacles}),
        }
    ).located(Origin(Path("scenario.toml")))


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
        "timings": plan.timings,
        "statistics": plan.statistics,
        "verification": [
            {**asdict(check), "value": _finite(check.value)}
            for check in (certificate.checks if certificate else ())
        ],
        "diagnosis": {},
        "assets": {name: _digest(content) for name, content in assets.items()},
        "versions": _versions(),
    }


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for package in RECORDED:
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


def _write_whole(path: Path, content: bytes) -> None:
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        draft.write_bytes(content)
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)

"""The folder of a run: everything needed to check, draw and mail a plan.

Every file is written whole or not at all. The folder is self-contained: the scenario in it points
at copies of the machine, of all files of the world and of a planner's below ``assets/``. Reading it
back runs no code: the machine is data, and the planner is not asked again.
"""

from __future__ import annotations

import io
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from kinolab.dynamics.language.json.machine_folder import MACHINE_FILE
from kinolab.errors import InputError, Mistake
from kinolab.files import (
    discard_abandoned,
    is_file_with,
    only_writer,
    utf_8,
    write_together,
    write_whole,
)
from kinolab.loading import build_problem
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.unwrapping import unwrapped
from kinolab.runs.assets import assets_of, digest_of, portable_scenario
from kinolab.runs.certificate_file import CERTIFICATE, TUBE, certificate_to_json, unchanged
from kinolab.runs.dynobench_result import has_its_steps, result_text
from kinolab.runs.readme import README, readme_of
from kinolab.runs.report import report_of
from kinolab.scenario import load_scenario, write_scenario
from kinolab.scenario.dynobench import is_environment
from kinolab.search.graph import SearchGraph, read_graph
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory, read_csv
from kinolab.untrusted import array_file, json_file, why
from kinolab.verification import Certificate, Check, verify
from kinolab.verification.between_samples.clearance_search import Told

PAGE, MODEL = "scene.html", "result.glb"  # the plan in three dimensions
FILM = "animation.gif"
EXECUTION = ("execution.json", "execution.csv", "execution.png")  # by ``plan execute``
NPZ = "trajectory.npz"
MACHINE = f"assets/{MACHINE_FILE}"
DERIVED = (NPZ, "result.yaml")  # they say what trajectory.csv says
MOTION_FORMATS: dict[str, Callable[[Trajectory], bytes]] = {  # every one is written in every run
    "trajectory.csv": lambda trajectory: trajectory.to_csv().encode(),
    NPZ: Trajectory.to_npz,
}
PLOT_NAMES = ("states", "inputs", "phase", "configuration")  # by ``plan plot``
PLOTS = tuple(f"plots/{name}.{form}" for form in ("svg", "png") for name in PLOT_NAMES)
PICTURES = (FILM, "animation.mp4", PAGE, MODEL)
OPTIONAL = (CERTIFICATE, TUBE, "search.npz", "result.yaml", *PICTURES, *EXECUTION, *PLOTS)


@dataclass(frozen=True)
class Run:
    """A finished run, read back from its folder."""

    folder: Path
    problem: PlanningTask
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


def write_run(
    folder: Path,
    problem: PlanningTask,
    plan: PlanResult,
    pictures: Callable[[dict[str, Any]], Mapping[str, bytes]] = lambda _: {},
) -> dict[str, Any]:
    """Write all files of a run, and return its report.

    Files of an earlier run in the same folder are replaced; what this run does not have is
    removed, so that the folder never mixes two runs. If several processes do so at once, one
    writes after the other. An earlier run of the same scenario stays as it is until all new files
    are complete, which a full disk may prevent.

    Args:
        problem: What was planned.
        plan: What came of it.
        pictures: Returns files of ``PICTURES`` by name, of the run's report.
    """
    assets = assets_of(problem)
    files: dict[str, bytes] = {f"assets/{name}": content for name, content in assets.items()}
    files["scenario.toml"] = write_scenario(portable_scenario(problem)).encode()
    if plan.trajectory is not None:
        files |= {name: write(plan.trajectory) for name, write in MOTION_FORMATS.items()}
        for_benchmark = is_environment(problem.scenario.origin.file)
        if for_benchmark and plan.status == "solved" and has_its_steps(problem, plan.trajectory):
            files["result.yaml"] = result_text(problem, plan.trajectory).encode()
    certified = None
    if plan.trajectory is not None and plan.certificate is not None:
        proved = {name: content for name, content in files.items() if name not in DERIVED}
        files[CERTIFICATE] = _json(certificate_to_json(problem, plan.certificate, proved))
        certified = digest_of(files[CERTIFICATE])
    if plan.claim is not None:
        from kinolab.runs.tube_file import tube_text, tube_to_json

        files[TUBE] = tube_text(tube_to_json(plan.claim, files))
    if plan.graph is not None:
        files["search.npz"] = plan.graph.to_npz(problem.model.state_names)
    files[README] = utf_8(readme_of(problem, plan))
    report = report_of(problem, plan, assets, certified)
    report["scenario_file"] = os.path.relpath(_source(problem), folder.resolve())
    files |= pictures(report)
    files["report.json"] = _json(report)  # last: it vouches for the files beside it
    (folder / "assets").mkdir(parents=True, exist_ok=True)
    with only_writer(folder):
        stale = {*MOTION_FORMATS, *OPTIONAL, *_recorded_assets(folder)} - set(files)

        def discard_earlier() -> None:
            for name in ("report.json", *stale):
                (folder / name).unlink(missing_ok=True)

        discard_abandoned(folder / "plots")
        # There may be thousands of meshes, too many to be written together.
        paths = {folder / f"assets/{name}": content for name, content in assets.items()}
        changed = {path for path, content in paths.items() if not is_file_with(path, content)}
        if changed:
            discard_earlier()
        for path in changed:
            write_whole(path, paths[path])
        others = {folder / name: content for name, content in files.items()}
        write_together({p: others[p] for p in others if p not in paths}, discard_earlier)
    return report


@contextmanager
def still_there(folder: Path, report: Mapping[str, Any]) -> Iterator[bool]:
    """Let no other run be written into a folder, and tell whether none was meanwhile.

    Args:
        report: Of that run.

    Raises:
        OSError: If there is no report any more.
    """
    with only_writer(folder):
        yield (folder / "report.json").read_bytes() == _json(report)


def add_to_report(
    folder: Path, report: Mapping[str, Any], found: Mapping[str, Any]
) -> dict[str, Any]:
    """Write the report of a run once more, with what was found out since, and return it.

    A report of another run, which was written into the folder meanwhile, stays.

    Args:
        folder: Of the run, whose other files stay.
        report: As ``write_run`` returned it.
        found: Values of its keys.
    """
    whole = {**report, **found}
    with still_there(folder, report) as there:
        if there:
            write_whole(folder / "report.json", _json(whole))
    return whole


def _json(report: Mapping[str, Any]) -> bytes:
    return utf_8(json.dumps(report, indent=1, ensure_ascii=False) + "\n")


def _recorded_assets(folder: Path) -> set[str]:
    """Return the assets of an earlier run, as its report lists them."""
    try:
        recorded = json_file(folder / "report.json")["assets"]
        return {f"assets/{Path(name).name}" for name in recorded}
    except (OSError, LookupError, RecursionError, TypeError, ValueError):
        return set()


def require_place(folder: Path) -> None:
    """Refuse a folder that no run can be written into, before hours of search.

    Raises:
        InputError: If it can be neither written nor made, or holds a scenario that no run wrote,
            which would be lost.
    """
    place = folder.absolute()
    while not os.path.lexists(place) and place != place.parent:  # links to nowhere are there
        place = place.parent
    what = ""
    if not (place.is_dir() and os.access(place, os.W_OK | os.X_OK)):
        what = "this folder cannot be written."
    elif (folder / "scenario.toml").exists() and not (folder / "assets/machine.json").exists():
        what = "this folder has a scenario.toml of its own, which the run's would replace."
    if what:
        raise InputError([Mistake(str(folder), what, "Name another.")])


def replaced_scenario(folder: Path, problem: PlanningTask) -> Path | None:
    """Return the scenario's file of a run that another scenario's would replace; None if it won't.

    Scenarios of one name in several folders share the folder of their runs, unless told otherwise.
    """
    try:
        report = json_file(folder / "report.json")
        earlier = (folder.resolve() / report["scenario_file"]).resolve()
    except (OSError, LookupError, RecursionError, TypeError, ValueError):
        return None
    return None if earlier == _source(problem) else earlier


def written_at(folder: Path) -> datetime | None:
    """Return the local time at which a run was written into a folder; None if there is none."""
    try:
        return datetime.fromtimestamp((folder / "report.json").stat().st_mtime).astimezone()
    except (OSError, OverflowError, ValueError):  # of a clock that is thousands of years off
        return None


def _source(problem: PlanningTask) -> Path:
    return problem.scenario.origin.file.resolve()


def read_run(folder: Path, *, planned: bool = True) -> Run:
    """Read a run back from its files alone.

    Args:
        planned: Whether its goal has to ask for something; that of a simulated motion need not.

    Raises:
        InputError: If a file is missing or damaged.
    """
    if not folder.is_dir():
        what = "there is no such folder."
        raise InputError([Mistake(str(folder), what, "Give the folder of a finished run.")])
    if (folder / "report.json").is_file() and not (folder / "trajectory.csv").is_file():
        what = "it has no motion (trajectory.csv): the search found none, or the file was moved."
        raise InputError([Mistake(str(folder), what, "Plan again, or give another run's folder.")])
    missing = [
        Mistake(str(folder / name), "there is no such file.", "Give the folder of a finished run.")
        for name in ("scenario.toml", "report.json", "trajectory.csv")
        if not (folder / name).is_file()
    ]
    if missing:
        raise InputError(missing)
    try:
        report = json_file(folder / "report.json")
        if not isinstance(report, dict):
            raise ValueError("it is not an object")
    except (OSError, RecursionError, ValueError) as error:
        what = f"the report is damaged ({why(error)})."
        raise InputError([Mistake(str(folder / "report.json"), what)]) from error
    scenario = load_scenario(folder / "scenario.toml")
    if scenario.system.file != MACHINE:
        where = str(folder / "scenario.toml [system] file")
        what = f"a finished run carries its machine as data, in {MACHINE}."
        raise InputError([Mistake(where, what, "Nothing was run.")])
    problem = build_problem(scenario, planner=False)
    if planned:
        problem.require_goal()
    return Run(folder, problem, report, unwrapped(problem, _motion_in(folder, problem)))


def _motion_in(folder: Path, problem: PlanningTask) -> Trajectory:
    model, plant = problem.model, problem.model.plant
    references = () if plant is model else model.control_names
    return read_csv(folder / "trajectory.csv", model.state_names, plant.control_names, references)


def check_run(folder: Path, told: Told | None = None, *, thorough: bool = False) -> Certificate:
    """Verify a finished run from its files alone.

    What is verified is ``trajectory.csv``; a ``trajectory.npz`` beside it must say the same. What a
    ``tube.json`` beside it says is proved again.

    Args:
        told: Called now and then with what is being done, in words.
        thorough: As ``verify``.

    Raises:
        InputError: If a file is missing or damaged.
    """
    run = read_run(folder)
    certificate = verify(run.problem, run.trajectory, told, thorough=thorough)
    files = [unchanged(run.folder, run.problem, run.report)]
    if (folder / NPZ).is_file():
        files.append(_same_in_npz(folder, _motion_in(folder, run.problem)))
    if (folder / TUBE).is_file():
        from kinolab.runs.tube_file import check_tube

        files.append(check_tube(folder, run.problem, run.trajectory))
    if certificate.cost is not None:
        files.append(_same_cost(certificate.cost, run.report.get("cost")))
    return replace(certificate, checks=(*files, *certificate.checks))


def _same_cost(cost: float, told: object) -> Check:
    """Compare what the report says that a motion costs with what it costs."""
    off = abs(cost - told) if isinstance(told, int | float) else math.inf
    # 1e-6 of a cost: what its integration and the rounding of files leave, and more
    limit = 1e-6 * abs(cost)
    detail = "" if off <= limit else f"the report says {told}, and it is {cost:.9g}"
    return Check("cost", off, limit, off <= limit, detail)


def _same_in_npz(folder: Path, motion: Trajectory) -> Check:
    """Compare ``trajectory.npz`` with the motion of ``trajectory.csv``, bit for bit."""
    wanted = np.load(io.BytesIO(motion.to_npz()))
    try:
        found = array_file(folder / NPZ)
    except (OSError, ValueError) as error:
        return Check(NPZ, math.inf, 0.0, False, f"it cannot be read ({why(error)})")
    differing = [
        name
        for name in sorted({*wanted.files, *found})
        if not (name in found and name in wanted and _equal(found[name], wanted[name]))
    ]
    detail = f"it differs from trajectory.csv in {', '.join(differing)}" if differing else ""
    return Check(NPZ, float(len(differing)), 0.0, not differing, detail)


def _equal(a: Array, b: Array) -> bool:
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()

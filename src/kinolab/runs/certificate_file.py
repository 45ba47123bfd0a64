"""``certificate.json``: what was proved of a plan, and of which files, so that changes show."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from kinolab.problem import PlanningTask
from kinolab.runs.assets import digest_of, used_assets
from kinolab.runs.report import check_to_json, margin_to_json, versions
from kinolab.untrusted import json_file
from kinolab.verification import Certificate, Check
from kinolab.verification.between_samples.dense_motion import MAX_SPACING

CERTIFICATE, TUBE = "certificate.json", "tube.json"
NOT_PROVED = (
    "That the machine is as it is described: its masses, friction and shapes were taken as given.",
    "That a machine which is disturbed, or differs from its description, follows the plan: "
    "`plan execute` tries that.",
    "Anything about what is not in the scenario, such as bodies without shapes, and pairs of "
    "bodies that are not listed in `collisions`.",
    "What the equations of motion hide from an integrator whose steps are no longer than "
    f"{100 * MAX_SPACING:g} cm of motion: its errors and rounding are controlled, not enclosed. "
    "Between samples, speeds, requirements and limits are enclosed by interval arithmetic. "
    "Requirements of very many operations, positions of bodies in the workspace, and the motion of "
    "a scenario whose truth is discrete are sampled.",
    "Who wrote these files: hashes show what changed by accident, and are no signature.",
)


def proved(problem: PlanningTask, certificate: Certificate) -> Iterator[str]:
    """Yield what follows from checks that all passed, in sentences."""
    settings, value = problem.scenario.integration, {c.name: c.value for c in certificate.checks}
    if settings.truth == "discrete":
        yield (
            "From the start in scenario.toml, each row of trajectory.csv follows from the one "
            f"before by a step of the integrator {settings.method!r} with the machine in "
            "assets/machine.json: the scenario takes these steps, not the equations of motion, "
            "for the truth."
        )
    else:
        yield (
            "From the start in scenario.toml, under the inputs in trajectory.csv, the machine in "
            "assets/machine.json moves as the rows of trajectory.csv say: an integrator that no "
            "planner uses has followed the motion."
        )
    if "equations" in value:
        yield (
            "Its equations of motion, derived a second way, agree with those that were integrated, "
            "at the rows that were compared."
        )
    yield "Inputs, coordinates and velocities stay within their limits."
    if problem.machine.constraints:
        yield "The machine's constraints hold."
    if problem.machine.requirements:
        yield "The machine's requirements are met."
    yield "The motion ends in the goal, within the tolerances given here."
    if certificate.margin is None:
        yield "There is nothing that anything could touch."
    else:
        yield (
            "No body or cable touches an obstacle, nor any other listed in `collisions`, also "
            "between the rows; the clearance given here is the smallest along the motion."
        )
    if certificate.reached:
        times = ", ".join(f"{time:.6g}" for time in certificate.reached)
        yield f"It reaches its goals, as they are written, at {times} s."
    section = problem.scenario.objective
    if section is not None and certificate.cost is not None:
        yield f"By [objective] the motion costs {certificate.cost:.9g}, integrated anew."
        if section.max_time is not None:
            yield f"It takes no longer than {section.max_time:g} s."
    if "error growth" in value:
        grown = max(value["error growth"], 1.0)
        yield f"A small error at the start grows about {grown:.3g} times as large by the end."


def certificate_to_json(
    problem: PlanningTask, certificate: Certificate, files: Mapping[str, bytes]
) -> dict[str, Any]:
    """Return a certificate as plain data.

    Args:
        problem: What was planned.
        certificate: The results of all checks.
        files: Content of the files that it is about, by their names in the run's folder.
    """
    return {
        "schema_version": 1,
        "scenario": problem.name,
        "system": problem.machine.name,
        "passed": certificate.passed,
        "checks": [check_to_json(check) for check in certificate.checks],
        "margin": margin_to_json(certificate),
        "cost": certificate.cost,
        "reached": list(certificate.reached),
        "conditions": asdict(certificate.conditions) if certificate.conditions else {},
        "proved": list(proved(problem, certificate) if certificate.passed else ()),
        "not_proved": list(NOT_PROVED),
        "files": {name: digest_of(content) for name, content in sorted(files.items())},
        "versions": versions(),
    }


def unchanged(folder: Path, problem: PlanningTask, report: Mapping[str, Any]) -> Check:
    """Compare the files of a run with the hashes in its certificate.

    Its report has the hash of the certificate, and those of the assets, which are all there is of
    a run that has no certificate.
    """
    assets = _table(report.get("assets"))
    recorded = {f"assets/{Path(name).name}": digest for name, digest in assets.items()}
    changed = set()
    if (digest := report.get("certificate")) is not None:
        certified = _table(_parsed(folder / CERTIFICATE).get("files"))
        if _digest_at(folder / CERTIFICATE) != digest:
            changed.add(CERTIFICATE)
        elif recorded != {
            name: certified[name] for name in certified if name.startswith("assets/")
        }:
            changed.add("report.json")
        recorded |= certified
    used = {f"assets/{name}" for name in used_assets(folder, problem)}
    for name in {*recorded, *used}:
        found = _digest_at(folder / name) if _is_below(folder, name) else None
        if found is None or found != recorded.get(name):
            changed.add(name)
    detail = f"changed since the run, missing, or not listed: {', '.join(sorted(changed))}"
    return Check("files", float(len(changed)), 0.0, not changed, detail if changed else "")


def _is_below(folder: Path, name: str) -> bool:
    """Whether a name that a file gives leads to nowhere outside the run's folder."""
    try:
        return folder.resolve() in (folder / name).resolve().parents
    except (OSError, ValueError):
        return False


def _digest_at(path: Path) -> str | None:
    """Return the SHA-256 of a file; None where there is no ordinary one."""
    try:
        if not path.is_file():
            return None
        with path.open("rb") as file:  # which may be larger than memory
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, ValueError):
        return None


def _parsed(path: Path) -> dict[str, Any]:
    try:
        return _table(json_file(path))
    except (OSError, RecursionError, ValueError):
        return {}


def _table(found: Any) -> dict[str, Any]:
    return found if isinstance(found, dict) else {}

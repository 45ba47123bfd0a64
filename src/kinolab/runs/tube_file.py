"""``tube.json``: what is proved of all machines that may carry a plan out, and of which files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from kinolab.files import utf_8, write_whole
from kinolab.problem import PlanningTask
from kinolab.runs.assets import digest_of
from kinolab.runs.certificate_file import TUBE
from kinolab.trajectory import Trajectory
from kinolab.untrusted import json_file, why
from kinolab.verification import Check
from kinolab.verification.tube.claim import Claim, proof_to_json, proved_again
from kinolab.verification.tube.uncertainty import Uncertainty

ABOUT = ("scenario.toml", "trajectory.csv")  # assets are listed in the report, whose hashes count
NOT_PROVED = (
    "That the machine's equations of motion are those of the real one: only its parameters vary.",
    "That bodies which rest on the ground do not sink into it, that the machine's requirements are "
    "met, and that speeds stay within their limits.",
    "What a computer does between two steps of its feedback: it acts at the rows of the plan, at "
    "once, and inputs are held between them.",
    "Anything about machines that begin elsewhere than the plan does.",
    "The clearance of the plan itself, which is the certificate's.",
)


def tube_to_json(claim: Claim, files: Mapping[str, bytes]) -> dict[str, Any]:
    """Return a claim as plain data, with the hashes of the run's files that it is about."""
    return {
        "schema_version": 1,
        "asked": claim.asked.to_json(),
        "share": claim.share if claim.best is not None else 0.0,
        "proof": proof_to_json(claim.problem, claim.proof),
        "not_proved": list(NOT_PROVED),
        "files": {name: digest_of(files[name]) for name in ABOUT},
    }


def write_tube(folder: Path, claim: Claim) -> dict[str, Any]:
    """Write ``tube.json`` into the folder of a run, and return it."""
    data = tube_to_json(claim, {name: (folder / name).read_bytes() for name in ABOUT})
    write_whole(folder / TUBE, tube_text(data))
    return data


def tube_text(data: dict[str, Any]) -> bytes:
    """Return the contents of ``tube.json``."""
    return utf_8(json.dumps(data, indent=1) + "\n")


def check_tube(folder: Path, problem: PlanningTask, trajectory: Trajectory) -> Check:
    """Prove what ``tube.json`` says once more, of the files as they are."""
    try:
        data = json_file(folder / TUBE)
        stored, files = dict(data["proof"]), dict(data["files"])
        asked, share = Uncertainty.from_json(data["asked"]), float(data["share"])
    except (OSError, RecursionError, AttributeError, LookupError, TypeError, ValueError) as error:
        return Check("tube", float("inf"), 0.0, False, f"{TUBE} cannot be read ({why(error)})")
    changed = [n for n in ABOUT if files.get(n) != digest_of((folder / n).read_bytes())]
    if changed:
        what = f"{', '.join(changed)} changed since the tube was proved"
        return Check("tube", float(len(changed)), 0.0, False, what)
    about = asked.times(share) if share else asked
    if stored.get("uncertainty") != about.to_json() or bool(share) != stored.get("proved"):
        return Check("tube", 1.0, 0.0, False, "it claims more than its proof is about")
    return proved_again(problem, trajectory, stored)

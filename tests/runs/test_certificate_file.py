"""``certificate.json``: what was proved of which files, and what changed since."""

from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.runs import check_run, read_run
from kinolab.runs.certificate_file import certificate_to_json, proved
from kinolab.verification import Certificate, Check
from kinolab.verification.check_conditions import CheckConditions
from tests.conftest import Finished

CERTIFIED = ("scenario.toml", "trajectory.csv", "assets/machine.json")


def certificate(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "certificate.json").read_text())
    return found


def files_check(folder: Path) -> Check:
    return next(check for check in check_run(folder).checks if check.name == "files")


def test_it_says_what_was_checked_and_how_near_the_motion_came(maze_run: Finished) -> None:
    found = certificate(maze_run.folder)
    assert found["passed"] is True
    assert found["checks"] == maze_run.report["verification"]
    assert found["margin"] == maze_run.report["margin"]
    assert found["margin"]["clearance"] > 0
    assert found["versions"] == maze_run.report["versions"]
    assert found["proved"]
    assert any("signature" in sentence for sentence in found["not_proved"])


def test_it_says_what_the_checks_depend_on(maze_run: Finished) -> None:
    found = certificate(maze_run.folder)["conditions"]
    assert (found["truth"], found["clearance"]) == ("continuous", 0.0)
    assert (found["obstacles"], found["bodies_with_shapes"]) == (
        4,
        1,
    )  # a maze, three things, a coin
    assert found["goal_tolerances"]["x"] > 0
    assert found["scales"]["psi"] == 1.0
    assert (found["parameters"], found["requirements"]) == ({"R": 0.25}, ["the rim grips"])


@pytest.mark.parametrize(
    ("scenario", "override", "key", "name", "value"),
    [
        ("rolling_disk_maze", "system.parameters.R=0.2", "parameters", "R", 0.2),
        ("two_cranes", "system.parameters.g=1.6", "parameters", "g", 1.6),
        ("pendulum_swingup", "bounds.theta_dot=[-4, 5]", "bounds", "theta_dot", [-4.0, 5.0]),
        ("rolling_disk_maze", "bounds.drive=[-1.5, 1]", "bounds", "drive", [-1.5, 1.0]),
    ],
)
def test_it_names_what_the_scenario_changes_of_the_machine(
    scenario: str, override: str, key: str, name: str, value: Any
) -> None:
    conditions = CheckConditions.of(kinolab.load(scenario, overrides=[override]))
    found = json.loads(json.dumps(asdict(conditions)))
    assert found[key][name] == value
    assert f"{name} " in str(conditions)


def test_a_run_without_a_goal_is_not_checked(run_copy: Path) -> None:
    scenario = run_copy / "scenario.toml"
    head, _, rest = scenario.read_text().partition("[goal]")
    _, _, others = rest.partition("\n[")
    scenario.write_text(f"{head}[goal]\ntolerance = 0.1\n\n[{others}")
    with pytest.raises(InputError, match=r"\[goal\]: nothing says where it shall go"):
        check_run(run_copy)


def test_a_name_that_stands_twice_is_not_read(run_copy: Path) -> None:
    """Readers of JSON do not agree on which of the two counts."""
    machine = run_copy / "assets" / "machine.json"
    machine.write_text(machine.read_text().replace('"name":', '"name": "other", "name":', 1))
    with pytest.raises(InputError, match="'name' stands twice"):
        check_run(run_copy)


def test_only_what_was_checked_is_said_to_be_proved(run_copy: Path) -> None:
    problem = read_run(run_copy).problem
    whole = check_run(run_copy)
    text = " ".join(proved(problem, whole))
    assert "derived a second way" in text
    assert "constraints hold" in text
    assert "touches an obstacle" in text
    assert "steps, not the equations of motion" not in text
    assert "nothing that anything could touch" in " ".join(
        proved(problem, replace(whole, margin=None))
    )


def test_the_machine_is_the_one_in_the_assets(run_copy: Path) -> None:
    """Another one beside it, which nobody has the hash of, is not taken for it."""
    shutil.copy(run_copy / "assets" / "machine.json", run_copy / "other.json")
    scenario = run_copy / "scenario.toml"
    scenario.write_text(scenario.read_text().replace("assets/machine.json", "other.json"))
    with pytest.raises(InputError, match=r"assets/machine\.json"):
        check_run(run_copy)


def test_it_has_the_hash_of_every_file_that_it_is_about(maze_run: Finished) -> None:
    files = certificate(maze_run.folder)["files"]
    assets = {f"assets/{path.name}" for path in (maze_run.folder / "assets").iterdir()}
    assert set(files) == {*CERTIFIED, *assets}
    for name, digest in files.items():
        assert hashlib.sha256((maze_run.folder / name).read_bytes()).hexdigest() == digest


def test_a_plan_that_was_refused_proves_nothing(run_copy: Path) -> None:
    refused = Certificate((Check("goal", 2.0, 1.0, False, "x is off"),))
    found = certificate_to_json(read_run(run_copy).problem, refused, {})
    assert found["passed"] is False
    assert found["proved"] == []
    assert found["not_proved"]


@pytest.mark.parametrize("name", [*CERTIFIED, "certificate.json"])
def test_a_file_that_changed_is_named(run_copy: Path, name: str) -> None:
    path = run_copy / name
    text = path.read_text(encoding="utf-8")  # what it says stays the same, only its bytes do not
    path.write_bytes(
        (text.replace("\n", "\r\n") if name.endswith(".csv") else f"{text}\n").encode()
    )
    check = files_check(run_copy)
    assert not check.passed
    assert check.detail.endswith(f": {name}")


def test_all_files_that_changed_are_named(run_copy: Path) -> None:
    for name in ("scenario.toml", "assets/machine.json"):
        (run_copy / name).write_text((run_copy / name).read_text() + "\n")
    assert files_check(run_copy).detail.endswith(": assets/machine.json, scenario.toml")


def test_a_certificate_that_is_gone_is_missed(run_copy: Path) -> None:
    (run_copy / "certificate.json").unlink()
    assert files_check(run_copy).detail.endswith(": certificate.json")


@pytest.mark.parametrize("content", ["", "[]", "{", '{"files": 3}', '{"files": {"../x": "0"}}'])
def test_a_certificate_that_is_damaged_is_named(run_copy: Path, content: str) -> None:
    (run_copy / "certificate.json").write_text(content)
    assert "certificate.json" in files_check(run_copy).detail


def test_a_run_from_before_there_were_certificates_passes(run_copy: Path) -> None:
    report = json.loads((run_copy / "report.json").read_text())
    del report["certificate"]
    (run_copy / "report.json").write_text(json.dumps(report))
    (run_copy / "certificate.json").unlink()
    assert check_run(run_copy).passed


def test_a_folder_that_moved_passes(run_copy: Path, tmp_path: Path) -> None:
    moved = shutil.move(run_copy, tmp_path / "elsewhere")
    assert check_run(Path(moved)).passed

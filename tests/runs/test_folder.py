"""The folder of a run: complete, exact, self-contained, and honest when somebody changed it."""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import kinolab
from kinolab import cli
from kinolab.cli.versions import Versions
from kinolab.errors import InputError
from kinolab.files import write_whole
from kinolab.runs import (
    add_to_report,
    check_run,
    read_run,
    require_place,
    still_there,
    write_run,
    written_at,
)
from kinolab.runs.folder import MOTION_FORMATS, PICTURES
from kinolab.runs.readme import README
from kinolab.scenario import load_scenario
from kinolab.trajectory import Trajectory
from tests.conftest import Finished, Solved, finished_table
from tests.support import OPEN, plan, problem_of

Capture = pytest.CaptureFixture[str]


def code_of(folder: Path) -> int:
    return cli.run(["check", str(folder)])


def rewrite(path: Path, change: Callable[[Any], Any]) -> None:
    """Change a JSON file."""
    path.write_text(json.dumps(change(json.loads(path.read_text()))))


# --- what is in it ---


def test_a_run_has_the_files_that_are_promised(maze_run: Finished) -> None:
    found = {str(path.relative_to(maze_run.folder)) for path in maze_run.folder.rglob("*")}
    assert found == {
        "README.txt",
        "trajectory.csv",
        "trajectory.npz",
        "search.npz",
        "report.json",
        "certificate.json",
        "scenario.toml",
        "animation.gif",
        "scene.html",
        "result.glb",
        "assets",
        "assets/machine.json",
        "assets/1_rolling_disk_maze.stl",
    }
    assert maze_run.folder.name == "rolling_disk_maze"
    assert maze_run.code == 0


def test_the_folder_says_what_it_is(maze_run: Finished) -> None:
    """Every file that README.txt speaks of is there, and every word of it fits on a screen."""
    text = (maze_run.folder / README).read_text(encoding="utf-8")
    assert text.startswith("A coin rolls through a maze\nsolved: ")
    named = re.findall(r"\b[\w.]+\.(?:csv|npz|json|toml|html)\b", text)
    assert len(named) == 6
    assert [name for name in named if not (maze_run.folder / Path(name)).is_file()] == []
    assert "plan help files" in text
    assert max(map(len, text.splitlines())) <= 100


def test_the_report_has_the_keys_that_are_promised(maze_run: Finished) -> None:
    report = maze_run.report
    promised = {"schema_version", "status", "planner", "seed", "iterations", "cost", "duration"}
    promised |= {"goal_distance", "timings", "verification", "diagnosis", "versions"}
    assert promised <= set(report)
    assert report["status"] == "solved"
    assert (report["planner"], report["seed"]) == ("auto", 1)
    assert report["iterations"] > 0
    assert all(seconds >= 0 for seconds in report["timings"].values())
    for check in report["verification"]:
        assert {"name", "value", "limit", "passed"} <= set(check)
        assert check["passed"] is True
    assert report["versions"]["kinolab"] == kinolab.__version__


def test_the_report_is_strict_json(maze_run: Finished) -> None:
    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is not JSON")

    json.loads((maze_run.folder / "report.json").read_text(), parse_constant=refuse)


def test_the_csv_file_says_what_the_npz_file_says_bit_for_bit(maze_run: Finished) -> None:
    lines = (maze_run.folder / "trajectory.csv").read_text().splitlines()
    arrays = np.load(maze_run.folder / "trajectory.npz", allow_pickle=False)
    states, controls = arrays["state_names"].tolist(), arrays["control_names"].tolist()
    assert lines[0] == "t,x,y,psi,phi,psi_dot,phi_dot,drive,steer"
    assert lines[0] == ",".join(["t", *states, *controls])
    rows = [
        [float(value) if value else math.nan for value in line.split(",")] for line in lines[1:]
    ]
    table = np.array(rows)
    assert table[:, 0].tobytes() == arrays["t"].tobytes()
    assert table[:, 1:7].tobytes() == arrays["x"].tobytes()
    assert table[:-1, 7:].tobytes() == arrays["u"].tobytes()
    assert lines[-1].endswith(",,")
    assert arrays["u"].shape == (len(arrays["t"]) - 1, 2)


def test_there_is_one_row_per_propagation_step(maze_run: Finished) -> None:
    t = np.load(maze_run.folder / "trajectory.npz")["t"]
    assert t == pytest.approx(0.05 * np.arange(len(t)), abs=1e-9)  # [s]
    assert maze_run.report["duration"] == pytest.approx(t[-1])


def test_the_reported_distance_is_that_of_the_last_row(maze_run: Finished) -> None:
    x = np.load(maze_run.folder / "trajectory.npz")["x"][-1]
    expected = math.hypot(x[0] - 9.0, x[1] - 9.0)
    assert maze_run.report["goal_distance"] == pytest.approx(expected, abs=1e-12)


def test_every_asset_has_its_hash_in_the_report(maze_run: Finished) -> None:
    assets = maze_run.folder / "assets"
    digests = {
        file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in assets.iterdir()
    }
    assert maze_run.report["assets"] == digests


def test_the_scenario_has_every_default_written_out(maze_run: Finished) -> None:
    text = (maze_run.folder / "scenario.toml").read_text()
    for line in ('method = "rk4"', "seed = 1", "magnify = true", "at_rest = false", "speed = 1.0"):
        assert line in text
    assert "assets/machine.json" in text
    assert "assets/1_rolling_disk_maze.stl" in text
    before, after = (
        load_scenario("rolling_disk_maze"),
        load_scenario(maze_run.folder / "scenario.toml"),
    )
    for section in ("start", "goal", "bounds", "metric", "integration", "planner", "render"):
        assert getattr(before, section) == getattr(after, section)


def test_a_run_as_it_ran_has_the_overrides_in_it(tmp_path: Path) -> None:
    (tmp_path / "table.toml").write_text(OPEN)
    options = ["--seed", "5", "--set", "start.y=0.25", "--max-iterations", "5000"]
    out = tmp_path / "out"
    code = cli.run([str(tmp_path / "table.toml"), *options, "--no-animation", "--out", str(out)])
    scenario = load_scenario(out / "scenario.toml")
    assert code == 0
    assert (scenario.planner.seed, scenario.planner.max_iterations) == (5, 5000)
    assert scenario.start["y"] == 0.25


def test_the_animation_moves(maze_run: Finished) -> None:
    with Image.open(io.BytesIO((maze_run.folder / "animation.gif").read_bytes())) as film:
        assert getattr(film, "n_frames", 1) > 50
        assert film.size == (800, 600)


def test_the_animation_can_be_left_out(table_run: Finished) -> None:
    assert not any((table_run.folder / name).exists() for name in PICTURES)


# --- it can be mailed ---


def test_a_run_checks_itself_where_nothing_else_is_left(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    finished_table(home).folder.rename(tmp_path / "elsewhere")
    shutil.rmtree(home)
    done = plan("check", "elsewhere", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "elsewhere: passed" in done.stdout


def test_a_checked_run_is_not_changed(run_copy: Path) -> None:
    before = {path: path.read_bytes() for path in run_copy.rglob("*") if path.is_file()}
    assert code_of(run_copy) == 0
    assert {path: path.read_bytes() for path in run_copy.rglob("*") if path.is_file()} == before


def test_a_mailed_run_that_names_a_python_file_does_not_run_it(run_copy: Path) -> None:
    """A machine is data; code runs only where the user names it."""
    proof = run_copy / "it_ran"
    (run_copy / "assets" / "machine.py").write_text(
        f"open({str(proof)!r}, 'w').close()\n"
        "from kinolab.systems import get\ndef make():\n    return get('rolling_disk')\n"
    )
    scenario = run_copy / "scenario.toml"
    scenario.write_text(scenario.read_text().replace("machine.json", "machine.py:make"))
    code = code_of(run_copy)
    assert not proof.exists()
    assert code in (2, 7)


def test_the_materials_of_a_mesh_go_with_its_run(tmp_path: Path, short: Solved) -> None:
    """Two files of materials of one name, each in the folder of its mesh."""
    posts = ""
    for k, (folder, red) in enumerate((("a", "1 0 0"), ("b", "0 0 1"))):
        (tmp_path / folder).mkdir()
        mesh = "mtllib its.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl m\n"
        mesh += "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
        (tmp_path / folder / "post.obj").write_text(mesh)
        (tmp_path / folder / "its.mtl").write_text(f"newmtl m\nKd {red}\n")
        posts += (
            f'\n[[world.obstacle]]\nmesh = "{folder}/post.obj"\nposition = [3, {6 * k - 3}, 0]\n'
        )
    problem = problem_of(tmp_path, OPEN + posts)
    write_run(tmp_path / "run", problem, short.plan)
    (tmp_path / "a" / "its.mtl").unlink()
    assert check_run(tmp_path / "run").passed
    red, blue = read_run(tmp_path / "run").problem.world.obstacles
    assert red.colors is not None
    assert blue.colors is not None
    assert red.colors[0].tolist() == [1, 0, 0]
    assert blue.colors[0].tolist() == [0, 0, 1]
    (tmp_path / "run" / "assets" / "1_its.mtl").write_text("newmtl m\nKd 0 1 0\n")
    assert not check_run(tmp_path / "run").passed


def test_two_meshes_of_one_name_are_both_kept(tmp_path: Path, short: Solved) -> None:
    for k, folder in enumerate(("a", "b")):
        (tmp_path / folder).mkdir()
        off = f"OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 {k + 1}\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
        (tmp_path / folder / "post.off").write_text(off)
    posts = "".join(
        f'\n[[world.obstacle]]\nmesh = "{folder}/post.off"\nposition = [3, {y}, 0]\n'
        for folder, y in (("a", 3), ("b", -3))
    )
    problem = problem_of(tmp_path, OPEN + posts)
    write_run(tmp_path / "run", problem, short.plan)
    assert check_run(tmp_path / "run").passed
    vertices = [o.vertices for o in read_run(tmp_path / "run").problem.world.obstacles]
    expected = [o.vertices for o in problem.world.obstacles]
    for found, wanted in zip(vertices, expected, strict=True):
        assert (found == wanted).all()


# --- what somebody changed ---


def test_an_untouched_run_passes(run_copy: Path, capsys: Capture) -> None:
    assert code_of(run_copy) == 0
    assert "passed" in capsys.readouterr().out


def test_a_check_says_how_far_it_is(maze_run: Finished) -> None:
    said: list[str] = []
    assert check_run(maze_run.folder, said.append).passed
    assert said
    assert all(text.startswith("verifying a motion: ") for text in said)


def test_a_mesh_that_changed_fails(run_copy: Path, capsys: Capture) -> None:
    (mesh,) = (run_copy / "assets").glob("*.off")
    mesh.write_text(mesh.read_text().replace("0 0 1\n", "0 0 2\n", 1))
    assert code_of(run_copy) == 7
    out = capsys.readouterr().out
    assert "FAILED files" in out
    assert mesh.name in out


def test_a_machine_that_changed_fails(run_copy: Path, capsys: Capture) -> None:
    machine = run_copy / "assets" / "machine.json"
    machine.write_text(machine.read_text().replace('"default": 1.0', '"default": 1.01'))
    assert code_of(run_copy) == 7
    out = capsys.readouterr().out
    assert "FAILED files" in out
    assert "FAILED dynamics" in out
    assert "machine.json" in out


def test_a_machine_that_changed_by_a_blank_fails(run_copy: Path) -> None:
    machine = run_copy / "assets" / "machine.json"
    machine.write_text(machine.read_text() + " ")
    assert code_of(run_copy) == 7


@pytest.mark.parametrize("assets", ["yes", [], {}, None, ["machine.json"], 3])
def test_a_report_without_its_hashes_fails(run_copy: Path, assets: object) -> None:
    rewrite(run_copy / "report.json", lambda report: {**report, "assets": assets})
    assert code_of(run_copy) in (2, 7)


def test_a_mesh_that_the_report_does_not_list_fails(run_copy: Path) -> None:
    def forget(report: dict[str, Any]) -> dict[str, Any]:
        return {**report, "assets": {"machine.json": report["assets"]["machine.json"]}}

    rewrite(run_copy / "report.json", forget)
    (mesh,) = (run_copy / "assets").glob("*.off")
    mesh.write_text(mesh.read_text().replace("0 0 1\n", "0 0 2\n", 1))
    assert code_of(run_copy) == 7


@pytest.mark.parametrize(
    ("old", "new", "check"),
    [
        ("position = [3.0, 3.0, 0.0]", "position = [-1.2, -0.5, 0.0]", "collision"),
        ("x = 0.0", "x = 4.0", "goal"),
        ("x = -1.0", "x = -1.001", "start"),
    ],
)
def test_a_scenario_that_changed_fails(
    run_copy: Path, capsys: Capture, old: str, new: str, check: str
) -> None:
    scenario = run_copy / "scenario.toml"
    assert old in scenario.read_text()
    scenario.write_text(scenario.read_text().replace(old, new))
    assert code_of(run_copy) == 7
    assert f"FAILED {check}" in capsys.readouterr().out


def change_cell(folder: Path, row: int, column: int, value: str) -> None:
    path = folder / "trajectory.csv"
    lines = path.read_text().splitlines()
    cells = lines[row].split(",")
    cells[column] = value
    lines[row] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize(
    ("row", "column", "value", "code"),
    [
        (4, 1, "0.5", 7),  # a state
        (4, 7, "1.5", 7),  # an input beyond its limit
        (4, 0, "0.0", 7),  # a time that goes back
        (4, 0, "0.1", 7),  # a time that stands still
        (1, 0, "0.01", 7),  # a late beginning
        (4, 1, "nan", 2),
        (4, 1, "", 2),
        (0, 1, "y", 2),
    ],
)
def test_a_trajectory_that_changed_fails(
    run_copy: Path, capsys: Capture, row: int, column: int, value: str, code: int
) -> None:
    change_cell(run_copy, row, column, value)
    assert code_of(run_copy) == code
    assert "Traceback" not in capsys.readouterr().err


def test_an_npz_file_that_says_something_else_fails(run_copy: Path, capsys: Capture) -> None:
    """It is what Python reads, and a check that passed would vouch for it."""
    path = run_copy / "trajectory.npz"
    with np.load(path) as stored:
        tables = dict(stored)
    tables["u"][3, 0] += 1e-12  # [N m]
    np.savez(path, **tables)
    assert code_of(run_copy) == 7
    assert (
        "FAILED trajectory.npz (1, limit 0): it differs from trajectory.csv in u"
        in capsys.readouterr().out
    )


def test_a_damaged_npz_file_fails_and_a_missing_one_is_no_matter(run_copy: Path) -> None:
    (run_copy / "trajectory.npz").write_bytes(b"PK and nothing else")
    assert code_of(run_copy) == 7
    (run_copy / "trajectory.npz").unlink()
    assert code_of(run_copy) == 0


@pytest.mark.parametrize(
    "name", ["trajectory.csv", "report.json", "scenario.toml", "assets/machine.json"]
)
@pytest.mark.parametrize("content", [None, b"", b"\xff\xfe\x00", b"[" * 100_000, b"{}"])
def test_a_missing_or_damaged_file_is_bad_input(
    run_copy: Path, capsys: Capture, name: str, content: bytes | None
) -> None:
    (run_copy / name).unlink()
    if content is not None:
        (run_copy / name).write_bytes(content)
    expected = (2, 7) if (name, content) == ("report.json", b"{}") else (2,)
    assert code_of(run_copy) in expected
    err = capsys.readouterr().err
    assert "Traceback" not in err
    assert expected != (2,) or Path(name).name in err


def test_a_machine_file_cannot_keep_its_reader_busy(run_copy: Path) -> None:
    """Ten to the power of a billion is a short text, and hours of work for who multiplies it."""
    machine = run_copy / "assets" / "machine.json"
    text = machine.read_text()
    assert text.count('"expression": "m"') == 1
    tower = '"expression": ["mul", "m", ["pow", 10, ["pow", 10, 9]]]'
    machine.write_text(text.replace('"expression": "m"', tower))
    try:
        code = plan("check", str(run_copy), cwd=run_copy, timeout=60).returncode
    except subprocess.TimeoutExpired:
        code = None
    assert code in (2, 7)


def test_a_missing_mesh_is_bad_input(run_copy: Path, capsys: Capture) -> None:
    (mesh,) = (run_copy / "assets").glob("*.off")
    mesh.unlink()
    assert code_of(run_copy) == 2
    assert mesh.name in capsys.readouterr().err


def test_reading_names_every_missing_file_at_once(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_run(tmp_path)
    for name in ("trajectory.csv", "report.json", "scenario.toml"):
        assert name in str(caught.value)
    with pytest.raises(InputError, match=r"nothing: there is no such folder\."):
        read_run(tmp_path / "nothing")


# --- writing ---


def test_a_scenario_of_the_users_is_not_replaced_by_that_of_a_run(
    tmp_path: Path, capsys: Capture
) -> None:
    """``plan scenario.toml --out .`` wrote the run's scenario over the one that was planned."""
    (tmp_path / "scenario.toml").write_text(OPEN)
    words = [str(tmp_path / "scenario.toml"), "--out", str(tmp_path), "--no-animation"]
    assert cli.run(words) == 2
    error = capsys.readouterr().err
    assert f"{tmp_path}: this folder has a scenario.toml of its own" in error
    assert [file.name for file in tmp_path.iterdir()] == ["scenario.toml"]
    assert (tmp_path / "scenario.toml").read_text() == OPEN
    assert cli.run([*words[:2], str(tmp_path / "run"), "--no-animation"]) == 0
    assert cli.run([*words[:2], str(tmp_path / "run"), "--no-animation"]) == 0  # it is a run's


@pytest.mark.parametrize("target", ["nowhere", "run"])
def test_a_link_that_leads_to_no_folder_is_refused(target: str, tmp_path: Path) -> None:
    """One in a ring was found out after the search, by a traceback."""
    (tmp_path / "run").symlink_to(target)
    with pytest.raises(InputError, match="this folder cannot be written"):
        require_place(tmp_path / "run")


def test_a_run_of_another_file_of_the_same_name_is_replaced_with_a_warning(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for home in ("a", "b"):
        (tmp_path / home).mkdir()
        (tmp_path / home / "table.toml").write_text(OPEN)
    brief = ("--max-iterations", "1", "--no-animation", "--no-diagnosis")
    warnings = []
    for source in ("a/table.toml", "a/table.toml", "b/table.toml"):
        cli.run([source, *brief])
        warnings.append("which this one replaces" in capsys.readouterr().err)
    assert warnings == [False, False, True]


def test_a_run_that_replaces_an_earlier_one_says_of_when_that_was(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "table.toml").write_text(OPEN)
    place = f"  written to {Path('runs', 'table')}"
    ends = []
    for _ in range(3):
        cli.run(["table.toml", "--max-iterations", "1", "--no-animation", "--no-diagnosis"])
        ends.append(capsys.readouterr().out.splitlines()[-1])
        report = tmp_path / "runs" / "table" / "report.json"
        if len(ends) == 2:
            seconds = datetime(2024, 5, 6, 12, 31).timestamp()
            os.utime(report, (seconds, seconds))
    assert ends[0] == place
    assert re.fullmatch(rf"{re.escape(place)}, replacing the run of (\S+ )?\d\d:\d\d", ends[1])
    assert ends[2] == f"{place}, replacing the run of 2024-05-06 12:31"


def test_a_run_of_no_year_that_there_is_has_no_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "report.json").write_text("{}")
    assert written_at(tmp_path) is not None
    for seconds in (1e12, -1e12, 1e30):
        times = os.stat_result((0, 0, 0, 0, 0, 0, 0, 0.0, seconds, 0.0))
        monkeypatch.setattr(Path, "stat", lambda *_, own=times: own)
        assert written_at(tmp_path) is None


def test_a_second_run_in_the_same_folder_leaves_nothing_of_the_first(
    table_run: Finished, short: Solved, tmp_path: Path
) -> None:
    """The first has a mesh and a picture, the second has neither."""
    run = read_run(table_run.folder)
    write_run(tmp_path / "run", run.problem, short.plan)
    for name in PICTURES:
        write_whole(tmp_path / "run" / name, b"of the first")
    write_run(tmp_path / "run", short.problem, short.plan)
    found = {str(p.relative_to(tmp_path / "run")) for p in (tmp_path / "run").rglob("*")}
    write_run(tmp_path / "fresh", short.problem, short.plan)
    fresh = {str(p.relative_to(tmp_path / "fresh")) for p in (tmp_path / "fresh").rglob("*")}
    assert found == fresh


def test_a_run_that_finds_nothing_leaves_no_motion_of_the_one_before(
    short: Solved, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor in a format that was added since, by one line."""

    def as_json(trajectory: Trajectory) -> bytes:
        return json.dumps({"t": trajectory.t.tolist()}).encode()

    monkeypatch.setitem(MOTION_FORMATS, "trajectory.json", as_json)
    write_run(tmp_path, short.problem, short.plan)
    written = json.loads((tmp_path / "trajectory.json").read_text())
    assert written == {"t": short.trajectory.t.tolist()}
    for name in PICTURES:
        write_whole(tmp_path / name, b"of the one before")
    still = problem_of(tmp_path / "still", OPEN, "bounds.psi_dot=[-1e-9, 1e-9]", "start.y=1")
    found = still.solve(max_iterations=5)
    if found.trajectory is not None:
        pytest.fail("the search was meant to find nothing")
    report = write_run(tmp_path, still, found)
    assert report["status"] == "not_found"
    for name in ("trajectory.csv", "trajectory.npz", "trajectory.json", *PICTURES):
        assert not (tmp_path / name).exists()
    assert code_of(tmp_path) == 2  # there is no trajectory to check


def test_the_report_of_a_run_that_was_replaced_meanwhile_is_not_written(
    short: Solved, tmp_path: Path
) -> None:
    """A diagnosis takes time, in which another run may be written into the folder."""
    first = write_run(tmp_path, short.problem, short.plan)
    second = write_run(tmp_path, short.problem, replace(short.plan, seed=7))
    with still_there(tmp_path, first) as there:
        assert not there
    with still_there(tmp_path, second) as there:
        assert there
    add_to_report(tmp_path, first, {"diagnosis": ["It is too narrow."]})
    assert json.loads((tmp_path / "report.json").read_text()) == second


class NoFilm:
    """A film that takes no time."""

    def begin(self, *_: object) -> None:
        """Begin what is finished later."""

    def animation(self) -> bytes:
        return b"GIF89a;"


def test_pictures_are_not_put_beside_another_run(short: Solved, tmp_path: Path) -> None:
    """Drawing takes longer than planning, and ten runs may share a folder."""
    film: Any = NoFilm()
    versions = Versions(short.problem, tmp_path, lambda: film)
    assert not versions.end(short.plan)  # the film is missing
    assert versions.wait_for_film()
    assert all((tmp_path / name).is_file() for name in ("scene.html", "animation.gif"))
    write_run(tmp_path, short.problem, replace(short.plan, seed=7))
    assert not versions.wait_for_film()
    assert not any((tmp_path / name).exists() for name in PICTURES)


def test_files_that_are_not_the_runs_are_left_alone(short: Solved, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    write_run(tmp_path, short.problem, short.plan)
    assert (tmp_path / "notes.txt").read_text() == "mine"


class DiskFullError(OSError):
    """What a full disk raises."""


@pytest.mark.parametrize("full_after", range(5))
def test_a_disk_that_fills_up_leaves_no_half_file(
    short: Solved, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, full_after: int
) -> None:
    """The earlier run stays as it was: every file of it is whole, and vouched for."""
    for name in ("whole", "run"):
        write_run(tmp_path / name, short.problem, short.plan)
    written: list[Path] = []
    write = Path.write_bytes

    def limited(path: Path, content: bytes) -> int:
        if len(written) == full_after:
            write(path, content[: len(content) // 2])
            raise DiskFullError(28, "No space left on device")
        written.append(path)
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", limited)
    with pytest.raises(DiskFullError) as refused:
        write_run(tmp_path / "run", short.problem, short.plan)
    assert Path(refused.value.filename).is_relative_to(tmp_path / "run")  # it is told which
    files = [path for path in (tmp_path / "run").rglob("*") if path.is_file()]
    for path in files:
        assert (
            path.read_bytes()
            == (tmp_path / "whole" / path.relative_to(tmp_path / "run")).read_bytes()
        )
    assert len(files) == len([p for p in (tmp_path / "whole").rglob("*") if p.is_file()])
    assert check_run(tmp_path / "run").passed


def test_check_of_an_approximate_run_fails_at_the_goal(tmp_path: Path, capsys: Capture) -> None:
    far = problem_of(tmp_path, OPEN, "goal.x=4", "goal.tolerance=1e-3")
    write_run(tmp_path / "run", far, far.solve(seed=1, max_iterations=30))
    assert code_of(tmp_path / "run") == 7
    out = capsys.readouterr().out
    assert out.count("FAILED") == 2  # the folder and the goal
    assert "FAILED goal" in out

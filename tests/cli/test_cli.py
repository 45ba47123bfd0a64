"""The command line: exit codes, what goes to which stream, and nothing left by what failed."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import kinolab
from kinolab import cli
from tests.conftest import Finished
from tests.solve.test_refused_motions import FICKLE, PLANNER
from tests.support import ENTER, OPEN, WALL, environment, plan, started

Capture = pytest.CaptureFixture[str]

HARD = ("--set", "goal.x=4", "--set", "goal.tolerance=1e-9")  # is not hit by chance
SILENT = ("--no-animation", "--no-diagnosis", "--quiet")


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with the table in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "table.toml").write_text(OPEN)
    return tmp_path


def names(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


# --- exit codes ---


def test_0_a_solved_and_verified_plan(home: Path, capsys: Capture) -> None:
    assert cli.run(["table.toml", *SILENT]) == 0
    out = capsys.readouterr().out
    assert out.startswith("solved: ")
    assert str(Path("runs") / "table") in out
    assert (home / "runs" / "table" / "report.json").is_file()
    assert cli.run(["check", "runs/table"]) == 0


def test_2_a_scenario_that_does_not_exist(home: Path, capsys: Capture) -> None:
    assert cli.run(["tabel.toml"]) == 2
    err = capsys.readouterr().err
    assert "Did you mean 'table.toml'" in err
    assert names(home) == {"table.toml"}


def test_3_nothing_found(home: Path, capsys: Capture) -> None:
    """Rates may hardly differ from 0: every motion breaks a limit."""
    still = ["--set", "bounds.psi_dot=[-1e-9, 1e-9]", "--set", "bounds.phi_dot=[-1e-9, 1e-9]"]
    assert cli.run(["table.toml", *still, "--max-iterations", "50", *SILENT]) == 3
    assert capsys.readouterr().out.startswith("not_found: ")
    report = json.loads((home / "runs" / "table" / "report.json").read_text())
    assert (report["status"], report["cost"], report["verification"]) == ("not_found", None, [])
    assert not (home / "runs" / "table" / "trajectory.csv").exists()


def test_4_an_approximate_plan(home: Path, capsys: Capture) -> None:
    assert cli.run(["table.toml", *HARD, "--max-iterations", "100", *SILENT]) == 4
    out = capsys.readouterr().out
    assert out.startswith("approximate: ")
    assert "FAILED goal" in out
    assert (home / "runs" / "table" / "trajectory.csv").is_file()
    assert cli.run(["check", "runs/table"]) == 7


def test_5_a_start_inside_a_wall_names_the_pair_and_writes_nothing(
    home: Path, capsys: Capture
) -> None:
    (home / "wall.toml").write_text(OPEN + WALL)
    assert cli.run(["wall.toml", "--set", "start.x=3"]) == 5
    err = capsys.readouterr().err
    assert "coin" in err
    assert "wall." in err
    assert "[start]" in err
    assert names(home) == {"table.toml", "wall.toml"}


def test_7_a_plan_that_is_not_true(home: Path, capsys: Capture) -> None:
    """Every motion that this planner finds asks for more torque than the motor has."""
    (home / "fickle.py").write_text(FICKLE)
    always = ["--set", PLANNER, "--set", "planner.bad=1.0", "--max-iterations", "50", *SILENT]
    assert cli.run(["table.toml", *always]) == 7
    assert "verification_failed: " in capsys.readouterr().out
    report = json.loads((home / "runs" / "table" / "report.json").read_text())
    assert [check["name"] for check in report["verification"] if not check["passed"]] == ["inputs"]


def test_7_a_run_that_somebody_changed(home: Path, capsys: Capture) -> None:
    cli.run(["table.toml", *SILENT])
    machine = home / "runs" / "table" / "assets" / "machine.json"
    machine.write_text(machine.read_text().replace('"default": 0.25', '"default": 0.3'))
    capsys.readouterr()
    assert cli.run(["check", "runs/table"]) == 7
    assert "runs/table: FAILED" in capsys.readouterr().out


def interrupted(process: subprocess.Popen[str], word: str, delay: float) -> tuple[float, str, str]:
    """Interrupt a process some time after a word on stderr; return seconds to its end, outputs."""
    assert process.stderr is not None
    heard = ""
    for line in process.stderr:
        heard += line
        if word in line:
            break
    time.sleep(delay)
    begun = time.monotonic()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    return time.monotonic() - begun, out, heard + err


def test_130_an_interrupted_search_ends_within_a_second_and_writes_what_it_found(
    home: Path,
) -> None:
    process = started("table.toml", *HARD, "--no-animation", "--time-limit", "30", cwd=home)
    seconds, out, err = interrupted(process, "searching", 1.0)
    assert process.returncode == 130, err
    assert seconds < 5.0  # [s]; about 1 on a machine that does nothing else
    assert out.startswith("interrupted: ")
    assert "Traceback" not in err
    report = json.loads((home / "runs" / "table" / "report.json").read_text())
    assert report["status"] == "interrupted"
    assert report["iterations"] > 10
    assert (home / "runs" / "table" / "trajectory.csv").is_file()


def test_130_an_interrupted_search_of_the_maze_ends_soon(tmp_path: Path) -> None:
    """A long motion was found by then; checking it must not keep the user waiting."""
    options = ("--set", "goal.tolerance=1e-9", "--no-animation", "--time-limit", "60")
    process = started("rolling_disk_maze", *options, cwd=tmp_path)
    seconds, _, err = interrupted(process, "searching", 1.5)
    assert process.returncode == 130, err
    assert seconds < 5.0  # [s], as above


def test_130_an_interrupted_picture_does_not_cost_the_plan(tmp_path: Path) -> None:
    (tmp_path / "table.toml").write_text(OPEN)
    process = started("table.toml", cwd=tmp_path)
    _, _, err = interrupted(process, "drawing", 0.05)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert (tmp_path / "runs" / "table" / "trajectory.csv").is_file()


def test_130_interrupted_before_the_search_writes_nothing(home: Path) -> None:
    process = started("rolling_disk_maze", cwd=home)
    _, _, err = interrupted(process, "deriving", 0.01)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert names(home) == {"table.toml"}


# --- bad input ---

BAD = {
    "no such option": ["table.toml", "--sede", "1"],
    "no argument": ["check"],
    "a seed below zero": ["table.toml", "--seed", "-1"],
    "a seed that is no number": ["table.toml", "--seed", "one"],
    "no iterations": ["table.toml", "--max-iterations", "0"],
    "a time of zero": ["table.toml", "--time-limit", "0"],
    "a time that is no number": ["table.toml", "--time-limit", "nan"],
    "an endless time": ["table.toml", "--time-limit", "inf"],
    "an unknown planner": ["table.toml", "--planner", "rtt"],
    "a planner without a name": ["table.toml", "--planner", ""],
    "an override without =": ["table.toml", "--set", "start.x"],
    "an override without a value": ["table.toml", "--set", "start.x="],
    "an override of half a list": ["table.toml", "--set", "bounds.x=[1"],
    "an override of an unknown key": ["table.toml", "--set", "goals.x=1"],
    "an override of an entry that is not there": [
        "table.toml",
        "--set",
        "world.obstacle.1.name='a'",
    ],
    "an unknown coordinate": ["table.toml", "--set", "start.z=1"],
    "a folder": ["."],
    "nothing": [""],
    "a scenario that is no TOML": ["broken.toml"],
    "a scenario that is empty": ["empty.toml"],
    "a scenario that is no text": ["bytes.toml"],
    "a folder without a run": ["check", "."],
    "a run that is not there": ["check", "runs/nothing"],
    "equations of nothing": ["equations", "nothing"],
    "equations of a missing file": ["equations", "nothing.py:make"],
    "equations of a missing machine": ["equations", "nothing.json"],
    "equations of a machine without a function": ["equations", "machine.py"],
    "steps below zero": ["table.toml", "--set", "planner.max_steps=-1"],
    "more steps at least than at most": ["table.toml", "--set", "planner.min_steps=30"],
    "a metric of zeros": [
        "table.toml",
        "--set",
        "metric={x=0,y=0,psi=0,phi=0,psi_dot=0,phi_dot=0}",
    ],
    "a goal out of bounds": ["table.toml", "--set", "goal.x=7"],
    "limits that leave nothing": ["table.toml", "--set", "bounds.y=[20, 30]"],
    "a goal beside limits that leave nothing": [
        "table.toml",
        "--set",
        "goal={x=0}",
        "--set",
        "bounds.y=[20, 30]",
    ],
    "a goal inside a wall": ["wall.toml", "--set", "goal={x=3, y=0, tolerance=0.01}"],
    "a start inside a wall": ["wall.toml", "--set", "start.x=3"],
    "a mesh that is not finite": ["mesh.toml"],
    "a mesh outside the folder": ["mesh.toml", "--set", "world.obstacle.1.mesh='../nan.off'"],
    "a mesh that is missing": ["mesh.toml", "--set", "world.obstacle.1.mesh='missing.off'"],
    "a machine's file that fails": ["own.toml"],
    "a machine's file that leaves": ["own.toml", "--set", "system.file='leaves.py:make'"],
    "a machine that leaves": ["own.toml", "--set", "system.file='leaves_later.py:make'"],
    "a folder where a file is": ["table.toml", "--no-animation", "--out", "table.toml"],
    "a folder below a file": ["table.toml", "--no-animation", "--out", "table.toml/run"],
}


@pytest.mark.parametrize("arguments", BAD.values(), ids=BAD.keys())
def test_bad_input_is_a_sentence_and_writes_nothing(
    home: Path, capsys: Capture, arguments: list[str]
) -> None:
    (home / "broken.toml").write_text("schema = = 1")
    (home / "empty.toml").write_text("")
    (home / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    (home / "wall.toml").write_text(OPEN + WALL)
    (home / "nan.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n")
    (home / "mesh.toml").write_text(OPEN + '\n[[world.obstacle]]\nmesh = "nan.off"\n')
    (home / "own.toml").write_text(OPEN.replace('name = "rolling_disk"', 'file = "own.py:make"'))
    (home / "own.py").write_text("def make():\n    return 1 / 0\n")
    (home / "leaves.py").write_text("import sys\nsys.exit(0)\n")
    (home / "leaves_later.py").write_text("import sys\ndef make():\n    sys.exit(0)\n")
    before = names(home)
    assert _left(arguments) in (2, 5)
    err = capsys.readouterr().err
    assert "Traceback" not in err
    assert "mistake in kinolab" not in err
    assert err.strip()
    assert {name for name in names(home) - before if "__pycache__" not in name} == set()


def _left(arguments: list[str]) -> object:
    """Return the exit code, even where something leaves by itself."""
    try:
        return cli.run(arguments)
    except SystemExit as left:
        return f"left with {left.code}"


def test_four_mistakes_of_four_kinds_are_four_lines(home: Path, capsys: Capture) -> None:
    text = OPEN.replace("time_limit", "time_limits")  # an unknown key
    text = text.replace("tolerance = 0.5", 'tolerance = "wide"')  # a wrong type
    text = text.replace("x = -1.0", "z = -1.0")  # an unknown coordinate
    (home / "bad.toml").write_text(text + '\n[[world.obstacle]]\nmesh = "missing.stl"\n')
    assert cli.run(["bad.toml"]) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error: ")]
    assert len(lines) == 4, lines
    for words in ("time_limits", "tolerance", "[start] z", "missing.stl"):
        assert sum(words in line for line in lines) == 1, (words, lines)
    assert names(home) == {"table.toml", "bad.toml"}


def test_an_unknown_scenario_is_told_with_the_nearest_and_all_there_are(
    home: Path, capsys: Capture
) -> None:
    assert cli.run(["rolling_disk_maz"]) == 2
    err = capsys.readouterr().err
    assert "Did you mean 'rolling_disk_maze'" in err
    assert "Built in: " in err
    assert names(home) == {"table.toml"}


def test_a_folder_that_cannot_be_written_is_told_by_name(home: Path, capsys: Capture) -> None:
    """A file stands where the folder's parent should be, which no right can overcome."""
    (home / "occupied").write_text("mine")
    assert cli.run(["table.toml", *SILENT, "--out", "occupied/run"]) == 2
    assert "occupied" in capsys.readouterr().err
    assert (home / "occupied").read_text() == "mine"


@pytest.mark.usefixtures("home")
def test_a_read_only_folder_is_told_by_name(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rights do not stop root, so the refusal is played."""

    def refused(path: Path, *_: Any, **__: Any) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "mkdir", refused)
    assert cli.run(["table.toml", *SILENT]) == 2
    err = capsys.readouterr().err
    assert "Permission denied" in err
    assert "Traceback" not in err


# --- --set ---


@pytest.mark.usefixtures("home")
@pytest.mark.parametrize(
    ("override", "key", "expected"),
    [
        ("planner.seed=4", "seed", 4),
        ("planner.seed = 4", "seed", 4),
        ('"planner"."seed"=4', "seed", 4),
        ("planner={ seed = 4, improve = 0 }", "seed", 4),
        ("planner.name=rrt", "planner", "rrt"),
        ("planner.name='rrt'", "planner", "rrt"),
        ("title=a = b", "status", "solved"),
    ],
)
def test_any_key_can_be_set_in_any_spelling(
    capsys: Capture, override: str, key: str, expected: object
) -> None:
    assert cli.run(["table.toml", "--set", override, *SILENT, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[key] == expected


@pytest.mark.usefixtures("home")
def test_options_of_their_own_win_over_set(capsys: Capture) -> None:
    options = ["--seed", "6", "--set", "planner.seed=5", *SILENT, "--json"]
    assert cli.run(["table.toml", *options]) == 0
    assert json.loads(capsys.readouterr().out)["seed"] == 6


def test_an_entry_of_a_list_is_counted_from_one(home: Path, capsys: Capture) -> None:
    (home / "wall.toml").write_text(OPEN + WALL)
    moved = ["--set", "world.obstacle.1.position=[-1, 0, 0.5]"]
    assert cli.run(["wall.toml", *moved]) == 5
    assert "coin touches wall" in capsys.readouterr().err


# --- streams ---


def test_json_is_one_object_on_stdout_and_nothing_else(maze_run: Finished) -> None:
    printed = json.loads(maze_run.stdout)
    assert maze_run.stdout.count("\n") == 1
    folder = printed.pop("folder")
    assert Path(folder).name == maze_run.folder.name
    assert printed == maze_run.report


def test_progress_goes_to_stderr_plain_and_without_warnings(maze_run: Finished) -> None:
    assert "searching with auto, seed 1" in maze_run.stderr
    assert "\033" not in maze_run.stderr
    assert "\r" not in maze_run.stderr
    for word in ("nanobind", "leaked", "Warning", "Traceback", "Exception"):
        assert word not in maze_run.stderr, maze_run.stderr


def test_quiet_says_nothing_on_stderr(home: Path) -> None:
    done = plan("table.toml", "--quiet", "--no-animation", cwd=home)
    assert done.returncode == 0
    assert done.stderr == ""
    assert done.stdout.startswith("solved: ")


def test_a_quick_check_says_nothing_on_stderr(table_run: Finished, capfd: Capture) -> None:
    assert cli.run(["check", str(table_run.folder)]) == 0
    assert capfd.readouterr().err == ""


def test_check_of_several_runs_names_each_and_fails_with_one(
    table_run: Finished, run_copy: Path, capsys: Capture
) -> None:
    (run_copy / "assets" / "machine.json").write_text(
        (run_copy / "assets" / "machine.json").read_text() + "\n"
    )
    assert cli.run(["check", str(table_run.folder), str(run_copy)]) == 7
    out = capsys.readouterr().out
    assert f"{table_run.folder}: passed" in out
    assert f"{run_copy}: FAILED" in out


@pytest.mark.parametrize("damaged_first", [True, False])
def test_check_names_the_folder_that_is_damaged_and_checks_the_others(
    table_run: Finished, run_copy: Path, capsys: Capture, damaged_first: bool
) -> None:
    scenario = run_copy / "scenario.toml"
    scenario.write_text(scenario.read_text().replace("[goal]", "[goal]\nreserve = 9.0\nx_ = 1"))
    folders = [str(run_copy), str(table_run.folder)]
    assert cli.run(["check", *(folders if damaged_first else folders[::-1])]) == 2
    told = capsys.readouterr()
    assert f"{table_run.folder}: passed" in told.out
    mistakes = told.err.splitlines()
    assert len(mistakes) >= 1
    assert all(line.startswith(f"error: {run_copy}: scenario.toml ") for line in mistakes)


@pytest.mark.parametrize("name", ["plain", "Infinity", "NaN"])
def test_check_as_json_is_one_object(
    table_run: Finished, tmp_path: Path, capsys: Capture, name: str
) -> None:
    folder = shutil.copytree(table_run.folder, tmp_path / name)
    assert cli.run(["check", "--json", str(folder)]) == 0
    out = capsys.readouterr().out
    (run,) = json.loads(out, parse_constant=_refuse)["runs"]
    assert run["folder"] == str(folder)
    assert run["passed"] is True
    assert {"name", "value", "limit", "passed"} <= set(run["checks"][0])


def test_check_of_a_motion_that_diverges_is_strict_json_too(
    run_copy: Path, capsys: Capture
) -> None:
    table = run_copy / "trajectory.csv"
    lines = table.read_text().splitlines()
    cells = lines[3].split(",")
    cells[7] = "1e306"  # [N m], under which velocities pass the largest number there is
    lines[3] = ",".join(cells)
    table.write_text("\n".join(lines) + "\n")
    assert cli.run(["check", "--json", str(run_copy)]) == 7
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    (run,) = json.loads(captured.out, parse_constant=_refuse)["runs"]
    assert run["passed"] is False


def _refuse(word: str) -> None:
    raise AssertionError(f"{word} is not JSON")


@pytest.mark.parametrize(
    "arguments", [["list", "scenarios"], ["list", "scenarios", "--json"], ["table.toml", *SILENT]]
)
def test_a_reader_that_leaves_is_no_error(home: Path, arguments: list[str]) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as nowhere:
        done = subprocess.run(
            [sys.executable, "-c", ENTER, *arguments],
            cwd=home,
            env=environment(),
            stdout=nowhere,
            stderr=subprocess.PIPE,
            text=True,
            timeout=60,
            check=False,
        )
    assert done.stderr == ""
    assert done.returncode == 0


def test_a_mesh_with_a_hole_is_warned_of(home: Path, capsys: Capture) -> None:
    """Nothing tells its inside from its outside, so that a body in it would count as free."""
    (home / "leaky.off").write_text(
        "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n"
    )
    mesh = '\n[[world.obstacle]]\nmesh = "leaky.off"\nposition = [3, 3, 0]\n'
    (home / "leaky.toml").write_text(OPEN + mesh)
    assert cli.run(["leaky.toml", *SILENT]) == 0
    err = capsys.readouterr().err
    assert "leaky.off" in err
    assert "watertight" in err


# --- other commands ---


def test_help_imports_nothing_slow(tmp_path: Path) -> None:
    slow = "{'sympy', 'numpy', 'trimesh', 'pydantic', 'numba', 'scipy', 'ompl', 'fcl'}"
    code = (
        "import sys; from kinolab.cli import run; code = run(['--help']); "
        f"print(sorted({slow} & set(sys.modules)), code, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr.split("\n")[0] == "[] 0"
    assert "SCENARIO" in done.stdout


@pytest.mark.parametrize(
    "option",
    [
        *("--planner", "--seed", "--time-limit", "--max-iterations", "--set", "--out"),
        *("--json", "--no-animation", "--no-diagnosis", "--quiet", "--jobs", "--anytime"),
        *("--roadmap", "check", "list", "equations", "describe"),
    ],
)
def test_help_names_every_option_and_command(capsys: Capture, option: str) -> None:
    assert cli.run(["--help"]) == 0
    assert option in capsys.readouterr().out


@pytest.mark.parametrize("command", ["check", "list", "equations", "describe"])
def test_every_command_explains_itself(capsys: Capture, command: str) -> None:
    assert cli.run([command, "--help"]) == 0
    assert "Usage: plan" in capsys.readouterr().out


def test_list_names_scenarios_systems_and_planners(capsys: Capture) -> None:
    assert cli.run(["list", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) == {"scenarios", "systems", "planners"}
    listed = {group: {entry["name"] for entry in entries} for group, entries in found.items()}
    assert "rolling_disk_maze" in listed["scenarios"]
    assert {"rolling_disk", "pendulum"} <= listed["systems"]
    assert "rrt" in listed["planners"]
    assert cli.run(["list"]) == 0
    out = capsys.readouterr().out
    assert all(name in out for group in listed.values() for name in group)


@pytest.mark.parametrize("what", ["rolling_disk", "rolling_disk_maze", "table.toml"])
def test_equations_of_the_coin_are_those_of_the_book(
    home: Path, capsys: Capture, what: str
) -> None:
    """Bloch, Nonholonomic Mechanics and Control, section 1.4: 3/2 m R^2 phi_ddot = drive."""
    assert (home / "table.toml").is_file()
    assert cli.run(["equations", what]) == 0
    out = capsys.readouterr().out
    assert "3/2 m R² φ̈ = drive" in out
    assert "1/4 m R² ψ̈ = steer" in out


def test_equations_can_be_latex(capsys: Capture) -> None:
    assert cli.run(["equations", "rolling_disk", "--latex"]) == 0
    out = capsys.readouterr().out
    assert r"\ddot{\psi}" in out or r"\ddot \psi" in out
    assert out.count("{") == out.count("}")


@pytest.mark.parametrize("arguments", [["-h"], ["describe", "-h"], ["rolling_disk_maze", "-h"]])
def test_help_has_a_short_name(arguments: list[str], capsys: Capture) -> None:
    assert cli.run(arguments) == 0
    assert capsys.readouterr().out.startswith("Usage: plan")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("plan exa", "plain,examine"),
        ("plan rolling_disk_m", "plain,rolling_disk_maze"),
        ("plan describe pendul", "plain,pendulum"),
        ("plan describe pendul", "file,pendul"),  # the shell's own
        ("plan rolling_disk_maze --time", "plain,--time-limit"),
    ],
)
def test_a_shell_completes_commands_scenarios_and_options(
    words: str, expected: str, tmp_path: Path
) -> None:
    """As bash asks for it: by variables, of the command itself."""
    count = str(len(words.split()) - 1)
    asked = {"_PLAN_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": count}
    done = plan(cwd=tmp_path, **asked)
    assert expected in done.stdout.splitlines(), done.stdout + done.stderr


def test_the_machine_of_a_run_is_exported(tmp_path: Path) -> None:
    run = kinolab.load({"system": "pendulum", "goal": {"theta": 0.1}}).solve(seed=1)
    run.save(tmp_path / "run")
    for form, name in (("mjcf", "pendulum.xml"), ("urdf", "pendulum.urdf"), ("c", "pendulum.c")):
        done = ["export", str(tmp_path / "run"), "--format", form, "--out", str(tmp_path)]
        assert cli.run(done) == 0
        assert (tmp_path / name).is_file()


def test_commands_of_machines_say_what_they_do(capsys: Capture) -> None:
    for command in ("equations", "describe", "examine"):
        assert cli.run([command, "pendulum"]) == 0
        assert "reading pendulum\n" in capsys.readouterr().err
        assert cli.run([command, "pendulum", "--quiet"]) == 0
        assert capsys.readouterr().err == ""


def test_joints_that_still_move_at_the_end_are_told(tmp_path: Path, capsys: Capture) -> None:
    """ROS 2's controller refuses such a trajectory, and does not say how to end at rest."""
    assert cli.run(["simulate", "pendulum", "--start", "theta=0.5", "--duration", "0.5",
                    "--no-animation", "--out", str(tmp_path / "run")]) == 0  # fmt: skip
    written = ["export", str(tmp_path / "run"), "--out", str(tmp_path), "--format"]
    capsys.readouterr()
    assert cli.run([*written, "joint_trajectory"]) == 0
    assert "The last point's velocity is not zero (theta -" in capsys.readouterr().out
    assert cli.run([*written, "csv"]) == 0
    assert "velocity" not in capsys.readouterr().out

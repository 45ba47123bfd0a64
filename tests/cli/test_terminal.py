"""What commands print of a stranger's files is seen, and does nothing to the terminal."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from kinolab.cli import run
from kinolab.cli.terminal import echo_json, escaped
from tests.support import OPEN, WALL

STEERING = "\x1b]0;hacked\a\x1b[2J\x9b31m\u202e\u2066\r\x7f\ud800"
FORGED = "\nrun: passed\n"


@pytest.mark.parametrize(
    "character", "\0\a\b\n\r\x1b\x7f\x85\x9b\u200e\u2028\u2029\u202e\u2066\ud800", ids=ascii
)
def test_a_character_that_a_terminal_obeys_is_written_out(character: str) -> None:
    shown = escaped(f"a{character}b")
    assert shown.isascii()
    assert shown.isprintable()
    assert shown[1] == "\\"


@pytest.mark.parametrize("text", ["ψ̇ = 3 rad/s", "Türöffner – 門", "a\tb", "\u200dé ✓", "a\\b"])
def test_other_text_is_printed_as_it_is(text: str) -> None:
    assert escaped(text) == text


def test_json_says_the_same_without_them(capsys: pytest.CaptureFixture[str]) -> None:
    data = {f"a{STEERING}": [FORGED, "ψ"]}
    echo_json(data)
    printed = capsys.readouterr().out
    assert json.loads(printed) == data
    assert "ψ" in printed
    assert printed.rstrip("\n").isprintable()


COMMANDS = {
    "check": ("check",),
    "check as JSON": ("check", "--json"),
    "view": ("view", "--no-browser"),
    "gallery": ("gallery", "--out", "gallery.html"),
    "simulate": ("simulate", "--no-animation"),
}


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_no_command_prints_what_steers_a_terminal(
    command: tuple[str, ...],
    run_copy: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Neither from the report, nor from names of folders, nor in what is said of mistakes."""
    monkeypatch.chdir(tmp_path)
    name = STEERING.removesuffix("\ud800") + FORGED.strip()
    report = json.loads((run_copy / "report.json").read_text())
    report |= {"assets": {STEERING + FORGED: ""}, "message": STEERING, "planner": STEERING}
    (run_copy / "report.json").write_text(json.dumps(report))
    folder = run_copy.rename(tmp_path / f"run{name}{FORGED}")
    broken = tmp_path / f"broken{name}"
    broken.mkdir()
    for file in ("scenario.toml", "report.json", "trajectory.csv"):
        (broken / file).write_text(f"{STEERING[:-1]} = ")
    for given in (folder, broken, tmp_path / f"none{name}", f"--{name}"):
        assert run([command[0], str(given), *command[1:], "--quiet"]) in (0, 2, 7)
        printed = "".join(capsys.readouterr())
        assert printed.replace("\n", "").isprintable()
        assert "\nrun: passed" not in printed


@pytest.mark.parametrize("added", ["\x1b[31m", "\u202e", "\x9b", 400 * "n"])
def test_a_scenario_s_names_are_refused_where_they_could(
    added: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (OPEN + WALL).replace('"wall"', json.dumps(f"wall{added}"))
    (tmp_path / "table.toml").write_text(text)
    assert run(["view", str(tmp_path / "table.toml"), "--no-browser", "--quiet"]) == 2
    told = capsys.readouterr().err
    assert "[[world.obstacle]] 1 name" in told
    assert added not in told

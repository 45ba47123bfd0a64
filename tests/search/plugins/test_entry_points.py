"""A planner that an installed package registers has a name like any other, and harms no other."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from kinolab import cli, planners
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from tests.search.plugins.authors import PLANNER, Installer, install
from tests.support import OPEN

Capture = pytest.CaptureFixture[str]

__all__ = ["install"]  # the fixture

SILENT = ("--no-animation", "--quiet")
NAME = "push-planner 1.0"


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with the table in it."""
    folder = tmp_path / "home"
    folder.mkdir()
    monkeypatch.chdir(folder)
    (folder / "table.toml").write_text(OPEN)
    return folder


def told(name: str) -> str:
    with pytest.raises(InputError) as caught:
        planners.get(name)
    return str(caught.value)


def listed(capsys: Capture) -> list[dict[str, object]]:
    capsys.readouterr()
    assert cli.run(["list", "planners", "--json"]) == 0
    found: list[dict[str, object]] = json.loads(capsys.readouterr().out)["planners"]
    return found


def test_it_is_known_by_its_name_everywhere(
    home: Path, install: Installer, table: PlanningTask, capsys: Capture
) -> None:
    install("push-planner", PLANNER, pusher="push_planner:Pusher")
    assert set(planners.names()) == {*planners.built_in(), "pusher"}
    assert table.solve(planner="pusher", share=1.0).status == "solved"
    assert cli.run(["table.toml", "--planner", "pusher", *SILENT]) == 0
    table_of_its_own = OPEN.replace('name = "rrt"', 'name = "pusher"\nshare = 0.7')
    (home / "own.toml").write_text(table_of_its_own)
    assert cli.run(["own.toml", *SILENT]) == 0
    assert 'name = "pusher"' in (home / "runs" / "own" / "scenario.toml").read_text()
    assert cli.run(["check", "runs/own"]) == 0
    (entry,) = (entry for entry in listed(capsys) if entry["name"] == "pusher")
    assert entry["summary"] == "Push on with one input until the goal is reached."
    assert (entry["source"], entry["origin"]) == ("Newton, Principia, 1687.", NAME)


def test_its_settings_are_checked_as_all_are(install: Installer, table: PlanningTask) -> None:
    install("push-planner", PLANNER, pusher="push_planner:Pusher")
    with pytest.raises(InputError, match="share: 2 is out of range"):
        table.solve(planner="pusher", share=2)
    with pytest.raises(InputError, match="Did you mean 'pusher'"):
        table.solve(planner="pushr")


def test_nothing_of_it_is_imported_unasked(install: Installer, table: PlanningTask) -> None:
    install("push-planner", "raise SystemExit('imported')\n", pusher="push_planner:Pusher")
    assert "pusher" in planners.names()
    assert table.solve(planner="rrt", seed=1).status == "solved"


REPAIR = f"Repair or uninstall {NAME}."
BROKEN = {
    "it has no module": (
        None,
        "importing push_planner:Pusher of push-planner 1.0 failed "
        f"(ModuleNotFoundError: No module named 'push_planner'). {REPAIR}",
    ),
    "its module fails": (
        "import math\n\nmath.sqrt(-1)\n",
        "importing push_planner:Pusher of push-planner 1.0 failed on line 3 of push_planner.py "
        f"(ValueError: math domain error). {REPAIR}",
    ),
    "it needs another package": (
        "import nowhere\n",
        "importing push_planner:Pusher of push-planner 1.0 failed on line 1 of push_planner.py "
        f"(ModuleNotFoundError: No module named 'nowhere'). {REPAIR}",
    ),
    "it is no Python": (
        "a = 1\ndef (:\n",
        "importing push_planner:Pusher of push-planner 1.0 failed on line 2 of push_planner.py "
        f"(SyntaxError: invalid syntax (push_planner.py, line 2)). {REPAIR}",
    ),
    "its class is missing": (
        "",
        "importing push_planner:Pusher of push-planner 1.0 failed "
        f"(AttributeError: module 'push_planner' has no attribute 'Pusher'). {REPAIR}",
    ),
    "its class is no planner": (
        "class Pusher: ...\n",
        "push_planner:Pusher of push-planner 1.0 is a class, not a planner. "
        "Derive a class from kinolab.search.planner.AbstractPlanner.",
    ),
    "its class is not finished": (
        PLANNER.replace("def solve", "def search"),
        "push_planner:Pusher of push-planner 1.0 does not define solve(). "
        "Write def solve(self, problem, seed, budget).",
    ),
    "its class has another name": (
        PLANNER.replace('"pusher"', '"shover"'),
        "push-planner 1.0 registers push_planner:Pusher as 'pusher', but it calls itself 'shover'. "
        "A planner has one name: its class's and its entry point's.",
    ),
}


@pytest.mark.usefixtures("home")
@pytest.mark.parametrize(("code", "words"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_package_is_told_where_its_planner_is_named(
    install: Installer, capsys: Capture, code: str | None, words: str
) -> None:
    install("push-planner", code, pusher="push_planner:Pusher")
    assert told("pusher") == f"[planner] name: {words}"
    assert cli.run(["table.toml", "--planner", "pusher", *SILENT]) == 2
    assert capsys.readouterr().err == f"error: --planner: {words}\n"


@pytest.mark.usefixtures("home")
@pytest.mark.parametrize(("code", "words"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_package_disturbs_no_other_planner_and_no_list(
    install: Installer, capsys: Capture, code: str | None, words: str
) -> None:
    install("push-planner", code, pusher="push_planner:Pusher")
    entries = {entry["name"]: entry for entry in listed(capsys)}
    assert set(entries) == {*planners.built_in(), "pusher"}
    assert entries["pusher"]["fault"] == words
    assert {entry["fault"] for name, entry in entries.items() if name != "pusher"} == {""}
    for arguments in (["list"], ["list", "planners"], ["list", "planners", "pusher"]):
        assert cli.run(arguments) == 0
        assert f"cannot be used: {words}" in capsys.readouterr().out
    assert cli.run(["table.toml", *SILENT]) == 0


@pytest.mark.usefixtures("home")
def test_a_planner_of_kinolabs_keeps_its_name(
    install: Installer, table: PlanningTask, capsys: Capture
) -> None:
    before = planners.get("rrt")
    install("push-planner", PLANNER.replace('"pusher"', '"rrt"'), rrt="push_planner:Pusher")
    assert planners.get("rrt") is before
    assert table.solve(planner="rrt", seed=1).status == "solved"
    own, other = (entry for entry in listed(capsys) if entry["name"] == "rrt")
    assert (own["origin"], own["fault"], other["origin"]) == ("", "", NAME)
    assert other["fault"] == (
        "push-planner 1.0 registers a planner 'rrt', as kinolab does; kinolab's is used. "
        "Let the package choose another name."
    )
    assert cli.run(["list", "--json"]) == 0
    names = [entry["name"] for entry in json.loads(capsys.readouterr().out)["planners"]]
    assert names == list(planners.built_in())


def test_two_packages_with_one_name_are_both_told(install: Installer) -> None:
    for package in ("push-planner", "shove-planner"):
        install(package, PLANNER, pusher=f"{package.replace('-', '_')}:Pusher")
    assert told("pusher") == (
        "[planner] name: push-planner 1.0 and shove-planner 1.0 register a planner 'pusher' each. "
        "Uninstall all but one."
    )
    assert "rrt" in planners.names()


def test_a_search_that_fails_is_told_by_its_line(install: Installer, table: PlanningTask) -> None:
    code = PLANNER.replace("        u = self", "        1 / 0\n        u = self")
    install("push-planner", code, pusher="push_planner:Pusher")
    line = code[: code.index("1 / 0")].count("\n") + 1
    with pytest.raises(InputError) as caught:
        table.solve(planner="pusher")
    assert str(caught.value) == (
        f"[planner]: running Pusher.solve() of push_planner.py failed on line {line} "
        "(ZeroDivisionError: division by zero)."
    )

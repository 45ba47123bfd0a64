"""``plan list``: what there is, and all about every planner."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from kinolab import cli, planners, systems
from kinolab.scenario import builtin_scenarios, shared_settings
from kinolab.settings import settings_of
from tests.search.plugins.authors import PLANNER

Capture = pytest.CaptureFixture[str]

every_planner = pytest.mark.parametrize("name", planners.built_in())


def out(capsys: Capture, *arguments: str) -> str:
    assert cli.run(["list", *arguments]) == 0
    return capsys.readouterr().out


def data(capsys: Capture, *arguments: str) -> Any:
    return json.loads(out(capsys, *arguments, "--json"))


def test_the_list_of_all_is_three_headings_with_names_below(capsys: Capture) -> None:
    text = out(capsys)
    headings = [line for line in text.splitlines() if not line.startswith("  ")]
    assert headings == ["scenarios", "systems", "planners"]
    below = [line.split()[0] for line in text.splitlines() if line.startswith("  ")]
    assert below == [*builtin_scenarios(), *systems.names(), *planners.names()]
    assert all(line.endswith(".") for line in text.partition("systems")[2].splitlines()[2:3])


@pytest.mark.parametrize(
    ("group", "names"), [("scenarios", list(builtin_scenarios())), ("systems", systems.names())]
)
def test_a_group_is_its_names_with_a_line_each(
    capsys: Capture, group: str, names: list[str]
) -> None:
    lines = out(capsys, group).splitlines()
    assert [line.split()[0] for line in lines] == list(names)
    entries = data(capsys, group)
    assert list(entries) == [group]
    assert [f"{entry['name']} {entry['summary']}".split() for entry in entries[group]] == [
        line.split() for line in lines
    ]
    assert out(capsys, group, names[1]).split() == lines[1].split()


@every_planner
def test_a_planner_is_told_with_its_source_and_all_its_settings(capsys: Capture, name: str) -> None:
    """Columns are at least two blanks apart; what a setting means comes last."""
    first, *rest = out(capsys, "planners", name).splitlines()
    assert first.startswith(f"{name}: ")
    assert first.endswith(".")
    (source,) = (line for line in rest if line.startswith("  source: "))
    assert source.endswith(".")
    rows = [line for line in rest if line != source]
    assert rows[0].split() == ["setting", "default", "unit", "range", "meaning"]
    settings = settings_of(planners.get(name))
    assert [row.split()[0] for row in rows[1:]] == [entry.name for entry in settings]
    meaning, unit, values = (rows[0].index(title) for title in ("meaning", "unit", "range"))
    for row, entry in zip(rows[1:], settings, strict=True):
        assert row[meaning:] == entry.meaning
        assert row[unit:values].strip() == entry.unit
        assert row[values:meaning].strip() == entry.range


def test_the_settings_of_rrt_are_those_of_its_paper(capsys: Capture) -> None:
    (entry,) = data(capsys, "planners", "rrt")["planners"]
    assert entry["source"] == "LaValle, Kuffner, IJRR 20(5), 2001."
    (bias,) = (item for item in entry["settings"] if item["name"] == "goal_bias")
    assert bias == {
        "name": "goal_bias",
        "default": 0.05,
        "lowest": 0.0,
        "highest": 1.0,
        "above": None,
        "unit": "",
        "range": "0 to 1",
        "meaning": "Probability of growing toward the goal instead of anywhere.",
    }


def test_the_keys_that_planners_share_are_told_once(capsys: Capture) -> None:
    text = out(capsys, "planners")
    for entry in shared_settings():
        assert text.count(f"\n  {entry.name} ") == 1
    assert "further keys of [planner], for every planner" in text
    shared = data(capsys, "planners")["shared_settings"]
    assert [entry["name"] for entry in shared] == [entry.name for entry in shared_settings()]
    assert shared[0] | {"meaning": ""} == {
        "name": "time_limit",
        "default": 30.0,
        "lowest": None,
        "highest": None,
        "above": 0,
        "unit": "s",
        "range": "more than 0",
        "meaning": "",
    }


def test_every_planner_is_told_of(capsys: Capture) -> None:
    told = data(capsys, "planners")["planners"]
    assert tuple(entry["name"] for entry in told) == planners.names()
    text = out(capsys, "planners")
    assert all(f"\n{name}: " in f"\n{text}" for name in planners.names())


def test_a_planner_in_a_file_is_told_with_its_file(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pusher.py").write_text(PLANNER)
    assert out(capsys, "planners", "pusher.py:Pusher") == (
        "pusher.py:Pusher: Push on with one input until the goal is reached.\n"
        "  from pusher.py\n"
        "  source: Newton, Principia, 1687.\n"
        "  setting  default  unit  range   meaning\n"
        "  share    0.5            0 to 1  Share of the largest input.\n"
    )


def test_a_planner_without_a_word_about_itself_is_told_by_its_name(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Dataclasses write a signature where there is no docstring; it is no summary."""
    monkeypatch.chdir(tmp_path)
    code = re.sub(r'    """Push.*?"""\n', "", PLANNER, flags=re.DOTALL)
    code = re.sub(r"setting\(0.5.*\)", "0.5", code)
    (tmp_path / "pusher.py").write_text(code)
    assert out(capsys, "planners", "pusher.py:Pusher") == (
        "pusher.py:Pusher\n"
        "  from pusher.py\n"
        "  setting  default  unit  range  meaning\n"
        "  share    0.5\n"
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("planners", "rtt"), "no planner is called 'rtt'. Did you mean 'rrt'?"),
        (("systems", "crain"), "no system is called 'crain'. Did you mean 'crane'?"),
        (("scenarios", "two_crans"), "no scenario is called 'two_crans'. Did you mean"),
        (("planners", "nothing.py:At"), "error: there is no Python file nothing.py."),
        (("machines",), "'machines' is not one of 'scenarios', 'systems', 'planners', 'options'."),
    ],
)
def test_what_is_not_there_is_told(capsys: Capture, arguments: tuple[str, ...], words: str) -> None:
    assert cli.run(["list", *arguments]) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.out == ""

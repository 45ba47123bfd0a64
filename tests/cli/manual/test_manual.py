"""The manual is what its code says, complete, and the command line prints it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from kinolab import cli
from kinolab.cli.manual import PAGES
from kinolab.cli.manual.sections import anchors_of, sections_of
from tests.support import ROOT

Capture = pytest.CaptureFixture[str]


def page_in_docs(topic: str) -> str:
    return (ROOT / "docs" / PAGES[topic].file).read_text(encoding="utf-8")


@pytest.mark.parametrize("topic", PAGES)
def test_the_page_is_what_its_script_writes(topic: str) -> None:
    """If this fails: ``python tools/write_manual.py``."""
    assert PAGES[topic].text() == page_in_docs(topic)


@pytest.mark.parametrize("topic", PAGES)
def test_plan_help_prints_the_page(topic: str, capsys: Capture) -> None:
    assert cli.run(["help", topic]) == 0
    assert capsys.readouterr().out.strip() == page_in_docs(topic).strip()


@pytest.mark.parametrize(
    ("topic", "name", "found"),
    [
        ("machine", "Spring", "stiffness"),
        ("machine", "reacts_on", "The body that takes the reaction torque"),
        ("scenario", "goal", "at_rest"),
        ("scenario", "[[world.obstacle]]", "Rz(yaw) Ry(pitch) Rx(roll)"),
        ("scenario", "reserve", "share of every tolerance"),
        ("files", "assets/", "machine.json"),
        ("files", "goal_distance_by_unit", "metres and radians do not add up"),
    ],
)
def test_plan_help_explains_one_name(topic: str, name: str, found: str, capsys: Capture) -> None:
    assert cli.run(["help", topic, name]) == 0
    told = capsys.readouterr().out
    assert found in told
    assert len(told) < len(PAGES[topic].text()) / 4


def test_plan_help_alone_names_the_topics(capsys: Capture) -> None:
    assert cli.run(["help"]) == 0
    printed = capsys.readouterr().out
    assert all(f"plan help {topic} " in printed for topic in PAGES)


def test_plan_help_names_the_nearest_word(capsys: Capture) -> None:
    assert cli.run(["help", "machine", "Sprnig"]) == 2
    assert "Did you mean 'Spring'?" in capsys.readouterr().err


@pytest.mark.parametrize("topic", PAGES)
def test_every_link_leads_somewhere(topic: str) -> None:
    text = page_in_docs(topic)
    anchors = set(anchors_of(section.title for section in sections_of(text) if section.title))
    links = re.findall(r"\]\(([^)\s]*)\)", text)
    assert len(links) > 3
    assert {link for link in links if link.startswith("#")} <= anchors
    files = {link.partition("#")[0] for link in links} - {""}
    assert [file for file in files if not (ROOT / "docs" / file).is_file()] == []


def test_a_heading_that_comes_twice_has_a_link_of_its_own() -> None:
    """As GitHub numbers them: letter case and marks do not count."""
    assert anchors_of(["State", "`state`", "[[goal.point]]"]) == [
        "#state",
        "#state-1",
        "#goalpoint",
    ]


def test_what_looks_like_a_heading_in_code_is_none() -> None:
    text = "# Page\n\n```python\n## not one\n```\n\n## One\n\ntext\n"
    assert [section.title for section in sections_of(text)] == ["", "One"]


def test_the_pages_are_named_where_one_looks_for_them() -> None:
    commands = Path(ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    for topic, page in PAGES.items():
        assert f"]({page.file})" in commands
        assert f"plan help {topic}" in page.text()

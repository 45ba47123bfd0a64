"""The gallery in docs shows the machines and scenarios that there are."""

from __future__ import annotations

import re
from runpy import run_path

import pytest

from kinolab import systems
from kinolab.scenario import builtin_scenarios, load_scenario
from tests.support import ROOT

DOCS = ROOT / "docs"
GALLERY = run_path(str(ROOT / "tools" / "write_gallery.py"))
PAGE = (DOCS / "gallery.md").read_text(encoding="utf-8")


def section(name: str) -> str:
    """Return what the page says about a machine."""
    title = re.escape(name.replace("_", " ").capitalize())
    found = re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", PAGE, flags=re.MULTILINE | re.DOTALL)
    assert found, f"no section for {name}"
    return found[1]


def test_the_page_is_what_its_script_writes() -> None:
    """If this fails: ``python tools/write_gallery.py``."""
    assert GALLERY["page"]() == PAGE


@pytest.mark.parametrize("name", systems.names())
def test_every_machine_has_a_section_with_all_its_names(name: str) -> None:
    machine, text = systems.get(name), section(name)
    listed = {*machine.coordinates, *machine.inputs, *machine.parameters, *machine.states}
    assert all(f"\n| `{entry.name}` |" in text for entry in listed)
    held = {*machine.all_constraints, *machine.all_requirements}
    assert all(f"\n| {entry.name} |" in text for entry in held)


@pytest.mark.parametrize("name", builtin_scenarios())
def test_every_scenario_is_shown_with_its_machine(name: str) -> None:
    scenario = load_scenario(builtin_scenarios()[name])
    text = section(str(scenario.system.name))
    assert f"### {scenario.title}\n\n```sh\nplan {name}\n```" in text
    obstacles = [f"\n| {entry.name} |" for entry in scenario.world.obstacle]
    goal = [f"\n| `{coordinate}` |" for coordinate in scenario.goal.values]
    assert all(line in text for line in (*obstacles, *goal))


def test_every_picture_of_the_page_exists() -> None:
    pictures = re.findall(r"\]\((images/[^)]+)\)", PAGE)
    assert "images/rolling_disk_maze.gif" in pictures
    assert all((DOCS / picture).is_file() for picture in pictures)


def test_every_link_of_the_page_leads_to_a_section() -> None:
    titles = re.findall(r"^## (.*)$", PAGE, flags=re.MULTILINE)
    anchors = {title.lower().replace(" ", "-") for title in titles}
    links = re.findall(r"\]\(#([^)]+)\)", PAGE)
    assert set(links) == anchors


def test_units_and_limits_read_as_on_paper() -> None:
    assert GALLERY["units"]("N s^2/m^2") == "N s²/m²"
    assert GALLERY["interval"](-0.5, 2.0) == "-0.5 to 2"
    assert GALLERY["interval"](0.0, float("inf")) == "at least 0"
    assert GALLERY["number"](-0.0) == "0"
    assert GALLERY["grouped"](87936) == "87 936"


def test_a_film_is_sped_up_to_its_number_of_frames() -> None:
    """80 frames at 12.5 per second have 79 gaps of 0.08 s: 6.32 s of film."""
    assert GALLERY["speed_for"](5.0, 80) == 1.0
    assert GALLERY["speed_for"](63.0, 80) == 10.0
    assert GALLERY["speed_for"](63.3, 80) == 10.5

"""The gallery in docs shows the machines and scenarios that there are."""

from __future__ import annotations

import logging
import re
from collections import Counter
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import pytest

import kinolab
from kinolab import systems
from kinolab.scenario import builtin_scenarios, load_scenario
from tests.support import ROOT

DOCS = ROOT / "docs"
GALLERY = run_path(str(ROOT / "tools" / "write_gallery.py"))
PAGE = (DOCS / "gallery.md").read_text(encoding="utf-8")
FILMS = sorted(path.stem for path in (DOCS / "images").glob("*.gif"))


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
    first = next(iter((scenario.system.machines or {"": scenario.system}).values()))
    text = section(str(first.name))
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


def test_every_film_of_the_page_leads_to_a_plan_and_so_does_a_line_below_it() -> None:
    assert {path.stem for path in (DOCS / "plans").iterdir()} == set(FILMS)
    links = r'<a class="plan" href="gallery/(\w+)\.html">'
    assert Counter(re.findall(links, PAGE)) == dict.fromkeys(FILMS, 2)
    assert re.findall(rf"^{links}!\[.*\]\(images/\1\.gif\)</a>$", PAGE, re.MULTILINE)


@pytest.mark.parametrize("name", FILMS)
def test_every_kept_motion_solves_its_scenario(name: str) -> None:
    """If this fails: ``python tools/write_gallery.py --plans NAME``."""
    problem = kinolab.load(name)
    certificate = kinolab.verify(problem, GALLERY["kept_motion"](problem))
    assert certificate.passed, certificate


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The step of the site's build that writes pages of plans, and a folder for its plans."""
    pytest.importorskip("sphinx-mathjax-offline")  # of the extra docs, as Sphinx is
    monkeypatch.setenv("KINOLAB_SOLUTIONS", "")  # which the configuration sets: restored afterwards
    step = run_path(str(DOCS / "conf.py"))["_plans"]
    monkeypatch.setitem(step.__globals__, "run_path", lambda _: GALLERY)
    monkeypatch.setitem(GALLERY["plan_of"].__globals__, "PLANS", tmp_path)
    return step


def built(step: Any, site: Path, builder: str = "html") -> list[str]:
    """Take the step, and return the files that the site has then."""
    step(SimpleNamespace(builder=SimpleNamespace(name=builder), outdir=str(site)))
    return [path.relative_to(site).as_posix() for path in site.rglob("*") if path.is_file()]


def test_the_build_writes_the_page_that_the_film_leads_to(
    tmp_path: Path, build: Any, caplog: pytest.LogCaptureFixture
) -> None:
    kept = (DOCS / "plans" / "pendulum_swingup.csv").read_bytes()
    (tmp_path / "pendulum_swingup.csv").write_bytes(kept)
    assert built(build, tmp_path / "text", "text") == []
    page = "gallery/pendulum_swingup.html"
    assert built(build, tmp_path / "site") == [page]
    assert f'href="{page}"' in PAGE
    assert '"status": "solved"' in (tmp_path / "site" / page).read_text(encoding="utf-8")
    assert not caplog.records


def test_a_motion_that_does_not_solve_its_scenario_is_a_warning_of_the_build(
    tmp_path: Path, build: Any, caplog: pytest.LogCaptureFixture
) -> None:
    """A motion that stops half-way does not reach the goal."""
    header, *rows = (DOCS / "plans" / "pendulum_swingup.csv").read_text().splitlines()
    last = ",".join([*rows[len(rows) // 2].split(",")[:-1], ""])  # of its one input, none
    half = "\n".join([header, *rows[: len(rows) // 2], last, ""])
    (tmp_path / "pendulum_swingup.csv").write_text(half)
    assert built(build, tmp_path / "site") == []
    [record] = caplog.records
    assert record.levelno == logging.WARNING
    assert "does not solve the scenario pendulum_swingup: FAILED goal" in record.getMessage()
    assert "write_gallery.py --plans pendulum_swingup" in record.getMessage()

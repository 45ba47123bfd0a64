"""Many runs on one page: what is said of them, and that nobody's text becomes code."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

import kinolab
from kinolab.cli import run
from kinolab.runs import write_run
from kinolab.show.page.gallery import Card, gallery_html
from kinolab.show.view import cards
from tests.show.view.browsing import Opener, inner_frames, needs_chromium, until

PNG = b"\x89PNG\r\n"


def data(page: str, name: str) -> Any:
    found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', page, re.S)
    assert found is not None
    return json.loads(found[1])


@pytest.fixture(scope="module")
def gallery(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, int, str]:
    """A run that is sound, one that somebody changed and called solved, and one that is none."""
    folder = tmp_path_factory.mktemp("class")
    problem = kinolab.load("pendulum_swingup")
    plan = problem.solve(planner="rrt_fast", seed=1, max_iterations=5000, optimize=False)
    for name in ("ada", "bob"):
        write_run(folder / name, problem, plan)
    changed = folder / "bob" / "trajectory.csv"
    rows = changed.read_text().splitlines()
    time, angle, *rest = rows[20].split(",")
    rows[20] = ",".join([time, str(float(angle) + 0.1), *rest])
    changed.write_text("\n".join(rows) + "\n")
    (folder / "eve").mkdir()
    out = folder / "gallery.html"
    code = run(["gallery", *(str(folder / n) for n in ("ada", "bob", "eve")), "--out", str(out)])
    return folder, code, out.read_text()


def test_runs_are_judged_by_their_files_and_not_by_their_reports(
    gallery: tuple[Path, int, str],
) -> None:
    folder, code, page = gallery
    assert code == 7
    shown = {Path(card["name"]).name: card for card in data(page, "runs")}
    verdicts = {name: card["verdict"] for name, card in shown.items()}
    assert verdicts == {"ada": "passed", "bob": "failed", "eve": "damaged"}
    assert json.loads((folder / "bob" / "report.json").read_text())["status"] == "solved"
    assert "there is no such file" in shown["eve"]["title"]
    assert dict(shown["ada"]["facts"])["Machine"] == "pendulum"


def test_each_page_is_whole_once_the_library_is_put_in(gallery: tuple[Path, int, str]) -> None:
    """And the library, which is most of every page, is there once."""
    _, _, page = gallery
    shared, (ada, *_) = data(page, "shared"), data(page, "runs")
    whole = ada["page"].replace("<library>", shared)
    assert whole.startswith("<!doctype html>")
    assert whole.rstrip().endswith("</html>")
    assert len(shared) > 300_000
    assert all(len(card["page"]) < len(shared) / 2 for card in data(page, "runs"))


def test_what_somebody_wrote_is_shown_and_never_run() -> None:
    evil = "</script><script>alert(1)</script><!--"
    page = gallery_html(evil, [Card(evil, evil, "passed", ((evil, evil),), PNG, evil)])
    (card,) = data(page, "runs")
    assert (card["name"], card["facts"]) == (evil, [[evil, evil]])
    assert card["poster"].startswith("data:image/png;base64,")
    assert evil not in page
    assert page.count("<script") == page.count("</script>") == 3


def test_a_film_is_taken_from_the_run_s_own_folder(tmp_path: Path) -> None:
    """A link may lead to a picture of the reader's, who puts the gallery on the web."""
    (tmp_path / "private.gif").write_bytes(b"GIF89a private")
    (tmp_path / "run").mkdir()
    film = tmp_path / "run" / "animation.gif"
    film.symlink_to(tmp_path / "private.gif")
    assert cards._film(tmp_path / "run") == b""
    film.unlink()
    film.write_bytes(b"GIF89a own")
    assert cards._film(tmp_path / "run") == b"GIF89a own"


@needs_chromium
def test_cards_are_filtered_and_open_their_pages(
    gallery: tuple[Path, int, str], browse: Opener
) -> None:
    """The page of a run plays in a frame that can reach nothing of the gallery around it."""
    page = browse(gallery[0] / "gallery.html")
    assert page.inner_text("#count") == "3 of 3 runs, 1 passed the check"
    page.fill("#filter", "ada checked")
    assert page.inner_text("#count") == "1 of 3 runs, 1 passed the check"
    assert page.locator(".card:visible").count() == 1
    page.click(".card:visible")
    assert page.evaluate("document.activeElement.innerText") == "← Gallery"
    (inside,) = inner_frames(page)
    assert inside.evaluate("async () => (await kinolab.ready).last > 0")
    assert inside.evaluate("() => { kinolab.seek(1); return kinolab.time; }") == 1
    refused = "() => { try { return parent.document.title; } catch (error) { return error.name; } }"
    assert inside.evaluate(refused) == "SecurityError"
    page.keyboard.press("Escape")
    page.wait_for_selector("#frame iframe", state="detached")


@needs_chromium
def test_two_runs_are_compared_side_by_side_and_play_together(
    gallery: tuple[Path, int, str], browse: Opener
) -> None:
    page = browse(gallery[0] / "gallery.html")
    for k in range(2):
        page.locator(".pick input").nth(k).check()
    page.click("#compare")
    frames = inner_frames(page)
    assert len(frames) == 2
    for frame in frames:
        frame.evaluate("async () => { await kinolab.ready; kinolab.pause(); }")
    frames[0].evaluate("kinolab.seek(0.5 * kinolab.last)")
    half = frames[0].evaluate("kinolab.time")
    until(frames[1], f"Math.abs(kinolab.time - {half}) < 1e-6")

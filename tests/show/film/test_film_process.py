"""A film is drawn by a process of its own, after all that one waits for has been shown."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from queue import SimpleQueue

import numpy as np
import pytest

from kinolab import cli
from kinolab.analyze.simulate import simulate
from kinolab.problem import PlanningTask
from kinolab.show.film import film_process
from kinolab.show.film.animation import animate
from kinolab.show.film.film_messages import Drawn, Order
from kinolab.show.film.film_process import DrawingError, FilmProcess
from kinolab.show.film.staging.script import Script
from kinolab.show.film.staging.script_writing import write_script
from kinolab.show.scene.picture import Picture
from kinolab.trajectory import Trajectory
from tests.support import OPEN, environment, problem_of

SMALL = "[render]\nsize = [64, 64]\n"  # pixels, which are drawn at once
HEAVY = {"sympy", "trimesh", "fcl", "ompl", "pydantic", "matplotlib", "kinolab.dynamics"}
IMPORTED = "import sys, kinolab.show.film.drawing; print(*sys.modules)"
LOADED = """
import numpy as np
from numba.core.dispatcher import Dispatcher
from kinolab.show.film import drawing
from kinolab.show.film.gif import gif_parts
from kinolab.show.film.raster import rasterizer

def loaded():
    found = {k: v for k, v in vars(rasterizer).items() if isinstance(v, Dispatcher)}
    return {name: len(one.signatures) for name, one in found.items()}

drawing.load()
before = loaded()
from tests.show.film.films import make_film
from tests.show.film.test_inset import LONG, PAIR, SIZE, Picture, pair_at
poses = np.stack([pair_at(-9.0, 0.3), pair_at(0.0, 0.3)])
film = make_film(Picture(bodies=PAIR, ground=True, bounds=LONG), [0.0, 1.0], poses, size=SIZE,
                 magnify=True)
assert film.magnifier is not None
b"".join(gif_parts(film))
assert loaded() == before, (before, loaded())
assert before["_draw"] == 1
"""


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    """A coin in the open, in small pictures."""
    return problem_of(tmp_path_factory.mktemp("film"), OPEN + SMALL)


@pytest.fixture
def motion(table: PlanningTask) -> Trajectory:
    """Of a coin that is let go."""
    return simulate(table, 0.2)


def a_script() -> Script:
    """Of nothing that does not move."""
    return write_script(Picture(bodies=()), [0.0, 1.0], np.zeros((2, 0, 12)))


def drawn(film: FilmProcess, problem: PlanningTask, trajectory: Trajectory) -> bytes:
    """The film that a process draws."""
    film.begin(problem, trajectory)
    return film.animation()


def test_the_process_draws_the_same_film(table: PlanningTask, motion: Trajectory) -> None:
    with FilmProcess() as film:
        assert drawn(film, table, motion) == animate(table, motion)


def test_only_the_final_motion_is_shown_whatever_was_better_for_a_while(
    table: PlanningTask, motion: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(film_process, "processors", lambda: 2)
    with FilmProcess() as film:
        for duration in (0.5, 0.4, 0.3):
            film.suggest(table, simulate(table, duration))
        assert drawn(film, table, motion) == animate(table, motion)


def test_each_film_that_was_begun_is_finished_before_a_newer_one_is(
    table: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However fast better motions come; those between the first and the newest are left out."""
    monkeypatch.setattr(film_process, "processors", lambda: 2)
    motions = [simulate(table, duration) for duration in (0.5, 0.4, 0.3)]
    films: SimpleQueue[tuple[int, bytes]] = SimpleQueue()
    with FilmProcess() as film:
        film.suggest(table, motions[0], lambda content: films.put((0, content)))
        first = films.get(timeout=60)
        for k in (0, 1, 2):
            film.suggest(table, motions[k], lambda content, k=k: films.put((k, content)))  # type: ignore[misc]
        assert film.begin(table, motions[2]) is None or films.qsize() == 2
        while (last := films.get(timeout=60))[0] != 2:
            pass
    assert [first, last] == [(k, animate(table, motions[k])) for k in (0, 2)]


def test_a_film_that_is_under_way_is_not_begun_again(
    table: PlanningTask, motion: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(film_process, "processors", lambda: 2)
    with FilmProcess() as film:
        film.suggest(table, motion)
        assert drawn(film, table, simulate(table, 0.2)) == animate(table, motion)
        assert film._orders == 1


def test_with_one_processor_nothing_is_drawn_before_the_plan_is_final(
    table: PlanningTask, motion: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(film_process, "processors", lambda: 1)
    with FilmProcess() as film:
        film.suggest(table, motion)
        assert film._orders == 0
        assert drawn(film, table, motion) == animate(table, motion)


def test_a_suggestion_that_goes_wrong_disturbs_nothing_until_the_film_is_wanted(
    table: PlanningTask, motion: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: object) -> None:
        raise ValueError("no script")

    monkeypatch.setattr(film_process, "processors", lambda: 2)
    monkeypatch.setattr(film_process, "motion_script", failing)
    with FilmProcess() as film:
        film.suggest(table, motion)
        with pytest.raises(ValueError, match="no script"):
            film.begin(table, motion)


def test_without_a_process_the_film_is_drawn_here(
    table: PlanningTask, motion: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError("no room for another process")

    monkeypatch.setattr(film_process, "WorkerProcess", full)
    with FilmProcess() as film:
        assert drawn(film, table, motion) == animate(table, motion)


def python(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment(), capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_what_draws_imports_neither_a_machine_nor_a_world() -> None:
    names = set(python(IMPORTED).split())
    assert "kinolab.show.film.film" in names
    assert names & HEAVY == set()
    assert not any(name.startswith("kinolab.world") for name in names)


def test_what_plans_loads_nothing_that_draws() -> None:
    names = python("import sys, kinolab.show.film.film_process; print(*sys.modules)").split()
    assert "kinolab.show.film.staging.script" in names
    assert [name for name in names if name.endswith((".rasterizer", ".gif"))] == []


def test_all_loops_are_loaded_before_the_film_comes() -> None:
    """In the same types: nothing is left to be loaded, or compiled, once the plan is there."""
    python(LOADED)


def test_a_process_that_is_killed_is_told_of(table: PlanningTask, motion: Trajectory) -> None:
    with FilmProcess() as film:
        assert film._worker is not None
        os.kill(film._worker.process.pid, signal.SIGKILL)
        film._worker.process.wait()
        with pytest.raises(DrawingError, match="was ended"):
            drawn(film, table, motion)


def test_where_memory_is_short_it_says_so_as_ever() -> None:
    film = FilmProcess()
    film._drawn = Drawn(0, None)
    with pytest.raises(MemoryError):
        film._received()


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with the table in it."""
    (tmp_path / "table.toml").write_text(OPEN + SMALL)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "runs" / "table"


def test_summary_and_page_come_before_the_film_and_the_folder_is_named_last(
    home: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    draw, said = FilmProcess.animation, []

    def watched(film: FilmProcess) -> bytes:
        said.append(capsys.readouterr().out)
        for name in ("report.json", "trajectory.csv", "scene.html"):
            assert (home / name).is_file()
        assert not (home / "animation.gif").exists()
        return draw(film)

    monkeypatch.setattr(FilmProcess, "animation", watched)
    assert cli.run(["table.toml", "--quiet"]) == 0
    (before,), after = said, capsys.readouterr().out
    assert before.startswith("solved: ")
    assert "checks passed\n" in before
    assert "proved" in before.splitlines()[-1]  # a lower bound, while the film is drawn
    assert after == f"  written to {Path('runs', 'table')}\n"
    assert (home / "animation.gif").is_file()
    assert list(home.glob(".*")) == []  # half-written files


@pytest.mark.usefixtures("home")
def test_one_object_of_json_is_printed_when_all_is_written(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    draw = FilmProcess.animation

    def watched(film: FilmProcess) -> bytes:
        assert capsys.readouterr().out == ""
        return draw(film)

    monkeypatch.setattr(FilmProcess, "animation", watched)
    assert cli.run(["table.toml", "--quiet", "--json"]) == 0
    assert capsys.readouterr().out.startswith("{")


def test_a_film_that_cannot_be_drawn_is_a_mistake_and_the_plan_stays(
    home: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    unfit = Order(1, replace(a_script(), size=(0, 0)))  # of which nothing can be drawn
    monkeypatch.setattr(film_process, "Order", lambda number, _: replace(unfit, number=number))
    assert cli.run(["table.toml", "--quiet"]) == 70
    captured = capsys.readouterr()
    assert captured.out.startswith("solved: ")
    assert "written to" not in captured.out
    assert "drawing.py" in captured.err  # where in the process it failed
    assert captured.err.endswith("error: this is a mistake in kinolab; please report it.\n")
    assert (home / "scene.html").is_file()
    assert not (home / "animation.gif").exists()


@pytest.mark.usefixtures("home")
def test_no_process_is_started_where_no_film_is_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise AssertionError("a process was started")

    monkeypatch.setattr(film_process, "WorkerProcess", refused)
    assert cli.run(["table.toml", "--quiet", "--no-animation"]) == 0
    lost = ["--max-iterations", "1", "--no-diagnosis", "--set", "goal.tolerance=1e-9"]
    assert cli.run(["table.toml", "--quiet", *lost]) != 0

"""The studio without a browser: what a text means, poses, files, and searches that may crash."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("tomlkit")
viser = pytest.importorskip("viser")

import kinolab  # noqa: E402
from kinolab.dynamics.analysis.consistent_states import constraint_violations  # noqa: E402
from kinolab.errors import InputError  # noqa: E402
from kinolab.problem import PlanningTask  # noqa: E402
from kinolab.scenario import builtin_scenarios  # noqa: E402
from kinolab.studio.core import edits  # noqa: E402
from kinolab.studio.core.background_work import BackgroundWork, Ended  # noqa: E402
from kinolab.studio.core.chosen_folder import ChosenFolder, autosave  # noqa: E402
from kinolab.studio.core.meaning import meaning_of  # noqa: E402
from kinolab.studio.core.pose_edits import with_body_at, with_entry, written  # noqa: E402
from kinolab.studio.core.scenario_text import Put, edited  # noqa: E402
from kinolab.studio.core.search_task import Improved, search  # noqa: E402
from kinolab.studio.guarded_server import guarded_server  # noqa: E402
from kinolab.studio.scene.scene_nodes import SceneNodes  # noqa: E402

EMPTY = edits.empty("a world", "diff_drive")
PATIENCE = 600.0  # [s] for what may have to be compiled first
MOST_CALLS = 300  # of drawing, with those of gizmos and lights
OTHER_CALLS = 60


def test_a_text_means_a_problem_and_one_with_mistakes_the_last_good_one() -> None:
    good = meaning_of(EMPTY, Path("world.toml"))
    assert good.ready
    broken = meaning_of("schema = [", Path("world.toml"), good)
    assert broken.problem is good.problem
    assert broken.stale
    assert "this is not TOML" in str(broken.mistakes[0])


def test_ten_mistakes_are_told_at_once_each_with_its_place_and_its_remedy() -> None:
    lines = ["schema = 1", 'titel = "x"', "[system]", 'name = "dif_drive"']
    lines += ["[world]", 'ground = "plain"', "clearance = -1", "[[world.obstacle]]"]
    lines += ["box = [1, 2]", "[[world.obstacle]]", 'mesh = "none.stl"', "[goal]"]
    lines += ["tolerance = -1", "[planner]", "time_limit = 0", 'seed = "one"', "improve = -1"]
    found = meaning_of("\n".join(lines), Path("world.toml")).mistakes
    assert len(found) >= 10
    assert all(mistake.where for mistake in found)
    assert sum(bool(mistake.remedy) for mistake in found) >= 8


def test_what_touches_at_the_start_is_named() -> None:
    box = edits.add_obstacle({}, "box", [0.5, 0.5, 0.5], [0.5, 0.5, 0.25])
    meaning = meaning_of(edited(EMPTY, box), Path("world.toml"))
    assert ("robot", "box 1") in meaning.touching
    assert not meaning.ready


def test_a_scenario_without_a_goal_says_what_is_missing() -> None:
    changes = [*edits.ask({}, "x", 1.0, None), *edits.ask({}, "y", 1.0, None)]
    meaning = meaning_of(edited(EMPTY, changes), Path("world.toml"))
    assert "nothing says where the machine shall go" in str(meaning.mistakes[-1])


@pytest.mark.parametrize("name", builtin_scenarios())
def test_a_machine_that_is_dragged_keeps_its_constraints_and_limits(name: str) -> None:
    problem = kinolab.load(name)
    before = problem.frames(problem.start)[problem.leading, 3::4]
    reach = 0.02 * float(np.ptp([*problem.world.bounds.get("x", (0.0, 1.0))]))
    target = before + reach * np.array([1.0, 0.5, 0.0])
    state = with_body_at(problem, problem.start, problem.leading, target)
    assert constraint_violations(problem.model, state) == ()
    assert (state >= problem.bounds[:, 0] - 1e-9).all()
    assert (state <= problem.bounds[:, 1] + 1e-9).all()
    after = problem.frames(state)[problem.leading, 3::4]
    assert np.linalg.norm(after - target) <= np.linalg.norm(before - target) + 1e-9


def test_a_robot_that_is_turned_by_hand_heads_there() -> None:
    problem = kinolab.load({"system": "diff_drive", "goal": {"x": 1.0}, "world": _bounds()})
    c, s = np.cos(0.6), np.sin(0.6)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    pose = problem.frames(problem.start)[problem.leading].reshape(3, 4)
    state = with_body_at(problem, problem.start, problem.leading, pose[:, 3], turn @ pose[:, :3])
    assert state[problem.model.state_names.index("psi")] == pytest.approx(0.6, abs=1e-6)


def _bounds() -> dict[str, Any]:
    return {"bounds": {"x": [-5.0, 5.0], "y": [-5.0, 5.0]}, "ground": "plane"}


def test_a_loop_stays_closed_when_one_of_its_joints_is_moved_and_what_is_written_still_is() -> None:
    problem = kinolab.load("five_bar_table")
    name = problem.model.state_names[0]
    state = with_entry(problem, problem.start, name, float(problem.start[0]) + 0.1)
    changes = written(problem, problem.start, state)
    assert name in changes
    text = builtin_scenarios()["five_bar_table"].read_text(encoding="utf-8")
    again = edited(text, edits.set_state("start", changes))
    values = tomllib.loads(again)["start"]
    moved = kinolab.load({**tomllib.loads(again), "world": {}})
    assert constraint_violations(moved.model, moved.start) == ()
    assert values[name] != tomllib.loads(text)["start"][name]


@pytest.mark.parametrize(
    "name",
    ["../out.toml", "/etc/passwd", "a/../../b.toml", "..", ".", "", "~/../../x", "link/x", "a\0b"],
)
def test_nothing_outside_of_the_folder_is_reached(tmp_path: Path, name: str) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    (inside / "link").symlink_to(tmp_path)
    with pytest.raises(InputError, match="outside"):
        ChosenFolder(inside).path(name)


def test_only_meshes_of_a_moderate_size_are_kept(tmp_path: Path) -> None:
    folder = ChosenFolder(tmp_path)
    assert folder.keep_mesh("../../a.stl", b"solid") == "meshes/a.stl"
    assert (tmp_path / "meshes" / "a.stl").read_bytes() == b"solid"
    for name, content, what in (
        ("run.py", b"", "not a mesh"),
        (".stl", b"", "not a mesh"),
        ("b.stl", bytes(32_000_001), "larger"),
        ("a.stl", b"another", "another file"),
    ):
        with pytest.raises(InputError, match=what):
            folder.keep_mesh(name, content)


def test_what_was_not_saved_is_there_again_and_undo_leads_back_to_the_file(tmp_path: Path) -> None:
    folder, path = ChosenFolder(tmp_path), tmp_path / "world.toml"
    path.write_text(EMPTY)
    text, unsaved = folder.open(path)
    assert not unsaved
    text.edit("move it", [Put(("start", "x"), 2.0)])
    folder.autosave(path, text)
    assert path.read_text() == EMPTY
    again, unsaved = folder.open(path)
    assert unsaved
    assert again.values["start"]["x"] == 2.0
    again.undo()
    assert again.text == EMPTY
    again.redo()
    folder.save(path, again)
    assert not autosave(path).exists()
    assert tomllib.loads(path.read_text())["start"]["x"] == 2.0


@pytest.mark.parametrize("name", builtin_scenarios())
def test_a_built_in_scenario_is_copied_with_its_meshes_and_means_the_same(
    tmp_path: Path, name: str
) -> None:
    path = ChosenFolder(tmp_path).copy_builtin(name)
    assert path.read_bytes() == builtin_scenarios()[name].read_bytes()
    meaning = meaning_of(path.read_text(encoding="utf-8"), path)
    assert meaning.ready, meaning.mistakes


@pytest.fixture(scope="module")
def server() -> Iterator[Any]:
    made, _ = guarded_server("a test")
    yield made
    made.stop()


@pytest.mark.parametrize("name", builtin_scenarios())
def test_every_gallery_scenario_is_shown_in_few_nodes_and_again_without_sending_any(
    server: Any, name: str
) -> None:
    problem = kinolab.load(name)
    scene = SceneNodes(server, lambda _: None)
    scene.show(problem)
    nodes = dict(scene.nodes)
    assert any(node.startswith("/machine/") for node in nodes)
    assert len(nodes) < MOST_CALLS - OTHER_CALLS
    scene.show(problem)
    assert {key: id(node) for key, node in scene.nodes.items()} == {
        key: id(node) for key, node in nodes.items()
    }
    for key in list(scene.nodes):
        scene.remove(key)


class Listener(queue.Queue[Any]):
    """The messages of a search."""

    def last(self) -> tuple[Ended, list[Any]]:
        """Return how it ended, and what it told before."""
        told = []
        while not isinstance(message := self.get(timeout=PATIENCE), Ended):
            told.append(message)
        return message, told


def test_a_search_tells_its_verified_plan(table: PlanningTask) -> None:
    heard = Listener()
    BackgroundWork(search, (table,), heard.put)
    ended, told = heard.last()
    assert ended.result is not None
    assert ended.result.plan.status == "solved"
    assert ended.result.plan.certificate is not None
    assert ended.result.plan.certificate.passed
    assert any(isinstance(message, Improved) for message in told)


def test_a_crash_of_a_search_is_told_and_ends_nothing_else(table: PlanningTask) -> None:
    heard = Listener()
    running = BackgroundWork(search, (table,), heard.put)
    os.kill(running.process.pid, signal.SIGSEGV)
    ended, _ = heard.last()
    assert ended.result is None
    assert "crashed (SIGSEGV)" in ended.failure


def test_nothing_but_the_studio_imports_what_it_is_made_with() -> None:
    code = (
        "import sys, kinolab, kinolab.api, kinolab.cli.front, kinolab.show.view\n"
        "kinolab.load('pendulum_swingup')\n"
        "print(*sorted({'viser', 'tomlkit', 'websockets'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []

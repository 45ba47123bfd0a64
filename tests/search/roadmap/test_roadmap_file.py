"""Roadmaps on disk: bit for bit, and refused where they do not fit or are no roadmaps."""

from __future__ import annotations

import pickle
import shutil
import zipfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.search.roadmap import Roadmap, load_roadmap, save_roadmap
from tests.conftest import POST
from tests.scenes import scene

MESH = '\n[[world.obstacle]]\nmesh = "meshes/post.off"\nposition = [3.0, 3.0, 0.0]\n'
CONE = """
[[keep_out]]
body = "robot"
axis = [1, 0, 0]
direction = [0, 1, 0]
half_angle = 0.1
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made: Path = tmp_path_factory.mktemp("roadmap")
    (made / "meshes").mkdir()
    (made / "meshes" / "post.off").write_text(POST)
    return made


@pytest.fixture(scope="module")
def problem(folder: Path) -> PlanningTask:
    return scene(folder, "drive", text=MESH)


def example() -> Roadmap:
    generator, roadmap = np.random.default_rng(3), Roadmap()
    for _ in range(5):
        roadmap.add(generator.normal(size=7))
    for pair, length in (((0, 1), 4), ((1, 0), 1), ((4, 2), 9)):
        roadmap.connect(*pair, generator.uniform(-0.6, 0.6, (length, 2)))
    return roadmap


@pytest.fixture
def saved(folder: Path, problem: PlanningTask) -> Path:
    path = folder / "kept.npz"
    save_roadmap(path, example(), problem)
    return path


def refused(path: Path, problem: PlanningTask) -> str:
    with pytest.raises(InputError) as caught:
        load_roadmap(path, problem)
    assert len(caught.value.mistakes) == 1
    assert str(caught.value).startswith(f"{path}: ")
    return str(caught.value).removeprefix(f"{path}: ")


@pytest.mark.parametrize("made", [example(), Roadmap(), Roadmap([np.zeros(7)])])
def test_what_is_read_is_bit_for_bit_what_was_written(
    made: Roadmap, problem: PlanningTask, tmp_path: Path
) -> None:
    path = tmp_path / "roadmap.npz"
    save_roadmap(path, made, problem)
    read = load_roadmap(path, problem)
    assert list(read.motions) == list(made.motions)
    assert len(read.milestones) == len(made.milestones)
    for one, other in zip(read.milestones, made.milestones, strict=True):
        assert one.tobytes() == other.tobytes()
    for pair, inputs in made.motions.items():
        assert read.motions[pair].tobytes() == inputs.tobytes()
        assert read.motions[pair].shape == inputs.shape


def test_writing_leaves_one_file_and_replaces_what_was_there(
    problem: PlanningTask, tmp_path: Path
) -> None:
    path = tmp_path / "roadmap.npz"
    path.write_bytes(b"something else")
    save_roadmap(path, example(), problem)
    assert [entry.name for entry in tmp_path.iterdir()] == ["roadmap.npz"]


def test_a_folder_that_does_not_exist_is_told(problem: PlanningTask, tmp_path: Path) -> None:
    path = tmp_path / "nowhere" / "roadmap.npz"
    with pytest.raises(InputError, match=r"roadmap cannot be written .*Name another file\."):
        save_roadmap(path, example(), problem)


@pytest.mark.parametrize(
    "override",
    [
        "start.x=-1.0",
        "start.phi_l_dot=0.5",
        "goal.y=1.0",
        "goal.tolerance=0.3",
        "metric.psi=3.0",
        'planner.name="rrt"',
        "title='Another'",
    ],
)
def test_another_question_about_the_same_machine_and_world_is_welcome(
    override: str, folder: Path, saved: Path
) -> None:
    assert len(load_roadmap(saved, scene(folder, "drive", override, text=MESH)).milestones) == 5


@pytest.mark.parametrize(
    ("override", "changed"),
    [
        ("system.parameters={ m = 9.5 }", "machine"),
        ("system.parameters={ c_w = 0.081 }", "machine"),
        ("world.bounds={ x = [-5, 5.01], y = [-5, 5] }", "world"),
        ('world.ground="none"', "world"),
        ("bounds.phi_l_dot=[-7.9, 8]", "limits"),
        ("bounds.psi_dot=[-1, 1]", "limits"),
        ("integration.step=0.11", "integration"),
        ('integration.method="euler"', "integration"),
        ('integration.truth="discrete"', "integration"),
        ("goal.phi_l=1.0", "relevance of coordinates"),
    ],
)
def test_what_motions_rest_on_is_named_where_it_changed(
    override: str, changed: str, folder: Path, saved: Path
) -> None:
    told = refused(saved, scene(folder, "drive", override, text=MESH))
    assert told.startswith(f"the {changed} ")
    assert " changed since this roadmap was made. Its motions may not hold any more: " in told
    assert told.endswith("name another file, or remove this one.")


@pytest.mark.parametrize(
    "text",
    [
        "",
        MESH.replace("3.0, 3.0", "3.0, 3.001"),
        MESH + "scale = 1.01\n",
        MESH + "solid = false\n",
        MESH + "[[world.obstacle]]\nsphere = 0.1\nposition = [-4, -4, 1]\n",
        MESH + CONE,
    ],
    ids=["gone", "moved", "scaled", "hollow", "one more", "cone"],
)
def test_another_world_is_refused(text: str, folder: Path, saved: Path) -> None:
    told = refused(saved, scene(folder, "drive", text=text))
    assert "has changed since this roadmap was made" in told
    assert told.startswith(("the world has", "the limits has"))


def test_a_mesh_with_a_vertex_moved_is_refused(saved: Path, tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "post.off").write_text(POST.replace("1 1 1\n", "1 1 1.000001\n"))
    assert refused(saved, scene(tmp_path, "drive", text=MESH)).startswith("the world has changed")


def test_a_name_of_an_obstacle_does_not_matter_but_its_place_on_disk_neither(
    saved: Path, tmp_path: Path
) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "post.off").write_text(POST)
    moved = scene(tmp_path, "drive", text=MESH + 'name = "the post"\n')
    assert len(load_roadmap(saved, moved).milestones) == 5


def test_everything_that_changed_is_named_at_once(folder: Path, saved: Path) -> None:
    both = scene(folder, "drive", "system.parameters={ m = 8 }", "integration.step=0.2", text=MESH)
    assert refused(saved, both).startswith("the machine and the integration have changed since")


def test_a_roadmap_of_another_machine_is_refused(saved: Path, tmp_path: Path) -> None:
    assert "the machine and the world" in refused(saved, scene(tmp_path, "car"))


def contents(path: Path) -> dict[str, Any]:
    with np.load(path) as file:
        return dict(file)


def altered(path: Path, **tables: Any) -> Path:
    """A copy of a roadmap in which some tables are others."""
    copy = path.with_name("altered.npz")
    with copy.open("wb") as file:
        np.savez(file, **(contents(path) | tables))
    return copy


@pytest.mark.parametrize(
    "tables",
    [
        {"milestones": np.zeros((5, 6))},
        {"milestones": np.zeros(35)},
        {"milestones": np.full((5, 7), np.nan)},
        {"milestones": np.full((5, 7), "x")},
        {"inputs": np.zeros((14, 3))},
        {"inputs": np.zeros((13, 2))},
        {"inputs": np.full((14, 2), np.inf)},
        {"steps": np.array([4, 1])},
        {"steps": np.array([-1, 6, 9])},
        {"steps": np.array([0, 5, 9])},
        {"steps": np.array([4.0, 1.0, 9.0])},
        {"steps": np.array(14)},
        {"pairs": np.array([[0, 1], [1, 0], [4, 5]])},
        {"pairs": np.array([[0, 1], [1, 0], [-1, 2]])},
        {"pairs": np.array([[0, 1, 2], [1, 0, 2], [4, 2, 2]])},
        {"pairs": np.array([0, 1, 4])},
        {"version": np.array(2)},
        {"version": np.array([1, 1])},
        {"version": np.array("one")},
    ],
    ids=str,
)
def test_tables_that_do_not_fit_are_refused(
    tables: dict[str, Any], saved: Path, problem: PlanningTask
) -> None:
    told = refused(altered(saved, **tables), problem)
    assert told.startswith("it is no roadmap (ValueError: its ")
    assert told.endswith("Name a file that does not exist yet.")


@pytest.mark.parametrize("missing", ["milestones", "pairs", "steps", "inputs", "of_world"])
def test_a_missing_table_is_refused(missing: str, saved: Path, problem: PlanningTask) -> None:
    tables = contents(saved)
    del tables[missing]
    copy = saved.with_name("missing.npz")
    with copy.open("wb") as file:
        np.savez(file, **tables)
    assert missing in refused(copy, problem)


class Bomb:
    """What writes a file when it is unpickled."""

    def __init__(self, at: Path) -> None:
        self.at = at

    def __reduce__(self) -> tuple[Any, ...]:
        return (Path.touch, (self.at,))


def test_a_pickle_is_refused_and_never_run(
    saved: Path, problem: PlanningTask, tmp_path: Path
) -> None:
    mark = tmp_path / "executed"
    plain, inside = tmp_path / "plain.npz", tmp_path / "inside.npz"
    plain.write_bytes(pickle.dumps(Bomb(mark)))
    with inside.open("wb") as file:
        np.savez(file, **(contents(saved) | {"milestones": np.array([Bomb(mark)], dtype=object)}))
    for path in (plain, inside):
        refused(path, problem)
    assert not mark.exists()
    pickle.loads(plain.read_bytes())
    assert mark.exists()  # it would have


def alien(kind: str, saved: Path, path: Path) -> None:
    match kind:
        case "empty":
            path.write_bytes(b"")
        case "text":
            path.write_text("a roadmap\n")
        case "a single array":
            with path.open("wb") as file:
                np.save(file, np.zeros(3))
        case "a folder":
            path.mkdir()
        case "an empty archive":
            zipfile.ZipFile(path, "w").close()
        case "an archive of text":
            with zipfile.ZipFile(path, "w") as archive:
                archive.writestr("version.npy", "not an array")
        case "a huge array":
            header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (10**6, 10**9), }"
            header = header.replace(b"10**6", b"1000000").replace(b"10**9", b"1000000000")
            npy = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
            shutil.copy(saved, path)
            with zipfile.ZipFile(path, "a") as archive:
                archive.writestr("more.npy", npy)


@pytest.mark.parametrize(
    "kind",
    [
        "empty",
        "text",
        "a single array",
        "a folder",
        "an empty archive",
        "an archive of text",
        "a huge array",
        "nothing",
    ],
)
def test_an_alien_file_is_refused(
    kind: str, saved: Path, problem: PlanningTask, tmp_path: Path
) -> None:
    path = tmp_path / "alien.npz"
    alien(kind, saved, path)
    assert refused(path, problem).startswith("it is no roadmap (")


def test_a_damaged_file_is_refused_wherever_it_is_cut_or_changed(
    saved: Path, problem: PlanningTask, tmp_path: Path
) -> None:
    """Cut short: never read. A byte changed: refused, or where it does not count, as it was."""
    whole, path = saved.read_bytes(), tmp_path / "damaged.npz"
    for length in range(0, len(whole), 97):
        path.write_bytes(whole[:length])
        refused(path, problem)
    kept = load_roadmap(saved, problem)
    generator = np.random.default_rng(5)
    for at in generator.integers(0, len(whole), 150):
        bent = bytearray(whole)
        bent[at] ^= 0x55
        path.write_bytes(bytes(bent))
        with suppress(InputError):
            read = load_roadmap(path, problem)
            assert [m.tolist() for m in read.milestones] == [m.tolist() for m in kept.milestones]
            assert list(read.motions) == list(kept.motions)

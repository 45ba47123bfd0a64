"""The kinodynamic roadmap as a planner: on machines of all kinds, from files, and within limits."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.search.roadmap import load_roadmap
from kinolab.solve import PlanResult
from tests.scenes import ROOM, WALL, scene


@pytest.fixture(scope="module")
def yard(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., PlanningTask]:
    folder = tmp_path_factory.mktemp("yard")
    return lambda *overrides: scene(folder, "drive", *overrides, text=WALL)


def bits(found: PlanResult) -> bytes:
    assert found.trajectory is not None
    return found.trajectory.x.tobytes() + found.trajectory.u.tobytes()


def test_a_roadmap_in_a_file_answers_other_questions_without_growing(
    yard: Callable[..., PlanningTask], tmp_path: Path
) -> None:
    path = tmp_path / "yard.npz"
    settings: dict[str, Any] = {"planner": "prm", "roadmap": str(path), "milestones": 12}
    settings |= {"neighbours": 4, "time_limit": 120.0}
    first = yard().solve(seed=1, **settings)
    assert first.status == "solved"
    written = path.read_bytes()
    assert first.statistics["milestones"] >= 12
    other = yard("start.x=-3", "start.y=2", "start.psi=2", "goal.x=3", "goal.y=-4", "goal.psi=1")
    second = other.solve(seed=2, **settings)
    assert second.status == "solved"
    assert second.statistics["milestones"] == first.statistics["milestones"]
    assert second.iterations < first.iterations
    assert path.read_bytes() == written
    assert [entry.name for entry in tmp_path.iterdir()] == ["yard.npz"]
    with pytest.raises(InputError, match="the integration has changed"):
        yard("integration.step=0.05").solve(seed=1, **settings)


def test_a_roadmap_that_is_too_small_grows_and_is_written_again(tmp_path: Path) -> None:
    """Even where it does not answer: the goal is in a room without a door."""
    problem, path, sizes = scene(tmp_path, "drive", text=ROOM), tmp_path / "small.npz", []
    for count in (2, 2, 4):
        settings = {"roadmap": str(path), "milestones": count, "neighbours": 2}
        found = problem.solve(planner="prm", seed=1, max_iterations=12, **settings)
        assert found.status in {"approximate", "not_found"}
        sizes.append(len(load_roadmap(path, problem).milestones))
    assert 2 <= sizes[0] <= sizes[1]
    assert sizes[2] >= 4


def test_a_file_in_no_folder_is_refused_before_the_search(
    yard: Callable[..., PlanningTask], tmp_path: Path
) -> None:
    path = tmp_path / "nowhere" / "roadmap.npz"
    with pytest.raises(InputError) as caught:
        yard().solve(planner="prm", roadmap=str(path))
    assert str(caught.value) == (
        f"[planner] roadmap: there is no folder {str(path.parent)!r}. "
        "Make it, or name another file."
    )


def test_the_wall_is_passed_and_equal_seeds_give_equal_bits(
    yard: Callable[..., PlanningTask],
) -> None:
    found, same = (
        yard().solve(planner="prm", seed=3, neighbours=2, max_iterations=400, time_limit=120.0)
        for _ in range(2)
    )
    assert found.status == "solved"
    assert bits(found) == bits(same)
    assert found.iterations == same.iterations
    assert found.trajectory is not None
    crossing = np.abs(found.trajectory.x[:, 0]).argmin()
    assert abs(found.trajectory.x[crossing, 1]) > 1.5  # [m]: beside the wall


@pytest.mark.parametrize(
    ("machine", "overrides"),
    [
        ("drive", ("start.phi_l_dot=1.0", "start.phi_r_dot=1.5")),
        ("drive", ("start.psi=4.0", "start.phi_l=7.0", "goal.psi=-9.0")),
        ("drive", ('integration.method="euler"', "goal.tolerance=1e-3")),
        ("drive", ("bounds.psi_dot=[-0.5, 0.5]", "goal.psi=1.0")),
        ("car", ("start.delta=0.3", "goal.delta=-0.2")),
        ("crane", ("start.x_dot=0.3",)),
        ("two_cranes", ()),
        ("pendulum", ()),
    ],
)
def test_starts_that_move_and_machines_without_flat_maps_are_solved(
    machine: str, overrides: tuple[str, ...], tmp_path: Path
) -> None:
    found = scene(tmp_path, machine, *overrides).solve(planner="prm", seed=1)
    assert found.status == "solved"


def test_a_goal_in_motion_is_reached_in_motion(tmp_path: Path) -> None:
    problem = scene(
        tmp_path, "drive", "goal.at_rest=false", "goal.phi_l_dot=3.0", "goal.phi_r_dot=3.0"
    )
    found = problem.solve(planner="prm", seed=1)
    assert found.status == "solved"
    assert found.trajectory is not None
    assert found.trajectory.x[-1, 5:] == pytest.approx([3, 3], abs=0.1)


@pytest.mark.parametrize("planner", ["prm", "prm_geometric"])
@pytest.mark.parametrize("machine", ["drive", "crane", "pendulum"])
def test_who_starts_in_the_goal_stays_there(machine: str, planner: str, tmp_path: Path) -> None:
    """Exactly, though the goal is a thousandth of a millimetre wide."""
    places = {
        "drive": ("start.x=2.0", "start.phi_l=9.0"),
        "crane": ("start.x=12.0", "start.y=8.0", "start.l=6.0"),
        "pendulum": ("start.theta=3.141592653589793",),
    }
    problem = scene(tmp_path, machine, *places[machine], "goal.tolerance=1e-6")
    found = problem.solve(planner=planner, seed=1)
    assert found.status == "solved"
    assert found.cost == 0.0


@pytest.mark.parametrize("planner", ["prm", "prm_geometric"])
def test_a_goal_in_a_room_without_a_door_is_not_found_in_time(planner: str, tmp_path: Path) -> None:
    found = scene(tmp_path, "drive", text=ROOM).solve(planner=planner, seed=1, time_limit=0.3)
    assert found.status in {"approximate", "not_found"}
    assert found.timings["search"] < 4.0  # [s]


@pytest.mark.parametrize("planner", ["prm", "prm_geometric"])
@pytest.mark.parametrize("text", ["", ROOM])
def test_a_search_ends_at_its_iterations(planner: str, text: str, tmp_path: Path) -> None:
    """Where wheels may hardly turn there are paths, and none can be followed."""
    still = ("bounds.phi_l_dot=[-1e-9, 1e-9]", "bounds.phi_r_dot=[-1e-9, 1e-9]")
    problem = scene(tmp_path, "drive", *still, text=text)
    found = problem.solve(planner=planner, seed=1, time_limit=60.0, max_iterations=10)
    assert (found.status, found.iterations) == ("not_found", 10)


@pytest.mark.parametrize("planner", ["prm", "prm_geometric"])
def test_a_search_that_is_interrupted_says_so_and_keeps_its_roadmap(
    planner: str, tmp_path: Path
) -> None:
    budgets: list[Budget] = []

    def stop(iterations: int, seconds: float) -> None:
        assert iterations > 0
        assert seconds > 0
        budgets[0].interrupted = True

    path = tmp_path / "roadmap.npz"
    found = scene(tmp_path, "drive", text=ROOM).solve(
        planner=planner,
        seed=1,
        time_limit=60.0,
        progress=stop,
        watch=budgets.append,
        **({"roadmap": str(path)} if planner == "prm" else {}),
    )
    assert (found.status, found.exit_code) == ("interrupted", 130)
    assert found.timings["search"] < 10.0  # [s]
    assert path.exists() == (planner == "prm")

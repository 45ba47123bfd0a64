"""Ways through the free configurations: free, from start to end, and only where there is one."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab.concurrency.cancel import CancelledError, never_cancelled
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.multistart.geometric_path import GeometricPaths
from kinolab.trajopt.multistart.guesses import Guesses
from kinolab.trajopt.multistart.lazy_roadmap import least_duration, straight_roadmap
from tests.support import problem_of

Array = NDArray[np.float64]

SEEDS = range(1, 6)
RADIUS = 0.28  # [m] from the robot's centre to its corners in the plane
CLOSE = 0.0074  # [m] of a corner between two of our looks: a tenth of what ways are looked at
GRAZED = 0.093  # [m] of a corner between two looks at a way of five parts, which count as four
HALL = """
schema = 1
title = "A robot in a hall with a wall across it, which has doors"
system = { name = "unicycle1_v0" }
bounds = { x = [0, 4], y = [0, 6] }
[start]
x = 1.0
y = 1.0
theta = 3.0
[goal]
x = 3.0
y = 1.0
theta = -3.0
tolerance = 0.1
"""
DOORS = {"near": (1.0, 1.7), "far": (4.5, 5.5)}  # [m] in y
THROUGH = 4.0  # [m]: some more than through the near door, less than through the far one
FLY = """
schema = 1
title = "A rotor turns over beside a post"
system = { name = "quad3d_v0" }
bounds = { x = [-1, 1], y = [-1, 1], z = [0, 2] }
[start]
x = -0.7
z = 1.0
R = [0, 0, 0, 1]
[goal]
x = 0.7
y = 0.0
z = 1.0
R = [0, 0, 0.9, -0.4358898943540674]
tolerance = 0.1
[[world.obstacle]]
box = [0.3, 0.3, 2.0]
position = [0, 0, 1]
"""


def hall(folder: Path, *doors: str) -> PlanningTask:
    """Return the hall whose wall is open at some doors only."""
    edges = [0.0, *(y for door in doors for y in DOORS[door]), 6.0]
    walls = "".join(
        f"\n[[world.obstacle]]\nbox = [0.2, {high - low}, 1.0]\n"
        f"position = [2, {(low + high) / 2}, 0]\n"
        for low, high in zip(edges[::2], edges[1::2], strict=True)
    )
    return problem_of(folder, HALL + walls)


def goal_of(problem: PlanningTask) -> Array:
    end = problem.start.copy()
    end[list(problem.goal.indices)] = problem.goal.targets
    for one in problem.goal.parts:
        end[one.part.own] = one.target
    return end


def anything(ways: Array) -> NDArray[np.bool_]:
    return np.ones(ways.shape[:-2], dtype=bool)


def through(ways: Array) -> NDArray[np.bool_]:
    return np.asarray(length(ways) <= THROUGH)


def found(
    problem: PlanningTask, seed: int, within: Callable[[Array], NDArray[np.bool_]] = anything
) -> Array | None:
    ways = GeometricPaths(problem, np.random.default_rng(seed))
    return ways.find(problem.start, goal_of(problem), within=within)


def length(ways: Array) -> Array:
    """Return the lengths of ways (..., m, nx) in the plane, in [m]."""
    return np.asarray(np.linalg.norm(np.diff(ways[..., :2], axis=-2), axis=-1).sum(axis=-1))


def door(way: Array) -> str:
    """Return the door through which the robot's centre first crosses the wall."""
    a, b = next((a, b) for a, b in pairwise(way) if a[0] <= 2.0 <= b[0])
    y = np.interp(2.0, [a[0], b[0]], [a[1], b[1]])
    (name,) = (name for name, (low, high) in DOORS.items() if low < y < high)
    return name


def looks(way: Array) -> Array:
    """Return states of the robot all along a way."""
    legs = []
    for a, b in pairwise(way):
        moved = np.hypot(*(b - a)[:2]) + RADIUS * abs(b[2] - a[2])
        legs.append(np.linspace(a, b, int(np.ceil(moved / CLOSE)) + 2))
    return np.vstack(legs)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_way_is_free_but_for_corners_that_it_grazes_between_two_looks(
    seed: int, tmp_path: Path
) -> None:
    """Ten times as many looks see contact for less than one of its own; a wall takes 0.45 m."""
    problem = hall(tmp_path, "near", "far")
    way, checker = found(problem, seed), problem.checker()
    assert way is not None
    touching = [checker.collides(*problem.placement(x)) for x in looks(way)]
    longest = max((len(list(run)) for touches, run in groupby(touching) if touches), default=0)
    assert longest * CLOSE < GRAZED


@pytest.mark.parametrize("seed", SEEDS)
def test_a_way_leads_from_start_to_goal_but_for_whole_turns(seed: int, tmp_path: Path) -> None:
    problem = hall(tmp_path, "far")
    way, end = found(problem, seed), goal_of(problem)
    assert way is not None
    assert np.array_equal(way[0], problem.start)
    assert np.array_equal(way[-1, :2], end[:2])
    turns = (way[-1, 2] - end[2]) / (2 * np.pi)
    assert turns == pytest.approx(round(turns), abs=1e-12)
    assert np.abs(np.diff(way[:, 2])).max() <= np.pi + 1e-12  # none is jumped over


def test_attitudes_end_as_they_must_but_for_their_sign(
    tmp_path: Path,
) -> None:
    problem, signs = problem_of(tmp_path, FLY), set()
    end, (first,) = goal_of(problem), problem.model.attitudes.values()
    for seed in SEEDS:
        way = found(problem, seed)
        assert way is not None
        q = way[:, first : first + 4]
        assert (np.sum(q[1:] * q[:-1], axis=1) >= 0).all()
        same = float(q[-1] @ end[first : first + 4])
        assert abs(same) == pytest.approx(1.0, abs=1e-12)
        signs.add(round(same))
    assert signs == {-1, 1}


def test_there_is_no_way_through_a_closed_wall(tmp_path: Path) -> None:
    assert found(hall(tmp_path), 1) is None


def test_equal_seeds_give_equal_ways_and_others_other_ones(tmp_path: Path) -> None:
    problem, ways = hall(tmp_path, "near", "far"), set()
    for seed in SEEDS:
        one, other = found(problem, seed), found(problem, seed)
        assert one is not None
        assert other is not None
        assert one.tobytes() == other.tobytes()
        ways.add(one.tobytes())
    assert len(ways) == len(SEEDS)


def test_a_way_of_limited_length_leads_through_the_near_door(tmp_path: Path) -> None:
    """Without the limit some lead through the far one."""
    problem = hall(tmp_path, "near", "far")
    free = [found(problem, seed) for seed in SEEDS]
    assert {door(way) for way in free if way is not None} == set(DOORS)
    for seed in SEEDS:
        way = found(problem, seed, through)
        assert way is not None
        assert door(way) == "near"
        assert length(way) <= THROUGH


def test_without_the_near_door_no_way_is_that_short(tmp_path: Path) -> None:
    assert found(hall(tmp_path, "far"), 1, through) is None


@pytest.mark.parametrize("looks_before", [0, 5])
def test_looking_for_a_way_ends_when_it_is_stopped(looks_before: int, tmp_path: Path) -> None:
    problem, asked = hall(tmp_path), [0]

    def stop() -> bool:
        asked[0] += 1
        return asked[0] > looks_before

    with pytest.raises(CancelledError):
        GeometricPaths(problem, np.random.default_rng(1), stop).find(
            problem.start, goal_of(problem)
        )
    assert asked[0] == looks_before + 1


TURN = """
schema = 1
title = "A telescope turns past the sun"
system = { name = "satellite" }
[goal]
[[goal.direction]]
body = "telescope"
axis = "x"
target = [-1.0, 0.3, 0.0]
[[keep_out]]
body = "telescope"
axis = "x"
direction = [0.1, 1.0, 0.0]
half_angle = 0.6
"""


@pytest.mark.parametrize("seed", SEEDS)
def test_a_way_keeps_axes_out_of_forbidden_cones(seed: int, tmp_path: Path) -> None:
    """The straight way leads through the cone; looks are so close that one grazes it by 0.1 rad."""
    problem, generator = problem_of(tmp_path, TURN), np.random.default_rng(seed)
    begin, end = Guesses(problem, generator).straight()
    ways = GeometricPaths(problem, generator)
    assert not ways.is_free(begin, end)
    way = ways.find(begin, end)
    assert way is not None
    (cone,) = problem.keep_outs
    angles = [cone.angle(problem.frames(x)) for x in between(way)]
    assert min(angles) > cone.half_angle - 0.1


def between(way: Array) -> Array:
    """Return many states on a way, quaternions on chords."""
    parts = np.linspace(0.0, 1.0, 30)[:, None]
    return np.vstack([a + parts * (b - a) for a, b in pairwise(way)])


# --- roadmaps ---


def shortest(problem: PlanningTask, seed: int) -> Array | None:
    generator = np.random.default_rng(seed)
    paths, guesses = GeometricPaths(problem, generator), Guesses(problem, generator)
    ends = np.stack([problem.start, goal_of(problem)])
    roadmap = straight_roadmap(problem, paths, guesses.leg_times, ends, never_cancelled)
    way = roadmap.path()
    return None if way is None else paths.shorter(problem.space.continuous(way))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("doors", "least"), [(("near",), 2.0), (("far",), 7.52), (("near", "far"), 2.0)]
)
def test_a_roadmap_has_about_the_shortest_way(
    doors: tuple[str, ...], least: float, seed: int, tmp_path: Path
) -> None:
    """The centre comes no nearer to a door's edge than half the robot's width, 0.125 m.

    So the way through the far door takes 2 hypot(1, 3.625) = 7.52 m at least, the near way 2 m.
    """
    way = shortest(hall(tmp_path, *doors), seed)
    assert way is not None
    assert door(way) == doors[0]
    assert least - 1e-9 <= length(way) <= 1.25 * least


def test_the_same_random_numbers_give_the_same_way(tmp_path: Path) -> None:
    problem = hall(tmp_path, "near", "far")
    one, other = (shortest(problem, 3) for _ in range(2))
    assert one is not None
    assert other is not None
    assert np.array_equal(one, other)


def test_a_roadmap_finds_no_way_where_there_is_none(tmp_path: Path) -> None:
    assert shortest(hall(tmp_path), 1) is None


@pytest.mark.parametrize(("name", "least"), [("near", 2.0), ("far", 7.52)])
def test_a_detour_counts_as_long_as_it_is_when_pulled_tight(
    name: str, least: float, tmp_path: Path
) -> None:
    """At 0.5 m/s in each direction of the plane: a diagonal takes as long as its longer side."""
    problem, far = hall(tmp_path, name), name == "far"
    y = 5.0 if far else 1.4
    corners = [(1.0, 1.0), (0.6, 3.0), (1.2, y), (2.0, y), (2.8, y), (3.4, 4.0), (3.0, 1.0)]
    x = np.zeros((len(corners), problem.model.nx))
    x[:, :2] = corners
    x = np.array([a + s * (b - a) for a, b in pairwise(x) for s in np.linspace(0.0, 1.0, 12)])
    t, u = np.linspace(0.0, 1.0, len(x)), np.zeros((len(x) - 1, problem.model.nu))
    names = problem.model.state_names, problem.model.control_names
    taken = least_duration(problem, Trajectory(t, x, u, *names))
    longer_sides = 2 * 3.625 if far else 2.0  # [m]
    assert longer_sides / 0.5 <= taken <= 1.25 * least / 0.475  # rates are drawn at random

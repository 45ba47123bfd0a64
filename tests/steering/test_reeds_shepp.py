"""Arcs of the shortest curves: as long as an independent derivation says, and they arrive."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kinolab.steering.reeds_shepp import Arc, PlanePose, arcs
from tests.oracles import vehicles as oracle

Length = Callable[[PlanePose, PlanePose, float], float]

ORIGIN = (0.0, 0.0, 0.0)
both_kinds = pytest.mark.parametrize(
    ("backward", "length"), [(True, oracle.reeds_shepp_length), (False, oracle.dubins_length)]
)


def miss(found: list[Arc], begin: PlanePose, end: PlanePose) -> float:
    """How far from a pose the arcs end, in [m] and [rad]."""
    x, y, heading = begin
    for arc in found:
        x, y, heading = arc.after((x, y, heading))
    turned = (heading - end[2] + np.pi) % (2 * np.pi) - np.pi
    return max(abs(x - end[0]), abs(y - end[1]), abs(turned))


def poses(count: int, spread: float, seed: int) -> list[PlanePose]:
    generator = np.random.default_rng(seed)
    high = np.array([spread, spread, 4.0])
    return [tuple(map(float, p)) for p in generator.uniform(-high, high, (count, 3))]  # type: ignore[misc]


@both_kinds
@pytest.mark.parametrize("spread", [0.5, 2.0, 8.0])
def test_arcs_are_as_short_as_the_oracles_and_arrive(
    backward: bool, length: Length, spread: float
) -> None:
    """Close poses ask for three to five arcs, far ones for a straight line between two."""
    starts, ends = poses(60, spread, 1), poses(60, spread, 2)
    for k, (begin, end) in enumerate(zip(starts, ends, strict=True)):
        radius = 0.5 + k / 20
        found = arcs(begin, end, radius, backward=backward)
        assert sum(abs(a.length) for a in found) == pytest.approx(
            length(begin, end, radius), abs=1e-9
        )
        assert miss(found, begin, end) < 1e-7  # where an edge is found to 1e-8 m
        assert {abs(a.curvature) for a in found} <= {0.0, 1 / radius}
        assert backward or all(a.length > 0 for a in found)
        assert len(found) <= 5


def test_all_shapes_of_words_occur_and_arrive() -> None:
    """CSC, CCC, CCCC, CCSC and CCSCC, with and without cusps: Reeds and Shepp's nine families."""
    shapes = set()
    for begin, end in zip(poses(1500, 4.0, 3), poses(1500, 4.0, 4), strict=True):
        word = oracle.reeds_shepp_word(begin, end, 1.0)
        shape = "".join("CS"[piece.turn == 0] for piece in word if piece.length > 0.02)
        if shape in shapes:
            continue
        shapes.add(shape)
        found = arcs(begin, end, 1.0)
        assert "".join("CS"[a.curvature == 0] for a in found if abs(a.length) > 0.02) == shape
        assert miss(found, begin, end) < 1e-7
    assert shapes >= {"CSC", "CCC", "CCCC", "CCSC", "CSCC", "CCSCC"}


@pytest.mark.parametrize("sliver", [3e-2, 1e-3, 1e-5])
def test_an_arc_that_is_short_is_not_overlooked(sliver: float) -> None:
    """A kilometre straight ahead, and the last bit of an arc."""
    last = Arc(sliver, 1.0)
    end = last.after((1000.0, 0.0, 0.0))
    found = arcs(ORIGIN, end, 1.0)
    assert miss(found, ORIGIN, end) < 1e-7
    assert len(found) <= 3


@pytest.mark.parametrize("backward", [True, False])
@pytest.mark.parametrize("curvature", [0.0, 0.8, -0.8])
def test_one_arc_needs_no_whole_circle_beside_it(curvature: float, backward: bool) -> None:
    """Its neighbours have length 0 but for rounding, which must not pass for a turn right round."""
    for k, begin in enumerate(poses(200, 8.0, 5), start=1):
        one = Arc(k / 60, curvature)  # less than half a circle: beyond, one reverses
        found = arcs(begin, one.after(begin), 1 / 0.8, backward=backward)
        assert sum(abs(a.length) for a in found) == pytest.approx(one.length, abs=1e-6)


@both_kinds
@pytest.mark.parametrize("end", [ORIGIN, (0.0, 0.0, 2 * np.pi), (0.0, 0.0, -4 * np.pi)])
def test_the_same_pose_needs_no_arc(backward: bool, length: Length, end: PlanePose) -> None:
    assert length(ORIGIN, end, 1.5) == pytest.approx(0.0, abs=1e-9)
    assert arcs(ORIGIN, end, 1.5, backward=backward) == []


@pytest.mark.parametrize("distance", [5.0, -5.0, 1e-3, -1e-3])
def test_straight_ahead_and_straight_back_are_one_line(distance: float) -> None:
    (arc,) = arcs((1.0, 2.0, 0.7), (1 + distance * np.cos(0.7), 2 + distance * np.sin(0.7), 0.7), 2)
    assert (arc.length, arc.curvature) == (pytest.approx(distance, abs=1e-9), 0.0)


def test_a_turn_by_half_a_circle_at_a_place_is_three_of_sixty_degrees() -> None:
    """A three-point turn; forwards alone it takes 60, 300 and 60 degrees."""
    there = (0.0, 0.0, np.pi)
    assert [abs(a.length) for a in arcs(ORIGIN, there, 2.0)] == pytest.approx([2 * np.pi / 3] * 3)
    ahead = [a.length for a in arcs(ORIGIN, there, 2.0, backward=False)]
    assert ahead == pytest.approx([2 * np.pi / 3, 10 * np.pi / 3, 2 * np.pi / 3])


@pytest.mark.parametrize("step", [1e-4, 1e-3])
def test_a_step_aside_is_made_of_tiny_arcs(step: float) -> None:
    end = (0.0, step, 0.0)
    found = arcs(ORIGIN, end, 1.0)
    assert miss(found, ORIGIN, end) < 1e-7
    assert sum(abs(a.length) for a in found) == pytest.approx(
        oracle.reeds_shepp_length(ORIGIN, end, 1.0), abs=1e-7
    )


def test_far_from_the_origin_arcs_are_the_same() -> None:
    end, far = (3.0, -1.0, 2.0), (1e5, -1e5, 0.0)
    moved = arcs(far, (far[0] + end[0], far[1] + end[1], end[2]), 1.0)
    near = arcs(ORIGIN, end, 1.0)
    assert [a.curvature for a in moved] == [a.curvature for a in near]
    assert [a.length for a in moved] == pytest.approx([a.length for a in near], abs=1e-6)


@pytest.mark.parametrize("arc", [Arc(2.0, 0.0), Arc(-2.0, 0.0), Arc(1.5, 0.8), Arc(-1.5, -0.8)])
def test_poses_along_an_arc_keep_their_distance_and_heading(arc: Arc) -> None:
    """Differences along it: |ds| per step, along the heading, turning by the curvature."""
    begin, share = (0.3, -0.2, 0.9), np.linspace(0, 1, 2001)
    x, y, heading = arc.poses(begin, share)
    step = arc.length / 2000
    middle = (heading[1:] + heading[:-1]) / 2
    assert np.diff(x) == pytest.approx(step * np.cos(middle), abs=1e-9)
    assert np.diff(y) == pytest.approx(step * np.sin(middle), abs=1e-9)
    assert np.diff(heading) == pytest.approx(step * arc.curvature * np.ones(2000), abs=1e-12)
    assert (x[-1], y[-1], heading[-1]) == pytest.approx(arc.after(begin), abs=1e-12)

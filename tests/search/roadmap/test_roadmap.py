"""The graph of milestones against ways found by trying all of them."""

from __future__ import annotations

from itertools import pairwise, permutations

import numpy as np
import pytest

from kinolab.search.roadmap import Roadmap


def random_roadmap(seed: int, size: int = 6) -> Roadmap:
    generator, roadmap = np.random.default_rng(seed), Roadmap()
    for _ in range(size):
        roadmap.add(generator.normal(size=2))
    for a, b in permutations(range(size), 2):
        if generator.uniform() < 0.35:
            roadmap.connect(a, b, generator.normal(size=(int(generator.integers(1, 30)), 2)))
    return roadmap


def ways(roadmap: Roadmap, begin: int, end: int) -> list[list[int]]:
    """Every way without a milestone twice."""
    others = [k for k in range(len(roadmap.milestones)) if k not in (begin, end)]
    tried = [
        [begin, *middle, end] for n in range(len(others) + 1) for middle in permutations(others, n)
    ]
    return [way for way in tried if all(pair in roadmap.motions for pair in pairwise(way))]


def steps(roadmap: Roadmap, way: list[int]) -> int:
    return sum(len(roadmap.motions[pair]) for pair in pairwise(way))


@pytest.mark.parametrize("seed", range(12))
def test_the_quickest_way_has_the_fewest_steps_of_all(seed: int) -> None:
    roadmap = random_roadmap(seed)
    for begin, end in permutations(range(6), 2):
        found, possible = roadmap.quickest(begin, end), ways(roadmap, begin, end)
        if not possible:
            assert found is None
            continue
        assert found is not None
        least = min(steps(roadmap, way) for way in possible)
        assert len(found) == least
        whole = [
            np.vstack([roadmap.motions[p] for p in pairwise(w)])
            for w in possible
            if steps(roadmap, w) == least
        ]
        assert any((found == inputs).all() for inputs in whole)


@pytest.mark.parametrize("seed", range(12))
def test_groups_are_milestones_that_reach_each_other(seed: int) -> None:
    roadmap = random_roadmap(seed)
    groups = roadmap.groups()
    for a, b in permutations(range(6), 2):
        both = bool(ways(roadmap, a, b)) and bool(ways(roadmap, b, a))
        assert (groups[a] == groups[b]) == both


def test_the_quicker_of_two_motions_stays() -> None:
    roadmap = Roadmap()
    a, b = roadmap.add(np.zeros(1)), roadmap.add(np.ones(1))
    for length, kept in ((5, 5), (7, 5), (3, 3)):
        roadmap.connect(a, b, np.full((length, 1), float(length)))
        assert len(roadmap.motions[a, b]) == kept


def test_motions_are_one_way() -> None:
    roadmap = Roadmap()
    a, b = roadmap.add(np.zeros(1)), roadmap.add(np.ones(1))
    roadmap.connect(a, b, np.ones((2, 1)))
    assert roadmap.quickest(a, b) is not None
    assert roadmap.quickest(b, a) is None


def test_a_copy_grows_alone() -> None:
    roadmap = random_roadmap(1)
    size, motions = len(roadmap.milestones), len(roadmap.motions)
    copy = roadmap.copy()
    copy.connect(copy.add(np.zeros(2)), 0, np.zeros((1, 2)))
    assert (len(roadmap.milestones), len(roadmap.motions)) == (size, motions)


def test_a_roadmap_without_motions_leads_nowhere() -> None:
    roadmap = Roadmap([np.zeros(2), np.ones(2)])
    assert roadmap.quickest(0, 1) is None
    assert len(set(roadmap.groups())) == 2

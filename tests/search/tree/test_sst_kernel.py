"""The sparse tree, looked at from outside: witnesses, their representatives, what is forgotten."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab import planners
from kinolab.numerics.neighbours.insertion import add
from kinolab.numerics.neighbours.queries import cheapest_within
from kinolab.numerics.neighbours.r_tree import r_tree
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.search.tree import search_state
from kinolab.search.tree.problem_arrays import metric_periods
from kinolab.search.tree.sampled.witnesses import select

Array = np.ndarray

SELECTION, PRUNING = 1.0, 0.4
ROUNDING = 1e-5  # of points in single precision, relative


def growth_of(problem: PlanningTask, **settings: Any) -> Any:
    radii = {"selection_radius": SELECTION, "pruning_radius": PRUNING}
    planner = planners.make("sst", radii | settings)
    growth = planner.extension(problem, search_state(problem, 1.0, 1))  # type: ignore[attr-defined]
    growth.begin()
    return growth


def places(growth: Any, x: Array) -> Array:
    """Scaled coordinates of states."""
    question = growth._first.held.search.problem
    return x[:, question.entry] * question.weight


def apart(growth: Any, some: Array, others: Array) -> Array:
    """Distances of all pairs, the short way round."""
    period = metric_periods(growth._first.held.search.problem)
    gaps = np.abs(some[:, None] - others[None])
    with np.errstate(invalid="ignore"):
        turns = np.where(np.isfinite(period), np.round(gaps / period) * period, 0.0)
    return np.linalg.norm(gaps - turns, axis=-1)


def wrapped(growth: Any, point: Array) -> Array:
    """Scaled coordinates as samples have them: angles within a half turn."""
    period = metric_periods(growth._first.held.search.problem)
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(period), point - np.round(point / period) * period, point)


def witnesses_of(growth: Any) -> tuple[Array, Array, Array]:
    """Points, representatives and their costs."""
    held = growth._first.held.witnesses
    count = int(held.neighbours.counts[0])
    return held.neighbours.points[:count], held.node[:count], held.cost[:count]


@pytest.fixture(scope="module", params=["rolling_disk_maze", "vehicle_parking"])
def scene(request: pytest.FixtureRequest) -> PlanningTask:
    return kinolab.load(request.param)


@pytest.fixture(scope="module")
def grown(scene: PlanningTask) -> Any:
    growth = growth_of(scene)
    growth.grow(4000)
    return growth


def test_no_two_witnesses_are_nearer_than_the_pruning_radius(grown: Any) -> None:
    points, _, _ = witnesses_of(grown)
    assert len(points) > 50
    distances = apart(grown, points, points)[np.triu_indices(len(points), 1)]
    assert distances.min() >= PRUNING * (1 - ROUNDING)


def test_around_every_node_there_is_a_representative_that_is_no_dearer(
    grown: Any,
) -> None:
    """The one of its witness, at the latest when the node was added."""
    points, nodes, costs = witnesses_of(grown)
    size = int(grown.nodes.size[0])
    assert size > len(nodes)  # some were outdone
    near = apart(grown, places(grown, grown.nodes.x[:size]), points)
    cheap = costs[None] <= grown.nodes.cost[:size, None]
    assert (cheap & (near <= PRUNING * (1 + ROUNDING))).any(axis=1).all()


def test_a_representative_is_around_its_witness_and_costs_what_its_way_takes(
    grown: Any,
) -> None:
    points, nodes, costs = witnesses_of(grown)
    assert len(np.unique(nodes)) == len(nodes)
    near = apart(grown, places(grown, grown.nodes.x[nodes]), points).diagonal()
    assert near.max() <= PRUNING * (1 + ROUNDING)
    for node, cost in zip(nodes, costs, strict=True):
        steps, at = 0, node
        while at > 0:
            steps, at = steps + grown.nodes.steps[at], grown.nodes.parent[at]
        assert steps == cost


@pytest.mark.parametrize("bound", [0, 1])
def test_below_a_bound_that_no_motion_meets_nothing_is_extended(
    bound: int, scene: PlanningTask
) -> None:
    """Without witnesses there is no representative: what lies behind their array is none."""
    growth = growth_of(scene)
    growth._first.held.witnesses.node[:], growth.nodes.failures[:] = 5, 0
    growth.shorten(bound)
    growth.grow(500)
    assert len(witnesses_of(growth)[0]) == 0
    assert not growth.nodes.failures.any()
    assert growth.nodes.size[0] == 1
    assert growth.steps_made == 0


def test_the_cheapest_around_a_sample_is_grown_from_or_else_the_nearest(
    grown: Any,
) -> None:
    points, nodes, costs = witnesses_of(grown)
    random, near_any = np.random.default_rng(0), 0
    for k in range(300):
        spread = 0.2 if k % 2 else 2.0
        sample = points[random.integers(len(points))] + random.normal(size=points.shape[1]) * spread
        sample = wrapped(grown, sample.astype(float))
        chosen = int(
            np.flatnonzero(nodes == select(Record(grown._first.held.witnesses), sample, SELECTION))[
                0
            ]
        )
        distances = apart(grown, sample[None], points)[0]
        around = distances <= SELECTION
        if around.any():
            near_any += 1
            assert around[chosen]
            assert costs[chosen] == costs[around].min()
        else:
            assert distances[chosen] <= 1.1 * distances.min() * (1 + ROUNDING)
    assert 20 < near_any < 290


def test_the_cost_of_a_witness_never_grows(scene: PlanningTask) -> None:
    growth = growth_of(scene)
    growth.grow(200)
    lowered = 0
    for _ in range(20):
        before = witnesses_of(growth)[2].copy()
        growth.grow(200)
        after = witnesses_of(growth)[2][: len(before)]
        assert (after <= before).all()
        lowered += int((after < before).sum())
    assert lowered > 0


def test_what_is_forgotten_leads_nowhere_and_what_stays_is_unchanged(scene: PlanningTask) -> None:
    growth = growth_of(scene)
    growth.grow(4000)
    points, nodes, costs = (held.copy() for held in witnesses_of(growth))
    states, size = growth.nodes.x[nodes].copy(), int(growth.nodes.size[0])
    most = int(np.median(costs))
    growth.shorten(most)
    kept_points, kept, kept_costs = witnesses_of(growth)
    stays = costs + 1 < most
    np.testing.assert_array_equal(kept_points, points[stays])
    np.testing.assert_array_equal(kept_costs, costs[stays])
    np.testing.assert_array_equal(growth.nodes.x[kept], states[stays])
    left = int(growth.nodes.size[0])
    assert left < size
    extended = growth.nodes.extensions.parent
    of_use = {int(growth.best[0]), *kept.tolist(), *extended[extended >= 0].tolist()}
    for node in range(left - 1, 0, -1):
        assert node in of_use
        parent = int(growth.nodes.parent[node])
        assert growth.nodes.cost[node] == growth.nodes.cost[parent] + growth.nodes.steps[node]
        of_use.add(parent)
    growth.grow(1000)
    assert witnesses_of(growth)[2].max() + 1 < most


def test_a_full_tree_forgets_what_is_of_no_use_and_goes_on(scene: PlanningTask) -> None:
    """So that as many nodes are enough for far more iterations than would fill them."""
    all_kept = growth_of(scene)
    all_kept.grow(4000)
    size, count = int(all_kept.nodes.size[0]), len(witnesses_of(all_kept)[1])
    few = growth_of(scene, max_nodes=max(64, (size + count) // 2))
    few.grow(4000)
    assert few.nodes.size[0] < size
    for one, other in zip(witnesses_of(all_kept), witnesses_of(few), strict=True):
        if one.dtype != np.int32:  # numbers of nodes are others
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("count", [1, 63, 64, 65, 1000, 5000])
def test_the_cheapest_around_is_found_among_all(count: int) -> None:
    random = np.random.default_rng(count)
    period = np.array([np.inf, 2.0, np.inf])
    points, costs = random.uniform(-1, 1, (count, 3)), random.permutation(count).astype(np.int64)
    trees = Record(r_tree(count, period))
    for point in points:
        add(trees, point)
    for query in random.uniform(-1, 1, (100, 3)):
        gaps = np.abs(points - query)
        gaps[:, 1] = np.minimum(gaps[:, 1], 2.0 - gaps[:, 1])
        around = np.flatnonzero((gaps**2).sum(axis=1) <= 0.2**2)
        best = around[costs[around].argmin()] if len(around) else -1
        assert cheapest_within(trees, costs, query, 0.2**2) == best

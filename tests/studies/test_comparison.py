"""Intervals and tests against their formulas, worked examples and counting."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from kinolab.studies.comparison import compared, comparisons, grouped, holm, median
from tests.studies.tiny_study import Row, several

NAN, INF = math.nan, math.inf
Z = 1.959963984540054  # 97.5 % of the normal distribution


def wilson(solved: int, of: int) -> tuple[float, float]:
    """Return the interval by Wilson's formula."""
    share = solved / of
    middle = (share + Z**2 / (2 * of)) / (1 + Z**2 / of)
    half = Z * math.sqrt(share * (1 - share) / of + Z**2 / (4 * of**2)) / (1 + Z**2 / of)
    return middle - half, middle + half


@pytest.mark.parametrize(("solved", "of"), [(8, 10), (0, 5), (5, 5), (1, 1), (37, 200)])
def test_shares_have_wilsons_interval(solved: int, of: int) -> None:
    (group,) = grouped(several("rrt", [0.1] * solved + [NAN] * (of - solved)))
    share = group.share
    assert share.value == solved / of
    assert (share.low, share.high) == pytest.approx(wilson(solved, of), abs=1e-9)
    if (solved, of) == (8, 10):
        assert (share.low, share.high) == pytest.approx((0.490, 0.943), abs=5e-4)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_few_values_have_no_interval_of_the_median(n: int) -> None:
    """The range of 5 values covers the median with probability 1 - 2 / 2^5, less than 95 %."""
    found = median(np.arange(1.0, n + 1.0))
    assert found.value == (n + 1) / 2
    assert np.isnan([found.low, found.high]).all()


@pytest.mark.parametrize(("n", "low", "high"), [(6, 1, 6), (9, 2, 8), (10, 2, 9), (20, 6, 15)])
def test_the_interval_of_a_median_is_of_order_statistics(n: int, low: int, high: int) -> None:
    """Ranks as in tables of the sign test (95 %)."""
    values = np.random.default_rng(n).permutation(np.arange(1.0, n + 1.0))
    found = median(values)
    assert (found.value, found.low, found.high) == ((n + 1) / 2, low, high)


def test_a_median_of_values_that_are_infinite_is_no_mean_of_them() -> None:
    told = {
        (1.0, 2.0, INF): 2.0,
        (1.0, INF, INF): INF,
        (1.0, 3.0, INF, INF): INF,
        (1.0, 3.0, 4.0, INF): 3.5,
        (INF, INF): INF,
    }
    assert {values: median(np.array(values)).value for values in told} == told
    assert math.isnan(median(np.array([])).value)


def test_a_run_that_is_not_solved_never_ends() -> None:
    (group,) = grouped(several("rrt", [0.2, NAN, 0.4, NAN, 0.3]))
    assert sorted(group.times) == [0.2, 0.3, 0.4, INF, INF]
    assert (group.solved, group.time.value, group.duration.value) == (3, 0.4, 2.0)


def test_holms_method_on_a_worked_example() -> None:
    """0.005 x 4, 0.01 x 3, 0.03 x 2, and 0.04 x 1, which the one before it raises."""
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.5, 0.9]) == pytest.approx([1.0, 1.0])
    assert holm([]) == []
    first, none, last = holm([0.01, NAN, 0.04])
    assert (first, last) == pytest.approx((0.02, 0.04))
    assert math.isnan(none)


def sooner(one: list[float], two: list[float]) -> float:
    """Return the probability that a value of the one is smaller, by counting pairs."""
    pairs = [1.0 if a < b else 0.5 if a == b else 0.0 for a, b in itertools.product(one, two)]
    return sum(pairs) / len(pairs)


@pytest.mark.parametrize(
    ("one", "two"),
    [
        ([0.1, 0.2, 0.3], [0.4, 0.5]),
        ([0.1, 0.4, 0.4, INF], [0.2, 0.4, INF]),
        ([INF, INF], [0.1, 0.2, 0.3]),
        ([0.2, 0.2], [0.2, 0.2]),
    ],
)
def test_the_probability_to_be_sooner_counts_pairs(one: list[float], two: list[float]) -> None:
    rows = [
        *several("a", [NAN if t == INF else t for t in one]),
        *several("b", [NAN if t == INF else t for t in two], first=len(one)),
    ]
    assert compared(*grouped(rows)).sooner == pytest.approx(sooner(one, two))


def test_p_of_times_is_that_of_all_arrangements() -> None:
    """Of the 20 ways to choose 3 of 6 ranks, 2 are as far apart as 1, 2, 3 and 4, 5, 6."""
    rows = [*several("a", [0.1, 0.2, 0.3]), *several("b", [0.4, 0.5, 0.6], first=3)]
    assert compared(*grouped(rows)).p_time == pytest.approx(2 / 20)


def hypergeometric(solved: tuple[int, int], of: tuple[int, int]) -> float:
    """Return Fisher's p: all tables with the same margins that are no likelier than this one."""
    total, among = sum(solved), sum(of)
    chances = {
        k: math.comb(of[0], k) * math.comb(of[1], total - k) / math.comb(among, total)
        for k in range(max(0, total - of[1]), min(of[0], total) + 1)
    }
    return sum(p for p in chances.values() if p <= chances[solved[0]] * (1 + 1e-9))


@pytest.mark.parametrize(("solved", "of"), [((9, 3), (10, 10)), ((5, 5), (5, 5)), ((0, 4), (6, 5))])
def test_p_of_solved_runs_is_of_the_hypergeometric_distribution(
    solved: tuple[int, int], of: tuple[int, int]
) -> None:
    rows: list[Row] = []
    for name, done, count in zip("ab", solved, of, strict=True):
        rows += several(name, [0.1] * done + [NAN] * (count - done), first=len(rows))
    assert compared(*grouped(rows)).p_solved == pytest.approx(hypergeometric(solved, of))


def test_pairs_of_a_scenario_are_corrected_together() -> None:
    rows: list[Row] = []
    for name, base in (("a", 0.1), ("b", 1.1), ("c", 2.1)):
        rows += several(name, [base + k / 100 for k in range(3)], first=len(rows))
    found = comparisons(grouped(rows))
    assert [(c.first.planner, c.second.planner) for c in found] == [
        ("a", "b"),
        ("a", "c"),
        ("b", "c"),
    ]
    assert [c.p_time for c in found] == pytest.approx([0.3, 0.3, 0.3])  # 3 x 2 / 20


def test_the_ratio_of_medians_is_within_its_interval() -> None:
    rows = [
        *several("a", [0.1, 0.2, 0.3, 0.4, 0.5]),
        *several("b", [1.0, 2.0, 3.0, 4.0, 5.0], first=5),
        *several("c", [0.1, NAN, NAN], first=10),
    ]
    with_b, with_c, _ = comparisons(grouped(rows))
    assert with_b.ratio.value == pytest.approx(0.1)
    # medians of resampled ones are among the values themselves
    assert 0.1 / 5.0 <= with_b.ratio.low < 0.1 < with_b.ratio.high <= 0.5 / 1.0
    assert math.isnan(with_c.ratio.value)


def test_kinds_of_computers_are_never_compared_with_each_other() -> None:
    rows: list[Row] = []
    for planner, computer in itertools.product("ab", ("aaaaaaaa", "bbbbbbbb")):
        rows += several(planner, [0.1, 0.2], first=len(rows), computer=computer)
    found = comparisons(grouped(rows))
    assert len(found) == 2
    assert all(pair.first.computer == pair.second.computer for pair in found)


def test_a_run_that_was_lost_counts_where_the_others_were_made() -> None:
    """It tells no computer, but a share that leaves it out would flatter its planner."""
    lost = {"status": "killed", "solved": False, "search": None, "computer": None}
    rows = [*several("rrt", [0.1, 0.2, 0.3])]
    (group,) = grouped([{**rows[0], **lost}, *rows[1:]])
    assert (group.solved, len(group.rows), group.computer) == (2, 3, "aaaaaaaa")


def test_cases_with_and_without_a_sweep_are_groups_of_their_own() -> None:
    swept = {"settings": '{"planner.goal_bias": 0.1}'}
    groups = grouped([*several("rrt", [0.1]), *several("rrt", [0.1], first=1, **swept)])
    assert [group.planner for group in groups] == ["rrt", "rrt[goal_bias=0.1]"]

"""What the rows of a study show: shares solved, times, durations, and which differences are real.

Shares have Wilson's intervals, medians those of order statistics (both 95 %). A run without a
verified plan counts as one that would never have ended, so no run is left out of a time. Two
planners are compared by Fisher's exact test (solved), and by the test of Mann and Whitney (times,
where a run that is not solved comes last; durations of solved runs); p is corrected by Holm's
method for all comparisons of a scenario.

Source: Wilson, JASA 22 (1927); Mann and Whitney, Ann. Math. Stat. 18 (1947); Holm, Scand. J. Stat.
6 (1979).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from kinolab.numerics.arrays import Array
from kinolab.studies.columns import Row
from kinolab.studies.ompl_benchmark import configuration, placed

CONFIDENCE = 0.95
SIGNIFICANT = 0.05
MOST_COMPARED = 12  # planners of one scenario; more make a table or figure that nobody reads


@dataclass(frozen=True)
class Interval:
    """A figure and its confidence interval; infinite where most runs are not solved."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Group:
    """All runs of one planner, with its settings, on one scenario and one kind of computer.

    Attributes:
        scenario: Name of the scenario.
        planner: Name of the planner, with what was swept.
        computer: Hash of what figures depend on.
        rows: Its runs.
    """

    scenario: str
    planner: str
    computer: str
    rows: tuple[Row, ...]

    @property
    def solved(self) -> int:
        """How many runs have a verified plan."""
        return sum(bool(row["solved"]) for row in self.rows)

    @property
    def share(self) -> Interval:
        """Share of runs that are solved."""
        found = stats.binomtest(self.solved, len(self.rows)).proportion_ci(CONFIDENCE, "wilson")
        return Interval(self.solved / len(self.rows), float(found.low), float(found.high))

    @property
    def times(self) -> Array:
        """Processor time of each search in [s]; infinite where it is not solved."""
        return np.array(
            [
                math.inf if row["search"] is None or not row["solved"] else row["search"]
                for row in self.rows
            ]
        )

    @property
    def durations(self) -> Array:
        """Durations of the motions of solved runs in [s]."""
        return np.array([row["duration"] for row in self.rows if row["solved"]], dtype=float)

    @property
    def time(self) -> Interval:
        """Median of the times."""
        return median(self.times)

    @property
    def duration(self) -> Interval:
        """Median of the durations; NaN without a solved run."""
        return median(self.durations)


@dataclass(frozen=True)
class Comparison:
    """Two planners on one scenario.

    Attributes:
        first: Group of the one.
        second: Group of the other.
        ratio: Median time of the first in medians of the second, by bootstrap; NaN where one of
            them solves less than half.
        sooner: Probability that a run of the first is solved sooner than one of the second.
        shorter: The same for durations of motions; NaN where one of them solves none.
        p_solved: p of the difference in solved runs.
        p_time: p of that in times.
        p_duration: p of that in durations; NaN where one of them solves none.
    """

    first: Group
    second: Group
    ratio: Interval
    sooner: float
    shorter: float
    p_solved: float
    p_time: float
    p_duration: float


def grouped(rows: Iterable[Row]) -> list[Group]:
    """Return rows by scenario, then by computer and planner, in the order of the study.

    Where a scenario has more planners with settings than are compared, a group has all settings of
    a planner: the points of a Sobol sequence are a sample, not so many planners.
    """
    placed_rows = list(placed(rows))
    settings: dict[tuple[str, str], set[str]] = {}
    for row, computer in placed_rows:
        settings.setdefault((row["scenario"], computer), set()).add(configuration(row))
    found: dict[tuple[str, str, str], list[Row]] = {}
    for row, computer in placed_rows:
        scenario = row["scenario"]
        many = len(settings[scenario, computer]) > MOST_COMPARED
        name = str(row["planner"]) if many else configuration(row)
        found.setdefault((scenario, name, computer), []).append(row)
    scenarios = list(dict.fromkeys(scenario for scenario, _, _ in found))
    groups = [Group(*key, tuple(own)) for key, own in found.items()]
    return sorted(groups, key=lambda group: scenarios.index(group.scenario))


def median(values: Array) -> Interval:
    """Return the median and its interval by order statistics, which needs no distribution.

    Fewer than 6 values have none of 95 %: their range covers the median less often. Its ends are
    then NaN.

    Args:
        values: Shape (n,); some may be infinite.

    Source: David and Nagaraja, Order Statistics, 2003, section 7.1.
    """
    if not len(values):
        return Interval(math.nan, math.nan, math.nan)
    found = stats.quantile_test(values, p=0.5).confidence_interval(CONFIDENCE)
    return Interval(float(np.median(values)), float(found.low), float(found.high))


def comparisons(groups: Sequence[Group]) -> list[Comparison]:
    """Return all pairs of planners on the same scenario and the same kind of computer."""
    made: list[Comparison] = []
    places = dict.fromkeys((group.scenario, group.computer) for group in groups)
    for place in places:
        own = [group for group in groups if (group.scenario, group.computer) == place]
        if len(own) <= MOST_COMPARED:
            made += corrected([compared(*pair) for pair in itertools.combinations(own, 2)])
    return made


def compared(first: Group, second: Group) -> Comparison:
    """Compare two planners; p is not corrected."""
    table = [[g.solved, len(g.rows) - g.solved] for g in (first, second)]
    sooner, p_time = _ranks(first.times, second.times)
    shorter, p_duration = _ranks(first.durations, second.durations)
    return Comparison(
        first,
        second,
        _ratio(first.times, second.times),
        sooner,
        shorter,
        float(stats.fisher_exact(table).pvalue),
        p_time,
        p_duration,
    )


def _ranks(one: Array, two: Array) -> tuple[float, float]:
    """Return the probability that a value of the first is smaller, ties half, and the test's p."""
    if not (len(one) and len(two)):
        return math.nan, math.nan
    largest = 1e300  # infinite ones are ties
    finite = [np.minimum(values, largest) for values in (one, two)]
    if np.ptp(np.concatenate(finite)) == 0.0:
        return 0.5, 1.0
    found = stats.mannwhitneyu(*finite, alternative="two-sided")
    return 1.0 - float(found.statistic) / (len(one) * len(two)), float(found.pvalue)


def _ratio(one: Array, two: Array) -> Interval:
    above, below = median(one).value, median(two).value
    if not (math.isfinite(above) and math.isfinite(below) and below > 0.0):
        return Interval(math.nan, math.nan, math.nan)
    generator = np.random.default_rng(1)
    drawn = [
        np.median(values[generator.integers(0, len(values), (2000, len(values)))], axis=1)
        for values in (np.minimum(one, 1e300), np.minimum(two, 1e300))
    ]
    with np.errstate(over="ignore"):
        low, high = np.percentile(drawn[0] / drawn[1], [2.5, 97.5])
    return Interval(above / below, float(low), math.inf if high > 1e100 else float(high))


def corrected(made: Sequence[Comparison]) -> list[Comparison]:
    """Return comparisons whose p are corrected by Holm's method, each kind by itself."""
    solved = holm([one.p_solved for one in made])
    times = holm([one.p_time for one in made])
    durations = holm([one.p_duration for one in made])
    return [
        replace(one, p_solved=s, p_time=t, p_duration=d)
        for one, s, t, d in zip(made, solved, times, durations, strict=True)
    ]


def holm(values: Sequence[float]) -> list[float]:
    """Return p corrected for as many tests as there are; NaN is none."""
    known = sorted((p, k) for k, p in enumerate(values) if not math.isnan(p))
    result, largest = [math.nan] * len(values), 0.0
    for rank, (p, k) in enumerate(known):
        largest = max(largest, min(1.0, p * (len(known) - rank)))
        result[k] = largest
    return result

"""What was measured, as Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from statistics import median

import numpy as np

from .beginning import STATES, Beginning
from .growing import SIZES, Growth
from .ratios import ratio
from .runs import KINOLAB, LIKE, OMPL, PROBLEMS, Entrant, Run
from .together import WAYS, Throughput

NOTHING = "–"
Row = Sequence[str]


@dataclass(frozen=True)
class Comparison:
    """Who is compared with whom.

    Attributes:
        title: In words.
        theirs, ours: Whose runs count; the best planner of each side does.
        targets: By problem.
        measure: Returns the times that are compared, of runs with a limit in [s].
    """

    title: str
    theirs: Callable[[Entrant], bool]
    ours: Callable[[Entrant], bool]
    targets: dict[str, float]
    measure: Callable[[Iterable[Run], float], list[float]]


def times(runs: Iterable[Run], limit: float) -> list[float]:
    """Return the CPU times that are compared, set-up and verdicts included; the limit for none."""
    return [run.setup + run.cpu + run.judging_cpu if run.counts else limit for run in runs]


def on_clock(runs: Iterable[Run], limit: float) -> list[float]:
    """Return the same by the clock."""
    return [run.setup + run.wall + run.judging_wall if run.counts else limit for run in runs]


def _like(name: str, targets: dict[str, float], threads: int = 1) -> Comparison:
    theirs = Entrant(OMPL, LIKE[name])
    alike = Entrant(KINOLAB, name, LIKE[name])
    title = f"{theirs.planner} against {name}, {alike.settings}"
    if threads == 1:
        return Comparison(title, theirs.__eq__, alike.__eq__, targets, times)

    def ours(one: Entrant) -> bool:
        return one.threads > 1 and replace(one, threads=1) == alike

    title += ", in threads"
    return Comparison(title, theirs.__eq__, ours, targets, on_clock)


RRT_TARGETS, SST_TARGETS = {"disk": 5.0, "crane": 5.0}, {"disk": 10.0}
COMPARISONS = (
    _like("rrt_fast", RRT_TARGETS),
    _like("rrt_fast", RRT_TARGETS, threads=2),
    _like("sst", SST_TARGETS),
    _like("sst", SST_TARGETS, threads=2),
    Comparison(
        "best against best",
        lambda one: one.side == OMPL,
        lambda one: one.side == KINOLAB and not one.like,
        {"disk": 3.0, "crane": 5.0},
        times,
    ),
)


def markdown(headings: Row, rows: Iterable[Row]) -> str:
    """Return a table."""
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def searches(runs: Sequence[Run], limit: float) -> str:
    """Return a row for each problem and entrant."""
    headings = (
        *("problem", "planner", "settings", "solved", "verdict", "CPU: median / p90 / worst [s]"),
        *("clock: median / p90 / worst [s]", "of it verdict [s]", "of it set-up [s]"),
        *("propagations", "motion [s]"),
    )
    return markdown(headings, (_row_of(own, limit) for own in grouped(runs).values()))


def grouped(runs: Iterable[Run]) -> dict[tuple[str, Entrant], list[Run]]:
    """Return the runs by problem and entrant, OMPL's first."""
    found: dict[tuple[str, Entrant], list[Run]] = {}
    for run in runs:
        found.setdefault((run.problem, run.entrant), []).append(run)
    order = sorted(found, key=lambda key: (PROBLEMS.index(key[0]), key[1].side != OMPL))
    return {key: found[key] for key in order}


def _row_of(runs: Sequence[Run], limit: float) -> Row:
    first, solved = runs[0], [run for run in runs if run.solved]
    return (
        *(first.problem, f"{first.entrant.side} {first.entrant.planner}", first.entrant.settings),
        *(f"{len(solved)}/{len(runs)}", _verdict(solved)),
        *(_spread(times(runs, limit), limit), _spread(on_clock(runs, limit), limit)),
        _middle([run.judging_cpu for run in solved if run.entrant.side == KINOLAB], ".4f"),
        _middle([run.setup for run in runs], ".3f"),
        _middle([run.propagations for run in solved], ".0f"),
        _middle([run.duration for run in solved], ".1f"),
    )


def _verdict(solved: Sequence[Run]) -> str:
    """Return how many motions passed, and how many did not."""
    text = f"{sum(not (run.at_knots or run.between) for run in solved)}/{len(solved)}"
    for where, count in (
        ("at knots", sum(bool(run.at_knots) for run in solved)),
        ("between", sum(bool(run.between) for run in solved)),
    ):
        text += f", {count} refused {where}" if count else ""
    return text


def refused(runs: Sequence[Run]) -> Iterator[str]:
    """Yield the motions that did not pass as a list, where there are any."""
    lines = []
    for (problem, entrant), own in grouped(runs).items():
        for where in ("at_knots", "between"):
            faults = {run.seed: getattr(run, where) for run in own if getattr(run, where)}
            if faults:
                seeds = ", ".join(map(str, faults))
                first = next(iter(faults.values()))
                head = f"- {problem}, {entrant}, {where.replace('_', ' ')}: seeds {seeds}"
                lines.append(f"{head}; the first one: {first}")
    if lines:
        yield "Refused by the verdict:\n\n" + "\n".join(lines)


def _spread(values: Sequence[float], limit: float) -> str:
    named = (median(values), float(np.quantile(values, 0.9, method="higher")), max(values))
    return " / ".join(_seconds(value, limit) for value in named)


def _seconds(value: float, limit: float) -> str:
    return f"≥ {limit:.3g}" if value >= limit else f"{value:.4f}"


def _middle(values: Sequence[float], form: str) -> str:
    return format(median(values), form) if values else NOTHING


def ratios(runs: Sequence[Run], limit: float) -> str:
    """Return how many times as long OMPL takes."""
    headings = (
        *("problem", "compared", "OMPL, median [s]", "kinolab, median [s]", "ratio"),
        *("95 % interval", "target", "OMPL solved", "kinolab solved"),
    )
    rows = [
        row
        for problem in PROBLEMS
        for comparison in COMPARISONS
        if (row := _ratio_row(problem, comparison, runs, limit))
    ]
    return markdown(headings, rows)


def _ratio_row(
    problem: str, comparison: Comparison, runs: Sequence[Run], limit: float
) -> Row | None:
    own = {one: found for (name, one), found in grouped(runs).items() if name == problem}
    theirs = {one: found for one, found in own.items() if comparison.theirs(one)}
    ours = {one: found for one, found in own.items() if comparison.ours(one)}
    if not (theirs and ours):
        return None
    measured = {one: comparison.measure(found, limit) for one, found in own.items()}
    result = ratio([measured[one] for one in theirs], [measured[one] for one in ours])
    best = [min(side, key=lambda one: median(measured[one])) for side in (theirs, ours)]
    medians = [median(measured[one]) for one in best]
    solved = [f"{sum(run.counts for run in own[one])}/{len(own[one])}" for one in best]
    least = "≥ " if medians[0] >= limit else ""
    target = comparison.targets.get(problem)
    return (
        *(problem, comparison.title),
        *(f"{one.planner} {_seconds(t, limit)}" for one, t in zip(best, medians, strict=True)),
        *(f"{least}{result.value:.1f}", f"{result.low:.1f} to {result.high:.1f}"),
        *(NOTHING if target is None else f"{target:g}", *solved),
    )


def rates(growths: Sequence[Growth]) -> str:
    """Return propagations per second by the size of the tree, medians over seeds."""
    bounds = [f"{low:,} to {high:,}" for low, high in pairwise(SIZES)]
    headings = ("problem", "planner", f"below {SIZES[0]:,}", *bounds, "last / first")
    rows = []
    for (problem, entrant), own in _growths_by(growths).items():
        parts = [[g.rates[k] for g in own if len(g.rates) > k] for k in range(len(SIZES))]
        shares = [g.rates[-1] / g.rates[0] for g in own if len(g.rates) == len(SIZES)]
        middles = [f"{median(part):,.0f}" if part else NOTHING for part in parts]
        rows.append((problem, str(entrant), *middles, _middle(shares, ".2f")))
    return markdown(headings, rows)


def memory(growths: Sequence[Growth]) -> str:
    """Return the growth of the resident memory with the tree."""
    rows = [
        (problem, str(entrant), _middle([g.megabytes for g in own], ".3f"))
        for (problem, entrant), own in _growths_by(growths).items()
    ]
    return markdown(("problem", "planner", "MB per 1000 nodes"), rows)


def _growths_by(growths: Iterable[Growth]) -> dict[tuple[str, Entrant], list[Growth]]:
    found: dict[tuple[str, Entrant], list[Growth]] = {}
    for growth in growths:
        found.setdefault((growth.problem, growth.entrant), []).append(growth)
    return found


def beginnings(found: Sequence[Beginning]) -> str:
    """Return how long it took to the first node, medians over repeats."""
    rows = []
    for problem, planner in dict.fromkeys((one.problem, one.planner) for one in found):
        for state in STATES:
            own = [b for b in found if (b.problem, b.planner, b.state) == (problem, planner, state)]
            spans = [[b.total for b in own], [b.machine for b in own], [b.search for b in own]]
            cells = (_middle(span, ".2f") for span in (*spans, [b.imports for b in own]))
            rows.append((problem, planner, state, *cells))
    headings = ("problem", "planner", "on disk", "definition to first node [s]")
    return markdown((*headings, "of it machine", "of it search", "imports before [s]"), rows)


def throughputs(found: Sequence[Throughput]) -> str:
    """Return what two searches do at once against one, medians over repeats."""
    rows = []
    for problem in dict.fromkeys(one.problem for one in found):
        by_way = {
            way: [t.rate for t in found if (t.problem, t.way) == (problem, way)] for way in WAYS
        }
        for way, own in by_way.items():
            if own:
                share = median(own) / median(by_way["one"])
                rows.append((problem, way, f"{median(own):,.0f}", f"{share:.2f}"))
    return markdown(("problem", "searches", "propagations per second", "of one"), rows)

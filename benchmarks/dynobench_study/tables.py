"""What was measured, beside what others published, as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from statistics import median

from .problems import machine_of
from .published import PLANNERS, Others, published
from .records import Offline, Run

HEADINGS = (
    *("problem", "authors", "strict", "time [s]", "first [s]", "final [s]", "clearance [m]"),
    *("offline [s]", *PLANNERS, "best [s]"),
)
LEGEND = f"""\
- *authors*: runs whose final motion the authors' own code accepts, dynobench 0.0.4, by its own
  tolerances; *strict*: those that kinolab's verifier accepts, with the exact start, at most 0.001
  from the goal by the sum of the weighted deviations, no overlap between the states either, the
  workspace and the limit of the hitch. A run counts as solved where both accept it.
- *time*: until the first exact motion, set-up apart; a run that is not solved counts as the limit,
  and ≥ marks a median in which one does. *first*, *final*: costs of the first exact motion and of
  the last one, the benchmark's N dt. All are medians; costs are those of the solved runs.
- *clearance*: smallest distance to an obstacle over the continuous final motion, of all solved
  runs; – where there are no obstacles.
- *offline*: derivation and compilation of the machine, nothing kept, median; no motion primitives
  are made.
- {", ".join(PLANNERS)}: share of runs that succeeded, time, first and final cost as published for
  120 s on another, faster machine (i9-14900KF); *best*: the lowest cost published or stored. The
  published SST* had goal radii of 0.2 to 0.7, and its last optimisation is not in the time;
  iDb-A* had motion primitives that were made before."""


def table(runs: Sequence[Run], offline: Sequence[Offline], limit: float) -> str:
    """Return one row per problem that was run."""
    others = published()
    prepared = {one.machine: f"{median(one.seconds):.2f}" for one in offline if one.seconds}
    rows = [list(HEADINGS), ["---"] * len(HEADINGS)]
    for name, known in others.items():
        own = [run for run in runs if run.problem == name]
        if own:
            before = prepared.get(machine_of(name), "–")
            rows.append([name, *_own(own, limit), before, *_published(known)])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _own(runs: Sequence[Run], limit: float) -> list[str]:
    solved = [run for run in runs if run.counts]
    times = times_to_first(runs, limit)
    mark = "≥ " if len(times) // 2 >= len(solved) else ""  # of two in the middle, the later one
    rooms = [run.clearance for run in solved if run.clearance is not None]
    return [
        f"{sum(run.accepted for run in runs)}/{len(runs)}",
        f"{sum(run.strict for run in runs)}/{len(runs)}",
        f"{mark}{median(times):.2f}",
        _cost(run.first.duration for run in solved if run.first),
        _cost(run.final.duration for run in solved if run.final),
        f"{min(rooms):.4f}" if rooms else "–",
    ]


def _published(known: Others) -> list[str]:
    return [*(str(known.by[who]) for who in PLANNERS), f"{known.best:g}"]


def times_to_first(runs: Iterable[Run], limit: float) -> list[float]:
    """Return the times to the first exact motion in [s], in order; the limit for unsolved runs."""
    return sorted(run.first.seconds if run.counts and run.first else limit for run in runs)


def _cost(values: Iterable[float]) -> str:
    found = list(values)
    return f"{median(found):.2f}" if found else "–"

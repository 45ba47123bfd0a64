"""How a search went, and the file of JSON lines that keeps all of them as they come."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

TOLERANCES = {  # of the benchmark's checker, all strict (Feasibility_thresholds)
    **dict.fromkeys(("start", "goal"), 0.03),
    **dict.fromkeys(("jump", "collision", "states", "actions"), 0.01),
}
CENTRE = 1e-4  # SI units: well within what counts as exact by the weighted sum, 1e-3


@dataclass(frozen=True)
class Improvement:
    """A verified motion on the way to the best one.

    Attributes:
        seconds: Since the search began, set-up apart.
        duration: Of the motion in [s], the benchmark's cost.
        made_by: ``search``, ``repair`` or ``shorten``.
        distance: From the goal's centre at the end, Euclidean, in SI units.
    """

    seconds: float
    duration: float
    made_by: str
    distance: float

    @property
    def exact(self) -> bool:
        """Whether it ends in the middle of the goal."""
        return self.distance <= CENTRE


@dataclass(frozen=True)
class Run:
    """One problem with one seed.

    Attributes:
        problem: Such as ``car1_v0/kink_0``.
        seed: Of the random numbers.
        setup: Seconds to load the problem and what is compiled, from disk where it was kept.
        improvements: In the order in which they were found.
        faults: What kinolab's verifier says against the final motion; None where there is none.
        goal: Sum of the weighted deviations from the goal's centre at its end.
        clearance: Its smallest distance to obstacles in [m]; None without obstacles.
        official: What the authors' code measures; empty where it was not asked or failed.
        complaint: What went wrong, where something did.
    """

    problem: str
    seed: int
    setup: float = 0.0
    improvements: tuple[Improvement, ...] = ()
    faults: tuple[str, ...] | None = None
    goal: float | None = None
    clearance: float | None = None
    official: Mapping[str, float] = field(default_factory=dict)
    complaint: str = ""

    @property
    def strict(self) -> bool:
        """Whether the final motion passes kinolab's verifier, which is the stricter one."""
        return self.faults == ()

    @property
    def accepted(self) -> bool:
        """Whether it passes the benchmark's checker; without an answer it does not."""
        return bool(self.official) and all(
            self.official[name] < limit for name, limit in TOLERANCES.items()
        )

    @property
    def counts(self) -> bool:
        """Whether it is solved by both."""
        return self.strict and self.accepted

    @property
    def first(self) -> Improvement | None:
        """The first exact motion."""
        return next((one for one in self.improvements if one.exact), None)

    @property
    def final(self) -> Improvement | None:
        """The best motion, which is the one that was judged: the shortest exact one, if any is."""
        return min(self.improvements, key=lambda one: (not one.exact, one.duration), default=None)

    def __str__(self) -> str:
        verdict = f"authors {self.accepted}, strict {self.strict}"
        final, first = self.final, self.first
        cost = f", cost {final.duration:.2f} s" if final else ""
        time = f", exact after {first.seconds:.2f} s" if first else ""
        fault = f": {self.complaint or '; '.join(self.faults or ())}".rstrip(": ")
        return f"{self.problem}, seed {self.seed}: {verdict}{time}{cost}{fault}"


@dataclass(frozen=True)
class Offline:
    """What a machine costs before the first search: derivation and compilation, nothing kept.

    Attributes:
        machine: Its name.
        seconds: Of every time it was measured.
    """

    machine: str
    seconds: tuple[float, ...]


@dataclass
class Results:
    """All that was measured, and under which circumstances."""

    circumstances: dict[str, Any] = field(default_factory=dict)
    runs: list[Run] = field(default_factory=list)
    offline: list[Offline] = field(default_factory=list)


def append(path: Path, record: Run | Offline | dict[str, Any]) -> None:
    """Add one record to a file; it is written whole before the next one begins."""
    content = record if isinstance(record, dict) else asdict(record)
    kind = "circumstances" if isinstance(record, dict) else type(record).__name__.lower()
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps({kind: content}) + "\n")


def read(path: Path) -> Results:
    """Return what a file holds; a last line that was broken off is left out."""
    results = Results()
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        try:
            ((kind, content),) = json.loads(line).items()
        except ValueError:
            continue
        if kind == "run":
            results.runs.append(run_of(content))
        elif kind == "offline":
            results.offline.append(Offline(content["machine"], tuple(content["seconds"])))
        else:
            results.circumstances = content
    return results


def run_of(content: Mapping[str, Any]) -> Run:
    """Return a run from what was written of it."""
    faults = content["faults"]
    own = {
        "improvements": tuple(Improvement(**one) for one in content["improvements"]),
        "faults": None if faults is None else tuple(faults),
    }
    return Run(**{**content, **own})

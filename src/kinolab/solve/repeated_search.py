"""One seed's searches: where the verifier refuses a motion, another search follows."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from kinolab.solve.plan import Plan
from kinolab.solve.solution_pool import rank

REFUSED = "verification_failed"


@dataclass
class RepeatedSearch:
    """What the searches with one seed have come to.

    Attributes:
        seed: Of the first one.
        most: Iterations of all together, None for no limit.
        made: Iterations so far.
        refused: How many motions the verifier refused, by the checks that they did not pass.
    """

    seed: int
    most: int | None = None
    made: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    _last: Plan | None = None
    _best: Plan | None = None  # of those refused
    _again: bool = False  # whether the last motion had been refused before
    _seen: set[bytes] = field(default_factory=set)
    _timings: Counter[str] = field(default_factory=Counter)

    @property
    def begun(self) -> bool:
        """Whether any search has ended."""
        return self._last is not None

    @property
    def next_seed(self) -> int:
        """Seed of the next search."""
        return stream(self.seed, self.refused.total()) if self.refused else self.seed

    @property
    def left(self) -> int | None:
        """Iterations of the next search, None for no limit."""
        return None if self.most is None else self.most - self.made

    @property
    def over(self) -> bool:
        """Whether no other search may find what the verifier accepts.

        It cannot where a motion comes again: nothing in that planner is drawn at random.
        """
        last = self._last
        if last is None:
            return False
        spent = self.left is not None and (self.left <= 0 or not last.iterations)
        return last.status != REFUSED or last.interrupted or self._again or spent

    def add(self, found: Plan, last: Plan) -> None:
        """Take in how one more search ended.

        Args:
            found: As the search gave it.
            last: What has been made of it.
        """
        self.made += found.iterations
        self._timings.update(last.timings)
        self._last = last
        if found.status == REFUSED:
            self.refused[_checks(found)] += 1
            self._again = self._known(found)
        if last.status == REFUSED:
            self._best = min((self._best or last, last), key=rank)

    def plan(self) -> Plan:
        """Return the verified motion, else the best that was refused, else what there is."""
        last, best = self._last, self._best
        assert last is not None, "a search has ended"
        return replace(
            last if best is None or last.status == "solved" else best,
            iterations=self.made,
            timings=dict(self._timings),
            refused=dict(self.refused),
            interrupted=last.interrupted,
        )

    def _known(self, found: Plan) -> bool:
        """Say whether a motion has these inputs that was refused before, and remember them."""
        if found.trajectory is None:
            return False
        inputs, known = found.trajectory.inputs.tobytes(), len(self._seen)
        self._seen.add(inputs)
        return len(self._seen) == known


def stream(seed: int, k: int) -> int:
    """Return the seed of the k-th further search after one with a seed."""
    return int(np.random.SeedSequence((seed, k)).generate_state(1)[0])


def _checks(refused: Plan) -> str:
    """Name the checks that a motion did not pass; one that cannot be followed is none."""
    certificate = refused.certificate
    return "motion" if certificate is None else ", ".join(c.name for c in certificate.failures)

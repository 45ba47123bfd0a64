"""Why motions were refused, counted as they are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable

# rejections of each cause whose culprit is looked for; beyond them one in SPARSE
FULLY_EXPLAINED = 200
EXPLANATION_PERIOD = 32


class Rejections:
    """How many motions were refused, by cause, and who is to blame.

    Naming a culprit can cost more than the motion did, so that only a sample is asked for: every
    one of the first ones, then one in ``EXPLANATION_PERIOD``, which counts for as many.

    Attributes:
        counts: Refused motions by cause: ``limit``, ``collision`` or ``equations``.
    """

    def __init__(self) -> None:
        self.counts = {"limit": 0, "collision": 0, "equations": 0}
        self._culprits: Counter[tuple[str, str]] = Counter()

    def add(self, cause: str, culprits: Callable[[], Iterable[str]]) -> None:
        """Count a rejection; ``culprits`` names who is to blame, where it is asked."""
        self.counts[cause] = count = self.counts[cause] + 1
        if count <= FULLY_EXPLAINED or count % EXPLANATION_PERIOD == 0:
            weight = 1 if count <= FULLY_EXPLAINED else EXPLANATION_PERIOD
            self._culprits.update({(cause, culprit): weight for culprit in culprits()})

    def shares(self) -> dict[str, dict[str, float]]:
        """Return by cause and culprit the share of all rejections, the largest first."""
        total = max(sum(self.counts.values()), 1)
        found: dict[str, dict[str, float]] = {}
        for cause, count in sorted(self.counts.items(), key=lambda item: -item[1]):
            named = {who: n for (why, who), n in self._culprits.most_common() if why == cause}
            sampled = max(sum(named.values()), 1)
            if count:
                found[cause] = {who: count / total * n / sampled for who, n in named.items()}
        return found

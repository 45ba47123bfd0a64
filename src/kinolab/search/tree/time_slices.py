"""Time slices between clock checks of a compiled search, and its restart rounds."""

from __future__ import annotations

import math

from kinolab.search.budget import Budget


class RestartRounds:
    """Rounds after which a search begins anew, each longer than the one before.

    Args:
        restart_after: Iterations of the first round; 0 for a single round.

    Attributes:
        left: Iterations that are left of the round.
        restarts: Number of rounds begun after the first one.
    """

    def __init__(self, restart_after: int) -> None:
        self._length = self.left = float(restart_after or math.inf)
        self.restarts = 0

    @property
    def over(self) -> bool:
        """Whether a new round is due."""
        return self.left <= 0

    def begin(self) -> None:
        """Begin a new round."""
        self._length *= 1.5  # ratio of consecutive round lengths
        self.left = self._length
        self.restarts += 1


class TimeSlices:
    """Chooses the number of iterations until the next clock check."""

    def __init__(self, budget: Budget, rounds: RestartRounds) -> None:
        self._budget, self._size, self._begun = budget, 64, 0.0  # iterations of the first slice
        self._rounds = rounds

    def next(self, most: float) -> int:
        """Return the number of iterations of the next slice; 0 when the search must end."""
        if self._budget.over:
            return 0
        self._begun = self._budget.clock()
        return int(max(1, min(self._size, self._budget.left, self._rounds.left, most)))

    def done(self, iterations: int) -> None:
        """Count iterations made, and adapt the next slice to the time they took."""
        self._budget.spend(iterations)
        self._rounds.left -= iterations
        took = max(self._budget.clock() - self._begun, 1e-6)
        fitting = iterations * 0.005 / took  # [s] between clock checks
        # Grow slowly: the first iterations of a tree are far faster than later ones.
        # iterations of a slice: some milliseconds, and short enough even if they get slow
        self._size = int(min(max(fitting, self._size / 4, 1), 2 * self._size, 2048))

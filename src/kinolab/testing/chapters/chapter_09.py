"""Optimisation after the search."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from kinolab.testing.answers.judging import TOLERANCE, Exercise, WrongAnswerError, require_values

Array = NDArray[np.float64]
Free = Callable[[Array, Array], bool]

TIME_CASES = [
    (1.0, 1.0, 10.0),
    (4.0, 1.0, 1.0),
    (9.0, 2.0, 3.0),
    (0.5, 4.0, 0.7),
    (2.0, 0.5, 1.0),
    (3.0, 1.0, 2.0),
]
DISCS = ((2.0, 0.0, 1.2), (5.0, 1.0, 1.3), (7.5, -0.6, 1.0))  # [m] x, y, radius
DETOUR = ((0.0, 0.0), (2.0, -1.6), (5.0, -6.0), (7.5, -1.9), (10.0, 0.0))  # fewest rows, far round


def _least_time(distance: float, limit: float, fastest: float) -> float:
    """Integrate the speed that is possible after each piece of the way."""
    way = distance * (1.0 - np.cos(np.linspace(0.0, np.pi, 400_001))) / 2.0  # dense at both ends
    middles = (way[1:] + way[:-1]) / 2.0
    speeds = np.sqrt(2.0 * limit * np.minimum(middles, distance - middles))
    return float((np.diff(way) / np.minimum(speeds, fastest)).sum())


def _defects(x: Array, u: Array, h: float) -> Array:
    """Take the steps by the exponential of a matrix, exact for an input that is held."""
    step = expm(h * np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]))
    return np.array(x[1:] - np.column_stack([x[:-1], u]) @ step[:2].T)


def _defect_cases() -> list[tuple[Array, Array, float]]:
    random = np.random.default_rng(9)
    return [
        (random.normal(size=(n + 1, 2)), random.normal(size=n), h) for n, h in ((1, 1.0), (5, 0.3))
    ]


def _free(a: Array, b: Array) -> bool:
    """Return whether the segment from a to b stays out of all discs."""
    points = np.linspace(a, b, 200)
    return all(bool((np.hypot(*(points - [x, y]).T) > r).all()) for x, y, r in DISCS)


@cache
def _paths() -> list[Array]:
    random = np.random.default_rng(4)
    paths: list[Array] = [np.array(DETOUR)]
    while len(paths) < 7:
        side = np.interp(np.arange(9.0), [0, 2, 5, 7, 8], [0, 2, -1.5, 1.5, 0])
        y = random.choice([-1.0, 1.0]) * side + random.normal(0.0, 0.8, 9)
        path = np.column_stack([np.linspace(0.0, 10.0, 9) + random.normal(0.0, 0.4, 9), y])
        if all(_free(a, b) for a, b in pairwise(path)):
            paths.append(path)
    return paths


def _length(path: Array) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _shortest(path: Array) -> float:
    """Try all choices of points between the ends."""
    last, lengths = len(path) - 1, []
    for size in range(last):
        for chosen in combinations(range(1, last), size):
            kept = path[[0, *chosen, last]]
            if all(_free(a, b) for a, b in pairwise(kept)):
                lengths.append(_length(kept))
    return min(lengths)


def _shortcut(answer: Any) -> None:
    def is_best(path: Array) -> bool:
        returned = answer(path.copy(), _free)
        if returned is None:
            raise WrongAnswerError("there is no answer: it returns None.")
        kept = list(returned)
        if any(not isinstance(i, int | np.integer) for i in kept):
            raise WrongAnswerError(f"numbers of rows are wanted, not {kept}.")
        chosen = f"the rows {[int(i) for i in kept]} of a path of {len(path)} points"
        if not kept or kept[0] != 0 or kept[-1] != len(path) - 1 or sorted(set(kept)) != kept:
            what = f"{chosen} do not lead from the first row to the last, in increasing order."
            raise WrongAnswerError(what)
        rows = path[kept]
        if not all(_free(a, b) for a, b in pairwise(rows)):
            raise WrongAnswerError(f"the way along {chosen} is not free.")
        if _length(rows) > (1.0 + TOLERANCE) * _shortest(path):
            raise WrongAnswerError(
                f"the way along {chosen} is {_length(rows):.4g} long, and there is a shorter one."
            )
        return True

    cases = [(path,) for path in _paths()]
    require_values(is_best if callable(answer) else answer, lambda _: True, cases)


EXERCISES = (
    Exercise(
        "9.1", 2, lambda answer: require_values(answer, _least_time, TIME_CASES, tolerance=1e-4)
    ),
    Exercise("9.2", 2, lambda a: require_values(a, _defects, _defect_cases())),
    Exercise("9.3", 3, _shortcut),
)

"""States between the knots of a motion, from what is stored in it alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.numerics.arrays import Array


def states_at(t: Array, x: Array, names: Sequence[str], times: Array) -> Array:
    """Return the states at times within a motion, shape (m, nx).

    A coordinate whose rate is a state, too, follows the cubic that has both at both knots, with an
    error of order h^4 for knots h apart; all others the chord, with one of order h^2. Quaternions
    are made unit.

    Args:
        t: Times of the knots in [s], shape (N+1,).
        x: States at the knots, shape (N+1, nx).
        times: In [s], shape (m,), from ``t[0]`` to ``t[-1]``.

    Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.6 (Hermite interpolation).
    """
    if len(t) == 1:
        return np.repeat(x, len(times), axis=0)
    k = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    h = np.diff(t)[k][:, None]
    s = (times - t[k])[:, None] / h
    found: Array = (1 - s) * x[k] + s * x[k + 1]
    places = {name: i for i, name in enumerate(names)}
    own = [i for name, i in places.items() if f"{name}_dot" in places]
    rate = [places[f"{names[i]}_dot"] for i in own]
    chord = x[k + 1][:, own] - x[k][:, own]
    begin, end = h * x[k][:, rate] - chord, h * x[k + 1][:, rate] - chord
    found[:, own] += s * (1 - s) * ((1 - s) * begin - s * end)
    for entries in _quaternions(x, names):
        found[:, entries] /= np.linalg.norm(found[:, entries], axis=1, keepdims=True)
    return found


def _quaternions(x: Array, names: Sequence[str]) -> Iterator[slice]:
    """Yield where unit quaternions stand: R_x, R_y, R_z, R_w beside each other, of length 1."""
    for i in range(len(names) - 3):
        stem = names[i].removesuffix("_x")
        if tuple(names[i : i + 4]) == tuple(f"{stem}_{axis}" for axis in "xyzw"):
            entries = slice(i, i + 4)
            # 1e-6: by which the length of a stored unit quaternion may differ from 1
            if (np.abs(np.linalg.norm(x[:, entries], axis=1) - 1) < 1e-6).all():
                yield entries

"""Cycle removal: cut out a loop where a motion returns to nearly the same state.

Guesses keep the motion before and after a loop and distribute the gap between its ends over both,
so no steering function is needed.

Source: Frazzoli, Dahleh, Feron, Maneuver-based motion planning for nonlinear systems with
symmetries, IEEE Transactions on Robotics 21(6), 2005 (concatenating motions whose end states
match).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact.segments import Segments, straight
from kinolab.trajopt.nlp.decision import Knots, resampled
from kinolab.trajopt.nlp.options import SHORT


def cycles_removed(segments: Segments, motion: Trajectory) -> Iterator[Trajectory]:
    """Yield a motion without one loop, without two, and so on.

    Args:
        segments: Turns guesses into feasible segments.
        motion: A dynamically feasible motion.
    """
    while not segments.cancelled():
        shorter = _without_one(segments, motion)
        if shorter is None:
            break
        motion = shorter
        yield motion


def _without_one(segments: Segments, motion: Trajectory) -> Trajectory | None:
    """Return a motion with one loop less, or None."""
    t, margin = motion.t, SHORT.blend_steps * segments.problem.step
    for tried, (begin, end) in enumerate(_cycles(segments.problem, motion)):
        if tried == SHORT.max_failed_cycles or segments.cancelled():
            break
        before = int(np.searchsorted(t, t[begin] - margin))
        after = min(int(np.searchsorted(t, t[end] + margin)), len(t) - 1)
        if begin - before + after - end < SHORT.min_steps:
            continue  # too few steps to absorb the gap
        given, last = motion.piece(before, after), after == len(motion.u)
        guess = _closed_gap(segments.problem, given, begin - before, end - before)
        segment = segments.along(guess, given, last=last)
        if segment is not None:
            return motion.with_piece(before, after, segment, segments.space)
    return None


def _closed_gap(problem: PlanningTask, motion: Trajectory, begin: int, end: int) -> Knots:
    """Return a guess without the loop, the gap distributed over the rest."""
    before, after = motion.piece(0, begin), motion.piece(end, len(motion.u))
    times = np.concatenate([before.t, before.t[-1] + after.t[1:]])
    fraction = (times / times[-1])[:, None]
    here = before.x[-1]
    there = straight(problem, here, after.x[0])[1]
    x = np.vstack([before.x, problem.space.carried(after.x, there)[1:]])
    x[: begin + 1] += fraction[: begin + 1] * (there - here)
    x[begin + 1 :] -= (1 - fraction[begin + 1 :]) * (there - here)
    u = np.vstack([before.inputs, after.inputs])
    return resampled(times, x, u, min(SHORT.cycle_knots, len(u)), problem.space)


def _cycles(problem: PlanningTask, motion: Trajectory) -> Iterator[tuple[int, int]]:
    """Yield the end indices of loops, long ones with small gaps first."""
    t, step, near = motion.t, problem.step, SHORT.same_cycle_samples
    apart = max(SHORT.min_cycle_spacing * step, t[-1] / SHORT.cycle_samples)
    places = np.unique(np.minimum(np.searchsorted(t, np.arange(0, t[-1], apart)), len(t) - 1))
    gap, taken = _gaps(problem, motion.x[places]), t[places] - t[places][:, None]
    path = np.concatenate([[0.0], np.cumsum(np.diagonal(gap, 1))])
    length = path - path[:, None]
    alike = SHORT.negligible_gap * SHORT.blend_steps * step * path[-1] / t[-1]
    long = taken >= SHORT.min_cycle_steps * step
    loops = long & (gap <= SHORT.max_cycle_gap * length)
    worth = np.where(loops, taken / (gap + alike) ** SHORT.gap_exponent, 0.0)
    while worth.any():
        i, j = np.unravel_index(int(worth.argmax()), worth.shape)
        yield int(places[i]), int(places[j])
        worth[max(0, i - near) : i + near + 1, max(0, j - near) : j + near + 1] = 0.0


def _gaps(problem: PlanningTask, x: Array) -> Array:
    """Return pairwise weighted distances of states (m, nx), shape (m, m)."""
    counted = np.where(cyclic_coordinates(problem), 0.0, problem.weights)
    return problem.space.distance(x[:, None], x[None], counted)

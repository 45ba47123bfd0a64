"""Key poses of a motion, refined until cubic curves follow it between stored knots."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.show.scene.content import Curve, Keys
from kinolab.show.scene.curves import continued, hermite
from kinolab.show.scene.tracks import Track, tracks
from kinolab.trajectory import Trajectory

Marks: TypeAlias = NDArray[np.bool_]

# A ``np.recarray`` of segments: ``begin`` and ``end`` in [s], the states ``x`` and ``y`` there, of
# shape (nx,), and the inputs ``u`` held between them, of shape (nu,).
Branches: TypeAlias = Any


def key_poses(problem: PlanningTask, trajectory: Trajectory) -> Keys:
    """Return every stored knot as a key, and more where a curve would deviate from the motion.

    Each body has its own keys: a flywheel needs many, the satellite around it few.

    Args:
        problem: The problem; [integration] defines the motion between knots.
    """
    if len(trajectory.t) == 1:
        rest = tracks(problem.model.plant, trajectory.x, np.zeros_like(trajectory.x))
        return _keys([Curve(np.zeros(1), a.values, a.rates, a.rates) for a in rest], problem)
    paths = BranchPaths(problem)
    pieces, keys = _refined(paths, branches_of(trajectory))
    return _keys(_curves(paths, pieces, keys), problem)


def _refined(paths: BranchPaths, pieces: Branches) -> tuple[Branches, Marks]:
    """Bisect segments until cubics follow the motion along all of them.

    Returns:
        The segments in order of time, and for each the tracks of which its end is a key.
    """
    count = len(tracks(paths.model, pieces.x[:1], np.zeros_like(pieces.x[:1])))
    keys: Marks = np.ones((len(pieces), count), dtype=bool)
    asked, done = keys, []
    for left in reversed(range(12)):  # per segment
        far: Marks = asked & _leaves(paths, pieces) & (left > 0)
        stay: Marks = ~np.asarray(far.any(axis=1))
        done.append((pieces[stay], keys[stay]))
        if stay.all():
            break
        pieces, keys, far = pieces[~stay], keys[~stay], far[~stay]
        pieces = halved(pieces, paths.state(pieces, 0.5))
        keys, asked = np.concatenate([far, keys]), np.concatenate([far, far])
    whole, marks = (np.concatenate(parts) for parts in zip(*done, strict=True))
    order = np.argsort(whole["begin"], kind="stable")
    return whole.view(np.recarray)[order], marks[order]


def _leaves(paths: BranchPaths, pieces: Branches) -> Marks:
    """Return where a cubic is too far from the motion, or turns too far.

    Shape (segments, tracks).
    """
    begins, ends = _both_ends(paths, pieces)
    far = np.zeros((len(pieces), len(begins)), dtype=bool)
    step = (pieces.end - pieces.begin)[:, None]
    for fraction in (0.25, 0.5):  # of a segment, where curve and motion are compared
        x = paths.state(pieces, fraction)
        middles = tracks(paths.model, x, np.zeros_like(x))
        for k, (a, end, middle) in enumerate(zip(begins, ends, middles, strict=True)):
            b = end.toward(a)
            curve = hermite(a.values, a.rates, b.values, b.rates, step, np.array(fraction))
            # 2e-5 [m], [rad] between curve and motion; a page guarantees five times as much
            far[:, k] |= middle.apart(curve) > 2e-5
            # 1.0 [rad] between two keys: a cubic of quaternions cannot count whole turns
            far[:, k] |= a.turning * step[:, 0] > 1.0
    return far


def _both_ends(paths: BranchPaths, pieces: Branches) -> tuple[list[Track], list[Track]]:
    out, into = paths.rates(pieces)
    return tracks(paths.model, pieces.x, out), tracks(paths.model, pieces.y, into)


def _curves(paths: BranchPaths, pieces: Branches, keys: Marks) -> list[Curve]:
    """Return a curve per track through the ends of consecutive segments that are its keys."""
    times = np.append(pieces.begin, pieces.end[-1])
    curves = []
    for k, (a, b) in enumerate(zip(*_both_ends(paths, pieces), strict=True)):
        values = np.concatenate([a.values, b.values[-1:]])
        arriving = np.concatenate([a.rates[:1], b.rates])
        leaving = np.concatenate([a.rates, b.rates[-1:]])
        used = np.concatenate([[True], keys[:, k]])
        curves.append(Curve(times[used], values[used], arriving[used], leaving[used]))
    return curves


def _keys(curves: list[Curve], problem: PlanningTask) -> Keys:
    bodies = len(problem.bodies)
    n = bodies + len(problem.machine.joints.names)
    places, turns = curves[:n], [continued(curve) for curve in curves[n : 2 * n]]
    ends = curves[2 * n] if len(curves) > 2 * n else None
    joints = Keys(places[bodies:], turns[bodies:])
    return Keys(places[:bodies], turns[:bodies], ends, joints)


def branches_of(trajectory: Trajectory) -> Branches:
    """Return the segments of a motion between its knots."""
    t, x, u = trajectory.t, trajectory.x, trajectory.u
    ends = [("begin", float), ("end", float), ("x", float, x.shape[1:]), ("y", float, x.shape[1:])]
    pieces: Branches = np.recarray(len(u), dtype=[*ends, ("u", float, u.shape[1:])])
    pieces.begin, pieces.end, pieces.x, pieces.y, pieces.u = t[:-1], t[1:], x[:-1], x[1:], u
    return pieces


def halved(pieces: Branches, middle: Array) -> Branches:
    """Return all first halves, then all second ones; ``middle`` (n, nx) joins them."""
    first, second = pieces.copy(), pieces.copy()
    first.end = second.begin = 0.5 * (pieces.begin + pieces.end)
    first.y = second.x = middle
    return np.concatenate([first, second]).view(np.recarray)


class BranchPaths:
    """States of a machine along segments of its motion, according to [integration]."""

    def __init__(self, problem: PlanningTask) -> None:
        self.model, settings = problem.model.plant, problem.scenario.integration
        self._straight = settings.truth == "discrete"  # a discrete map is undefined between steps
        self._method = settings.accurate_method

    def state(self, pieces: Branches, fraction: float) -> Array:
        """Return the states at a fraction of each segment, shape (n, nx)."""
        if self._straight:
            return self.model.space.unit(pieces.x + fraction * (pieces.y - pieces.x))
        spans = fraction * (pieces.end - pieces.begin)
        # 8 steps of the integrator per segment, or part of one
        return self.model.step(pieces.x, pieces.u, spans, method=self._method, substeps=8)

    def rates(self, pieces: Branches) -> tuple[Array, Array]:
        """Return the state rates at the beginning and at the end, shape (n, nx) each."""
        if self._straight:
            slope = (pieces.y - pieces.x) / (pieces.end - pieces.begin)[:, None]
            return slope, slope
        return self.model.f(pieces.x, pieces.u), self.model.f(pieces.y, pieces.u)

"""Goal states whose body axes point along their targets, by minimal rotation of attitudes."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics import Model
from kinolab.numerics.arrays import Array
from kinolab.problem.goal import DirectionTarget, Goal


def pointed(model: Model, goal: Goal, x: Array) -> Array:
    """Return states (n, nx) with attitudes rotated so that axes point along their targets.

    Attitudes with a target of their own are kept. Where rotating an attitude brings no axis nearer
    to its target, as for a hinged body, the state is unchanged.
    """
    taken = {one.part for one in goal.parts}
    free = [part.own for part in model.space.rotations if part not in taken]
    for target in goal.directions:
        for own in free:
            x = _turned(model, target, x, own)
    return x


def _turned(model: Model, target: DirectionTarget, x: Array, own: slice) -> Array:
    before, wanted = target.in_world(model.frames(x)), np.asarray(target.target)
    turned = x.copy()
    turned[:, own] = _product(_least_turn(before, wanted), x[:, own])
    nearer = target.in_world(model.frames(turned)) @ wanted > before @ wanted
    return np.where(nearer[:, None], turned, x)


def _least_turn(begin: Array, end: Array) -> Array:
    """Return the quaternions (n, 4) of minimal rotations from unit vectors (n, 3) to one (3,)."""
    cosine = begin @ end
    aside = np.cross(begin, np.eye(3)[np.abs(begin).argmin(axis=1)])
    opposite = (1.0 + cosine < 1e-9)[:, None]  # below, any perpendicular rotation axis will do
    vector = np.where(opposite, aside, np.cross(begin, end))
    scalar = np.where(opposite, 0.0, (1.0 + cosine)[:, None])
    turn = np.hstack([vector, scalar])
    quaternions: Array = turn / np.linalg.norm(turn, axis=1, keepdims=True)
    return quaternions


def _product(a: Array, b: Array) -> Array:
    """Return the attitudes b (n, 4) rotated by a (n, 4), in world axes: the product a b."""
    v, w, s, t = a[:, :3], b[:, :3], a[:, 3:], b[:, 3:]
    scalar = s * t - (v * w).sum(axis=1, keepdims=True)
    return np.hstack([s * w + t * v + np.cross(v, w), scalar])

"""Where bodies are in a tube, and how far from where the nominal motion has them.

Along the straight line from a nominal state to another one, poses change by at most their
derivative along it. A shape that is symmetric about an axis is carried by its centre and the axis
alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.language.shapes import Shape
from kinolab.dynamics.model.flow_formulas import along
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.interval_matrices import hull
from kinolab.numerics.interval_analysis.zonotopes import SUMS
from kinolab.numerics.intervals import IntervalArray
from kinolab.problem import PlanningTask
from kinolab.verification.tube.nominal_steps import BOXES
from kinolab.verification.tube.reachability import Reachability, Tube
from kinolab.world.shapes.geometry import core_radius_of, placement, triangles


@dataclass(frozen=True, eq=False)
class TubePoses:
    """Poses over a tube, in BOXES equal parts of each of its steps.

    Attributes:
        states: Boxes of all states, shape (nx, steps, BOXES).
        off: Boxes of their deviations from nominal ones, of the same shape.
        frames: Rows of [R | p] over the boxes, shape (bodies, 12, steps, BOXES).
        change: Of these, by the deviations, of the same shape.
        cables: By how much the ends of cables are off at most in [m], shape (steps,).
    """

    states: IntervalArray
    off: IntervalArray
    frames: IntervalArray
    change: IntervalArray
    cables: Array

    @classmethod
    def of(cls, problem: PlanningTask, about: Reachability, tube: Tube, p: Array) -> TubePoses:
        """Enclose the poses in a tube.

        Args:
            about: What is known of the nominal motion.
            tube: Deviations from it.
            p: By how much parameters are off at most, shape (parameters,).
        """
        model, n = (problem.whole or problem.model).plant, tube.steps
        bounds, boxes = tube.bounds, about.boxes
        low = (bounds.low[:-1] - tube.during).T[:, :, None]
        high = (bounds.high[:-1] + tube.during).T[:, :, None]
        shape = len(low), n, BOXES
        off = IntervalArray(*(np.broadcast_to(end, shape) for end in (low, high)))
        nominal = (np.swapaxes(end[..., :n], 1, 2) for end in (boxes.low, boxes.high))
        states = intervals.add(IntervalArray(*nominal), hull(off, intervals.point(np.zeros(shape))))
        (mode,) = model.formulas
        u = np.zeros((model.nu, n * BOXES))
        parameters = np.repeat(model.parameter_vector()[:, None], n * BOXES, axis=1)
        spread = np.repeat(p[:, None], n * BOXES, axis=1)
        around = _entries(states, (u, parameters - spread), (u, parameters + spread))
        change = _entries(off, (u, -spread), (u, spread))
        with np.errstate(all="ignore"):
            names = (*mode.state, *mode.inputs, *mode.parameters)
            frames, moved = along(mode.frames, names, [around, change])
            _, ends = along(about.flow.cables, about.flow.names, [around, change])
        each = (-1, 12, n, BOXES)
        apart = np.linalg.norm(_shaped(ends, (-1, 3, n, BOXES)).magnitude, axis=1)
        cables = apart.max(axis=(0, 2), initial=0.0) * (1.0 + SUMS)
        return cls(states, off, _shaped(frames, each), _shaped(moved, each), cables)

    def displacements(self, problem: PlanningTask) -> Array:
        """Return how far points are from their nominal places at most, (bodies + 1, steps).

        In [m], of each body, and last of cables; points of shapes that turn about their own axes
        do not count as moved by that.
        """
        farthest = np.zeros((len(problem.bodies) + 1, len(self.cables)))
        farthest[-1] = self.cables
        for body, geometry in enumerate(problem.bodies):
            own = IntervalArray(self.change.low[body], self.change.high[body])
            for shape in geometry.shapes:
                farthest[body] = np.maximum(farthest[body], _displaced(shape, own).max(axis=-1))
        return farthest


def _entries(
    states: IntervalArray, low: tuple[Array, Array], high: tuple[Array, Array]
) -> IntervalArray:
    """Return boxes of states, inputs and parameters, a column for each part of each step."""
    lows = np.concatenate([states.low.reshape(len(states.low), -1), *low])
    return IntervalArray(lows, np.concatenate([states.high.reshape(len(states.high), -1), *high]))


def _shaped(a: IntervalArray, shape: tuple[int, ...]) -> IntervalArray:
    return IntervalArray(a.low.reshape(shape), a.high.reshape(shape))


def _displaced(shape: Shape, change: IntervalArray) -> Array:
    """Return how far points of a shape are displaced at most, shape (steps, BOXES).

    Args:
        shape: In its body's frame.
        change: Of the body's rows of [R | p], shape (12, steps, BOXES).
    """
    own = placement(shape)
    if shape.symmetric:
        centre = moved_by(change, own[:, 3], 1.0)
        turned = 0.0 if shape.symmetric == "xyz" else moved_by(change, own[:, 2], 0.0)
        return np.asarray(centre + core_radius_of(shape) * turned)
    corners = triangles(shape)[0]
    return np.asarray(np.max([moved_by(change, corner, 1.0) for corner in corners], axis=0))


def moved_by(change: IntervalArray, point: Array, placed: float) -> Array:
    """Return how far a point (3,) is moved at most, or, not placed, a vector is turned."""
    entries = _shaped(change, (3, 4, *change.low.shape[1:]))
    weights = np.append(point, placed)[:, None, None]
    ends = weights * entries.low, weights * entries.high
    low, high = np.minimum(*ends).sum(axis=1), np.maximum(*ends).sum(axis=1)
    size = np.maximum(np.abs(low), np.abs(high)) + SUMS * np.maximum(*map(np.abs, ends)).sum(axis=1)
    return np.asarray(np.sqrt((size**2).sum(axis=0)) * (1.0 + SUMS))

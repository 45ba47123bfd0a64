"""The tube: zonotopes that contain the deviations of all motions, step by step.

Many steps are enclosed at once, over boxes that are guessed; a step is proved once the set that
comes out of the one before it lies in its guess. The next guess is made of what came out.

Source: Althoff, Stursberg, Buss, Reachability analysis of nonlinear systems with uncertain
parameters using conservative linearization, CDC 2008.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinolab.dynamics.model.flow_formulas import FlowFormulas
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.interval_matrices import middle, radius
from kinolab.numerics.interval_analysis.zonotopes import SUMS, Zonotope
from kinolab.numerics.intervals import IntervalArray
from kinolab.verification.tube.deviations import Bending, bendings
from kinolab.verification.tube.held_feedback import HeldFeedback, HeldInputs
from kinolab.verification.tube.nominal_steps import BOXES, NominalSteps, nominal_steps

# Equal parts of each step, of which each is enclosed by itself: what is not linear in a step is of
# the second order in its length
PARTS = 4


@dataclass(frozen=True, eq=False)
class NominalMotion:
    """What a tube is about.

    Attributes:
        t: Times of the knots in [s], shape (N+1,).
        x: States at the knots, shape (N+1, nx).
        u: Inputs held between them, shape (N, nu).
        p: Parameters, shape (parameters,).
        inner: States where parts of steps begin, shape (N, PARTS, nx).
    """

    t: Array
    x: Array
    u: Array
    p: Array
    inner: Array

    @cached_property
    def parts(self) -> NominalMotion:
        """The same motion, each part of a step for a step."""
        N, nx = len(self.u), self.x.shape[1]
        share = np.arange(PARTS) / PARTS
        t = self.t[:-1, None] + np.diff(self.t)[:, None] * share
        x = np.vstack([self.inner.reshape(N * PARTS, nx), self.x[-1:]])
        each = np.repeat(self.u, PARTS, axis=0)
        return NominalMotion(np.append(t, self.t[-1]), x, each, self.p, self.inner)

    @cached_property
    def entries(self) -> Array:
        """States, inputs and parameters at the beginning of each step, shape (entries, N)."""
        each = np.repeat(self.p[:, None], len(self.u), axis=1)
        return np.vstack([self.x[:-1].T, self.u.T, each])


@dataclass(frozen=True, eq=False)
class Tube:
    """What is proved of all motions.

    Attributes:
        nominal: The motion in its middle.
        sets: Deviations from it at the knots, as far as they are proved, length steps + 1.
        inputs: Deviations of the inputs in each step, length steps.
        during: By how much the deviations in a step differ from those at its beginning at most,
            shape (steps, nx).
    """

    nominal: NominalMotion
    sets: list[Zonotope]
    inputs: list[HeldInputs]
    during: Array

    @property
    def steps(self) -> int:
        """Of how many steps it is proved."""
        return len(self.inputs)

    @property
    def complete(self) -> bool:
        """Whether it is proved to the end."""
        return self.steps == len(self.nominal.u)

    @property
    def proved_until(self) -> float:
        """Until when it is proved, in [s]."""
        return float(self.nominal.t[self.steps])

    @property
    def bounds(self) -> IntervalArray:
        """Boxes of deviations at the knots, shape (steps + 1, nx)."""
        boxes = [one.bounds for one in self.sets]
        return IntervalArray(np.array([b.low for b in boxes]), np.array([b.high for b in boxes]))


class Reachability:
    """Encloses the motions about one nominal motion, under any uncertainty.

    Args:
        flow: The equations of motion.
        nominal: The motion in the middle.
        scales: Of states, by which generators are compared, shape (nx,).
    """

    def __init__(self, flow: FlowFormulas, nominal: NominalMotion, scales: Array) -> None:
        self.flow, self.nominal, self.scales = flow, nominal, scales
        parts = nominal.parts
        self.h = np.repeat(np.diff(nominal.t) / PARTS, PARTS)
        self.parts = nominal_steps(flow, parts.entries, self.h, scales)
        self.linear = _linear(self.parts, parts)

    @cached_property
    def boxes(self) -> IntervalArray:
        """What contains the nominal motion in BOXES equal parts of each step, (nx, BOXES, N)."""
        shape = (len(self.scales), BOXES, len(self.nominal.u), PARTS)
        low, high = (np.moveaxis(end.reshape(shape), 3, 1) for end in self._ends)
        shape = (shape[0], BOXES, PARTS, shape[2])
        return IntervalArray(low.reshape(shape).min(axis=2), high.reshape(shape).max(axis=2))

    @property
    def _ends(self) -> tuple[Array, Array]:
        return self.parts.boxes.low, self.parts.boxes.high

    def tube(self, feedback: list[HeldFeedback], p: Array) -> Tube:
        """Enclose all motions from the nominal start.

        Args:
            feedback: Of each step.
            p: By how much parameters are off at most, shape (parameters,).
        """
        return _Propagation(self, feedback, p).tube()

    def linear_tube(self, feedback: list[HeldFeedback], p: Array) -> Tube:
        """Return what is linear in deviations alone, as ``tube``; it contains nothing for sure."""
        return _Propagation(self, feedback, p).linear()


def _linear(steps: NominalSteps, nominal: NominalMotion) -> list[tuple[Array, Array, Array]]:
    """Return of each step the defects' ends, the slopes, and how far these may be off."""
    at = middle(steps.slopes)
    off, after = radius(steps.slopes, at), nominal.x[1:].T
    low, high = steps.ends.low - after, steps.ends.high - after
    count = after.shape[1]
    return [(np.array([low[:, k], high[:, k]]), at[..., k], off[..., k]) for k in range(count)]


@dataclass(frozen=True, eq=False)
class _Passed:
    """What is known of the deviations in one step.

    Attributes:
        before: At the beginning of each part, of states and inputs, length PARTS.
        after: Of states after the step.
        moved: By how much those in each part differ from those at its beginning, (PARTS, nx).
    """

    before: list[Zonotope]
    after: Zonotope
    moved: Array

    def during(self, nx: int) -> Array:
        """Return by how much deviations differ from those at the step's beginning, (nx,)."""
        boxes = [one.bounds for one in self.before]
        low = np.array([b.low[:nx] for b in boxes]) - self.moved
        high = np.array([b.high[:nx] for b in boxes]) + self.moved
        first = boxes[0]
        beyond = np.maximum(high.max(axis=0) - first.high[:nx], first.low[:nx] - low.min(axis=0))
        return np.asarray(np.maximum(beyond, 0.0) * (1.0 + SUMS))


class _Propagation:
    """One tube, while it is made."""

    def __init__(self, about: Reachability, feedback: list[HeldFeedback], p: Array) -> None:
        self.about, self.feedback, self.p = about, feedback, p
        self.varied = np.flatnonzero(p)
        self.count, self.nx = len(about.nominal.u), about.nominal.x.shape[1]
        self.nu = about.nominal.u.shape[1]
        entries = (np.arange(self.nx + self.nu), self.nx + self.nu + self.varied)
        self.entries = np.concatenate(entries)
        # what is known of the parts by now
        self.bends: list[Bending | None] = [None] * (PARTS * self.count)

    def tube(self) -> Tube:
        """Enclose windows of steps until the end, or as far as bounds are found."""
        start = np.zeros(self.nx)
        sets, inputs = [Zonotope.box(start, start, len(self.varied))], list[HeldInputs]()
        during, still = list[Array](), 0
        # rounds of enclosures by which no step more is proved, before it ends
        while len(inputs) < self.count and still < 3:
            first = len(inputs)
            guess = self._guess(sets[-1], first)
            if not guess.low.shape[1]:
                break
            self._bound(guess, first)
            self._append(sets, inputs, during, guess)
            still = 0 if len(inputs) > first else still + 1
            if self.bends[PARTS * first] is None:
                break  # the set at its beginning is known: another guess would not help
        return Tube(self.about.nominal, sets, inputs, np.reshape(during, (-1, self.nx)))

    def linear(self) -> Tube:
        """Return all steps by what is linear in them."""
        start = np.zeros(self.nx)
        sets, inputs = [Zonotope.box(start, start, len(self.varied))], list[HeldInputs]()
        during: list[Array] = []
        for k in range(self.count):
            inputs.append(self.feedback[k].over(sets[-1]))
            passed = self._through(k, sets[-1], inputs[-1])
            sets.append(passed.after)
            during.append(passed.during(self.nx))
        return Tube(self.about.nominal, sets, inputs, np.reshape(during, (-1, self.nx)))

    def _guess(self, start: Zonotope, first: int) -> IntervalArray:
        """Return boxes of all deviations in parts of the steps of a window, by what is known."""
        low, high, y = [], [], start
        for k in range(first, min(first + 16, self.count)):  # steps that are enclosed at once
            held = self.feedback[k].over(y)
            passed = self._through(k, y, held)
            bounds = [self._box(part, held) for part in passed.before]
            if not all(np.isfinite([b.low, b.high]).all() for b in bounds):
                break  # as far as anything is known
            low += [np.concatenate([b.low, -self.p]) for b in bounds]
            high += [np.concatenate([b.high, self.p]) for b in bounds]
            y = passed.after
        shape = self.nx + self.nu + len(self.p), len(low)
        lows, highs = np.reshape(low, shape[::-1]).T, np.reshape(high, shape[::-1]).T
        # factor on what comes out, for the next guess
        room = (1.1 - 1.0) * (highs - lows) + 1e-12 * np.abs(lows) + 1e-15
        room[:, :1], room[self.nx + self.nu :] = 0.0, 0.0  # these are known
        return IntervalArray(lows - room, highs + room)

    def _box(self, part: Zonotope, held: HeldInputs) -> IntervalArray:
        """Return bounds of states and inputs in a part of a step."""
        bounds = part.bounds
        low = np.concatenate([bounds.low[: self.nx], held.low])
        return IntervalArray(low, np.concatenate([bounds.high[: self.nx], held.high]))

    def _bound(self, guess: IntervalArray, first: int) -> None:
        """Enclose the parts of a window's steps over guessed boxes."""
        some = slice(PARTS * first, PARTS * first + guess.low.shape[1])
        held, boxes = self.about.nominal.parts.entries[self.nx :, some], self.about.parts.boxes
        around = IntervalArray(boxes.low[..., some], boxes.high[..., some])
        self.bends[some] = bendings(
            self.about.flow, around, held, guess, self.about.h[some], self.entries
        )

    def _append(
        self,
        sets: list[Zonotope],
        inputs: list[HeldInputs],
        during: list[Array],
        guess: IntervalArray,
    ) -> None:
        """Add the steps of a window that are proved."""
        n = self.nx + self.nu
        for i in range(0, guess.low.shape[1], PARTS):
            k, y = len(inputs), sets[-1]
            held = self.feedback[k].over(y)
            passed = self._through(k, y, held)
            boxes = [self._box(part, held) for part in passed.before]
            low, high = np.array([b.low for b in boxes]).T, np.array([b.high for b in boxes]).T
            some = slice(i, i + PARTS)
            inside = (guess.low[:n, some] <= low) & (high <= guess.high[:n, some])
            known = None not in self.bends[PARTS * k : PARTS * (k + 1)]
            if not (inside.all() and known and np.isfinite(passed.after.magnitude).all()):
                return
            inputs.append(held)
            sets.append(passed.after)
            during.append(passed.during(self.nx))

    def _through(self, k: int, y: Zonotope, held: HeldInputs) -> _Passed:
        """Return what becomes of deviations in a step, as far as anything is known of it."""
        new, more = np.zeros((self.nx, held.steps.shape[1])), np.zeros((self.nx + self.nu, self.nx))
        follow = np.vstack([y.free, -held.gain @ y.free])
        joint = Zonotope(
            np.concatenate([y.centre, held.centre - held.gain @ y.centre]),
            np.vstack([y.lasting, -held.gain @ y.lasting]),
            np.hstack([follow, np.vstack([new, held.steps]), more]),
        )
        rounding = SUMS * (np.abs(held.gain) @ y.magnitude + np.abs(held.centre))
        before, moved = list[Zonotope](), list[Array]()
        for part in range(PARTS * k, PARTS * (k + 1)):
            before.append(joint)
            joint, far = self._after(part, joint, held, rounding)
            moved.append(far)
        after = Zonotope(joint.centre[: self.nx], joint.lasting[: self.nx], joint.free[: self.nx])
        # times nx: that are kept beside those of parameters
        after = after.reduced(12 * self.nx, self.about.scales)
        return _Passed(before, after, np.array(moved))

    def _after(
        self, part: int, joint: Zonotope, held: HeldInputs, rounding: Array
    ) -> tuple[Zonotope, Array]:
        """Return the deviations of states and inputs after a part, and how far states move in it.

        Args:
            joint: The deviations at its beginning; the last nx generators are a box of states.
            rounding: By how much inputs are off in ``joint`` at most, shape (nu,).
        """
        (least, most), slopes, off = self.about.linear[part]
        nx, nu, p = self.nx, self.nu, self.p[self.varied]
        by_y, by_p = slopes[:, : nx + nu], slopes[:, nx + nu + self.varied]
        sizes = np.concatenate([joint.magnitude[:nx], np.maximum(-held.low, held.high), self.p])
        bent, further, moved = self._bent(part, joint, sizes[self.entries])
        sums = np.abs(slopes) @ sizes + np.abs(self.about.nominal.parts.x[part + 1])
        sums = sums + np.abs(least) + np.abs(most) + np.abs(bent) + further
        apart = 0.5 * (most - least) + further + np.abs(slopes[:, nx : nx + nu]) @ rounding
        rest = (off @ sizes + apart) * (1.0 + SUMS) + 2.0 * SUMS * sums
        before = np.abs(joint.free[:nx, -nx:]).sum(axis=1)  # a box of what is not linear
        with np.errstate(invalid="ignore"):
            rest = rest + np.abs(slopes[:, :nx]) @ before * (1.0 + SUMS)
            centre = by_y @ joint.centre + 0.5 * (least + most) + bent
            free = np.hstack([by_y @ joint.free[:, :-nx], np.diag(rest)])
        after = Zonotope(
            np.concatenate([centre, joint.centre[nx:]]),
            np.vstack([by_y @ joint.lasting + by_p * p, joint.lasting[nx:]]),
            np.vstack([free, joint.free[nx:]]),
        )
        return after, moved

    def _bent(self, part: int, joint: Zonotope, sizes: Array) -> tuple[Array, Array, Array]:
        """Return what is not linear in a part, a centre and radii, and how far states move in it.

        As far as anything is known of it; each of shape (nx,).
        """
        known, p = self.bends[part], self.p[self.varied]
        if known is None:
            return np.zeros(self.nx), np.zeros(self.nx), np.zeros(self.nx)
        middle = np.concatenate([joint.centre, 0.0 * p])
        lasting = np.hstack([np.diag(p), np.zeros((len(p), joint.free.shape[1]))])
        generators = np.vstack([joint.generators, lasting])
        with np.errstate(all="ignore"):
            bent, further = known.remainder(middle, generators, sizes)
        return bent, further, known.moved(sizes)

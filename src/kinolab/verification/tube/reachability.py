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

from kinolab.dynamics.flow_formulas import FlowFormulas
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.interval_matrices import middle, radius
from kinolab.numerics.interval_analysis.zonotopes import SUMS, Zonotope
from kinolab.numerics.intervals import IntervalArray
from kinolab.verification.tube.deviations import DeviationBounds, deviation_bounds
from kinolab.verification.tube.held_feedback import HeldFeedback, HeldInputs
from kinolab.verification.tube.nominal_steps import NominalSteps, nominal_steps

WINDOW = 128  # steps that are enclosed at once
GENERATORS = 12  # times nx: that are kept beside those of parameters
ROUNDS = 4  # of enclosures for each window, on average; deviations that need more run away
ROOM = 1.1  # factor on what comes out, for the next guess


@dataclass(frozen=True, eq=False)
class NominalMotion:
    """What a tube is about.

    Attributes:
        t: Times of the knots in [s], shape (N+1,).
        x: States at the knots, shape (N+1, nx).
        u: Inputs held between them, shape (N, nu).
        p: Parameters, shape (parameters,).
    """

    t: Array
    x: Array
    u: Array
    p: Array

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
        self.h = np.diff(nominal.t)
        self.steps = nominal_steps(flow, nominal.entries, self.h, scales)
        self.linear = _linear(self.steps, nominal)

    def tube(self, feedback: list[HeldFeedback], p: Array) -> Tube:
        """Enclose all motions from the nominal start.

        Args:
            feedback: Of each step.
            p: By how much parameters are off at most, shape (parameters,).
        """
        return _Propagation(self, feedback, p).tube()


def _linear(steps: NominalSteps, nominal: NominalMotion) -> list[tuple[Array, Array, Array]]:
    """Return of each step the defects' ends, the slopes, and how far these may be off."""
    at = middle(steps.slopes)
    off, after = radius(steps.slopes, at), nominal.x[1:].T
    low, high = steps.ends.low - after, steps.ends.high - after
    count = after.shape[1]
    return [(np.array([low[:, k], high[:, k]]), at[..., k], off[..., k]) for k in range(count)]


class _Propagation:
    """One tube, while it is made."""

    def __init__(self, about: Reachability, feedback: list[HeldFeedback], p: Array) -> None:
        self.about, self.feedback, self.p = about, feedback, p
        self.varied = np.flatnonzero(p)
        self.count, self.nx = len(about.nominal.u), about.nominal.x.shape[1]
        self.nu = about.nominal.u.shape[1]
        still = np.zeros((self.nx, self.count))
        self.remainder = IntervalArray(still, still.copy())  # what is known of it by now

    def tube(self) -> Tube:
        """Enclose windows of steps until the end, or as far as bounds are found."""
        start = np.zeros(self.nx)
        sets, inputs = [Zonotope.box(start, start, len(self.varied))], list[HeldInputs]()
        during = [np.zeros((0, self.nx))]
        for _ in range(ROUNDS * (self.count // WINDOW + 1)):
            if len(inputs) == self.count:
                break
            first = len(inputs)
            guess = self._guess(sets[-1], first)
            if not guess.low.shape[1]:
                break
            found = self._bounds(guess, first)
            self._append(sets, inputs, guess, found, first)
            during.append(found.moved[:, : len(inputs) - first].T)
            if len(inputs) == first:
                break  # the set at its beginning is known: another guess would not help
        return Tube(self.about.nominal, sets, inputs, np.concatenate(during))

    def _guess(self, start: Zonotope, first: int) -> IntervalArray:
        """Return boxes of all deviations in the steps of a window, by what is known of them."""
        low, high, y = [], [], start
        for k in range(first, min(first + WINDOW, self.count)):
            held, bounds = self.feedback[k].over(y), y.bounds
            if not np.isfinite([bounds.low, bounds.high]).all():
                break  # as far as anything is known
            low.append(np.concatenate([bounds.low, held.low, -self.p]))
            high.append(np.concatenate([bounds.high, held.high, self.p]))
            y = self._after(k, y, held)
        shape = self.nx + self.nu + len(self.p), len(low)
        lows, highs = np.reshape(low, shape[::-1]).T, np.reshape(high, shape[::-1]).T
        room = (ROOM - 1.0) * (highs - lows) + 1e-12 * np.abs(lows) + 1e-15
        room[:, :1], room[self.nx + self.nu :] = 0.0, 0.0  # these are known
        return IntervalArray(lows - room, highs + room)

    def _bounds(self, guess: IntervalArray, first: int) -> DeviationBounds:
        """Enclose the steps of a window over guessed boxes, and remember what came out."""
        some = slice(first, first + guess.low.shape[1])
        held, boxes = self.about.nominal.entries[self.nx :, some], self.about.steps.boxes
        around = IntervalArray(boxes.low[..., some], boxes.high[..., some])
        found = deviation_bounds(self.about.flow, around, held, guess, self.about.h[some])
        rows = first + np.flatnonzero(found.known)
        self.remainder.low[:, rows] = found.remainder.low[:, found.known]
        self.remainder.high[:, rows] = found.remainder.high[:, found.known]
        return found

    def _append(
        self,
        sets: list[Zonotope],
        inputs: list[HeldInputs],
        guess: IntervalArray,
        found: DeviationBounds,
        first: int,
    ) -> None:
        """Add the steps of a window that are proved."""
        n = self.nx + self.nu
        for i in range(guess.low.shape[1]):
            y = sets[-1]
            held, bounds = self.feedback[first + i].over(y), y.bounds
            low = np.concatenate([bounds.low, held.low])
            high = np.concatenate([bounds.high, held.high])
            inside = ((guess.low[:n, i] <= low) & (high <= guess.high[:n, i])).all()
            if not (inside and found.known[i]):
                return
            after = self._after(first + i, y, held)
            if not np.isfinite(after.magnitude).all():
                return
            inputs.append(held)
            sets.append(after)

    def _after(self, k: int, y: Zonotope, held: HeldInputs) -> Zonotope:
        """Return the deviations after a step from those before it."""
        ends, slopes, off = self.about.linear[k]
        nx, nu = self.nx, self.nu
        by_x, by_u, by_p = slopes[:, :nx], slopes[:, nx : nx + nu], slopes[:, nx + nu :]
        sizes = np.concatenate([y.magnitude, np.maximum(-held.low, held.high), self.p])
        least, most = ends[0] + self.remainder.low[:, k], ends[1] + self.remainder.high[:, k]
        with np.errstate(invalid="ignore"):  # where nothing is known
            centre, apart = 0.5 * (least + most), 0.5 * (most - least)
        feedback = np.abs(by_u) @ (np.abs(held.gain) @ y.magnitude + np.abs(held.centre))
        sums = np.abs(slopes) @ sizes + feedback + np.abs(self.about.nominal.x[k + 1])
        rest = (off @ sizes + apart) * (1.0 + SUMS) + SUMS * (sums + np.abs(least) + np.abs(most))
        moved = y.mapped(by_x - by_u @ held.gain)
        return moved.plus(
            centre + by_u @ held.centre,
            by_u @ held.steps,
            np.diag(rest),
            lasting=(by_p * self.p)[:, self.varied],
        ).reduced(GENERATORS * nx, self.about.scales)

"""Least-norm feasibility step: the smallest step in the trust region that removes all violation.

It solves the subproblem without time and effort weights at a fraction of the cost: an active set
fixes some variables at their limits and turns some inequalities into equations, so each active set
costs one block-banded least-squares problem.

Source: Hintermueller, Ito, Kunisch, The primal-dual active set strategy as a semismooth Newton
method, SIAM Journal on Optimization 13(3), 2002.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.block_banded import BlockBandedSystem, transposed
from kinolab.numerics.work import charge
from kinolab.trajopt.nlp.decision import Scaling
from kinolab.trajopt.nlp.linearization import Linearization
from kinolab.trajopt.nlp.options import SQP
from kinolab.trajopt.nlp.path_constraints import LinearInequalities
from kinolab.trajopt.sqp.subproblem import Step, Subproblem

Flags: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class ActiveSet:
    """Variables fixed at one of their limits, and inequalities treated as equations."""

    low: Flags  # (N+1, nx + nu)
    high: Flags
    rows: Flags  # (m,)
    held: Flags  # (P,), step lengths that are fixed
    step: Array  # (P,), their change; 0 of those that are free


@dataclass(frozen=True, eq=False)
class LeastNormSolution:
    """Least-norm step for one active set."""

    z: Array  # (N+1, nx + nu)
    h: Array
    pulled: Array  # variables implied by the multipliers if all were free, (N+1, nx + nu)
    pulled_step: Array  # likewise the step lengths
    pushes: Array  # multipliers of inequalities, (m,), 0 for inactive ones


def feasibility_step(given: Subproblem) -> Step | None:
    """Return the least-norm step in the trust region to zero violation; None if there is none.

    Args:
        given: The subproblem; its time and effort weights must be zero.
    """
    program = _Program(given)
    guess = program.first()
    for count in range(SQP.max_active_sets):
        charge(3e-4 + 1e-7 * program.size)
        found = program.solved(guess)
        if found is None:
            return None
        following = program.next(guess, found, free=count < SQP.releasing_active_sets)
        if following is None:
            return _change(given, found)
        guess = following
    return None


class _Program:
    def __init__(self, given: Subproblem) -> None:
        linearization, limits = given.linearization, given.region
        inputs = np.pad(limits.u, ((0, 0), (0, 1), (0, 0)))  # the last knot has none
        self._least, self._most = np.concatenate([limits.x, inputs], axis=2)
        self._step = limits.h
        self._w = np.where(self._most > self._least, 1.0, 0.0)
        self._w[:, linearization.knots.x.shape[1] :] *= (
            linearization.knots.u.size / linearization.knots.x.size
        )
        self._equations = _equations(linearization, given.scaling)
        self._broken = given.rows.value < 0
        self.size = self._w.size * self._w.shape[1]  # which tells how long a solution takes
        self._margins = _margins(given.rows, given.scaling, self._step.shape[1])

    def first(self) -> ActiveSet:
        none = np.zeros(self._w.shape, dtype=bool)
        fixed = self._step[0] == self._step[1]
        return ActiveSet(none, none, self._broken, fixed, np.where(fixed, self._step[0], 0.0))

    def solved(self, guess: ActiveSet) -> LeastNormSolution | None:
        chain, place = self._equations.joined(self._margins, guess.rows)
        z = np.where(guess.low, self._least, np.where(guess.high, self._most, 0.0))
        w = np.where(guess.low | guess.high, 0.0, self._w)
        w_h = np.where(guess.held, 0.0, 1 / SQP.step_length_weight)
        closed = chain.closed(z, guess.step, w, w_h)
        if closed is None:
            return None
        z, h, by = closed
        pushes = np.zeros(len(guess.rows))
        pushes[guess.rows] = by[place]
        pulled = self._w * transposed(chain.knot, chain.rows, by, *z.shape)
        pulled_step = chain.shared.T @ by / SQP.step_length_weight
        return LeastNormSolution(z, h, pulled, pulled_step, pushes)

    def next(self, guess: ActiveSet, found: LeastNormSolution, *, free: bool) -> ActiveSet | None:
        """Return the next active set; None if the solution is feasible."""
        step, z = found.h, found.z
        shortest, longest = self._step
        over = ~guess.held & ~((shortest <= step) & (step <= longest))
        broken = ~guess.rows & (
            self._margins.residual(z, np.zeros_like(step)) > SQP.inequality_tolerance
        )
        low, high = z < self._least - SQP.bound_tolerance, z > self._most + SQP.bound_tolerance
        if not (over.any() or broken.any() or low.any() or high.any()):
            return None
        held = over | guess.held
        if not free:
            step = np.where(over, np.clip(step, shortest, longest), guess.step)
            return ActiveSet(low | guess.low, high | guess.high, broken | guess.rows, held, step)
        low = found.pulled < self._least - SQP.bound_tolerance
        high = found.pulled > self._most + SQP.bound_tolerance
        at, pulled = guess.step, found.pulled_step  # fixed lengths may be pulled back inside
        inside = ((at < longest) & (pulled > at)) | ((at > shortest) & (pulled < at))
        held &= ~(guess.held & inside)
        step = np.where(held, np.where(over, np.clip(step, shortest, longest), at), 0.0)
        return ActiveSet(low, high, broken | (guess.rows & (found.pushes > 0)), held, step)


def _equations(linearization: Linearization, scaling: Scaling) -> BlockBandedSystem:
    """Return the linearised dynamics and goal equations."""
    steps, nx = linearization.defects.shape
    nu, goals = len(scaling.u), len(linearization.goal_residual)
    large = np.concatenate([scaling.x, scaling.u])
    tangents = linearization.sensitivities / scaling.x[:, None]
    rows = np.zeros((steps * nx + goals, 2 * nx + nu))
    dynamics = rows[: steps * nx].reshape(steps, nx, -1)
    dynamics[:, :, : nx + nu] = -tangents[:, :, :-1] * large
    dynamics[:, range(nx), range(nx + nu, 2 * nx + nu)] = 1.0
    rows[steps * nx :, :nx] = linearization.goal_jacobian * scaling.x
    knot = np.concatenate([np.repeat(np.arange(steps), nx), np.full(goals, steps)])
    shared = np.zeros((len(rows), len(linearization.knots.lengths)))
    phase = np.repeat(linearization.knots.phase, nx)
    slopes = -tangents[:, :, -1].ravel() * linearization.knots.lengths[phase]
    shared[np.arange(steps * nx), phase] = slopes
    right = np.concatenate(
        [(linearization.defects / scaling.x).ravel(), -linearization.goal_residual]
    )
    return BlockBandedSystem(knot, rows, shared, right)


def _margins(rows: LinearInequalities, scaling: Scaling, phases: int) -> BlockBandedSystem:
    """Return all linearised inequalities as equations."""
    slopes = np.hstack([rows.dx * scaling.x, rows.du * scaling.u, rows.dx_next * scaling.x])
    none = np.zeros((len(rows.knot), phases))
    return BlockBandedSystem(rows.knot, slopes, none, -rows.value)


def _change(given: Subproblem, found: LeastNormSolution) -> Step:
    weights, nx = given.weights, given.linearization.knots.x.shape[1]
    x, u = found.z[:, :nx], found.z[:-1, nx:]
    price = weights.stay * (np.square(x).mean() + np.square(u).mean())
    predicted = weights.penalty * given.linearization.violation(given.scaling) - float(price)
    return given.step(x, u, found.h, predicted)

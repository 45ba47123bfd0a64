"""Linkage of phases: the guard of each transition and what its reset makes of the state.

A phase's first step begins ``transition_lag`` before the transition, under the inputs that are held
in it. So simulation finds the transition within that step, wherever rounding or a small error of
the start moves it, and the inputs before a transition are free of those after it.

Source: Betts, Practical Methods for Optimal Control and Estimation Using Nonlinear Programming, 2nd
ed., 2010, section 4.6.2 (multiple phases).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.trajopt.nlp.decision import ONE_PHASE, Knots
from kinolab.trajopt.nlp.options import NLP
from kinolab.trajopt.nlp.path_constraints import (
    LinearInequalities,
    central_differences,
    variable_scales,
)

# Margins of a transition from its guard, the rate of that and its condition: the guard is zero,
# falls, and the condition holds.
MARGINS = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]])


class Entries(NamedTuple):
    """How the steps of a motion begin, with derivatives where phases do.

    Attributes:
        x: States from which the steps are smooth, shape (N, nx).
        spans: How long they are from there, in [s], shape (N,).
        slopes: Of these states where phases begin, by states and inputs there, shape
            (P-1, nx, nx + nu).
        rows: That guards are zero there.
    """

    x: Array
    spans: Array
    slopes: Array
    rows: LinearInequalities


class Transitions:
    """Transitions between the phases of motions.

    Args:
        step: The map of a smooth step.
        reserve: By which conditions must hold and guards fall in [1/s], in their units.
    """

    def __init__(self, problem: PlanningTask, step: StepSensitivities, reserve: float) -> None:
        self._model, self._step = problem.model, step
        self._lag = NLP.transition_lag * problem.step
        self._reserves = np.array([0.0, 0.0, reserve, reserve])
        self._scales = np.concatenate(variable_scales(problem))

    def entered(self, knots: Knots) -> tuple[Array, Array]:
        """Return from which states the steps are smooth, and how long, (N, nx) and (N,)."""
        x, spans = knots.x[:-1], knots.lengths[knots.phase]
        if knots.phases is ONE_PHASE:
            return x, spans
        x, begins = x.copy(), knots.phases.begins
        for k, number, state in zip(begins, knots.phases.numbers, self._events(knots), strict=True):
            x[k] = self._model.after_transition(state, knots.u[k], number)
        spans[begins] -= self._lag
        return x, spans

    def violation(self, knots: Knots) -> float:
        """Return by how much guards are not zero where phases begin, and conditions do not hold."""
        return sum(
            float(np.maximum(-self._margins(state, knots.u[k], number), 0.0).sum())
            for k, number, state in zip(
                knots.phases.begins, knots.phases.numbers, self._events(knots), strict=True
            )
        )

    def linearized(self, knots: Knots) -> Entries:
        """Return how the steps begin, with derivatives."""
        x, spans = self.entered(knots)
        nx, begins, phases = x.shape[1], knots.phases.begins, knots.phases
        held = knots.u[begins]
        y, along = self._step.linearized(knots.x[begins], held, self._lag)
        wide = nx + held.shape[1]
        moved = np.zeros((len(begins), wide, wide))
        moved[:, :nx], moved[:, nx:, nx:] = along[:, :, :-1], np.eye(held.shape[1])
        value, slopes = (
            np.zeros((len(begins), len(MARGINS))),
            np.zeros((len(begins), len(MARGINS), wide)),
        )
        states = np.zeros((len(begins), nx, wide))
        for i, number in enumerate(phases.numbers):
            z = np.concatenate([y[i], held[i]])
            value[i] = self._margins(y[i], held[i], number)
            slopes[i] = self._slopes(partial(self._margins, number=number), z) @ moved[i]
            after = partial(self._model.after_transition, number=number)
            states[i] = self._slopes(after, z) @ moved[i]
        rows, knot = slopes.reshape(-1, wide), np.repeat(begins, len(MARGINS))
        none = np.zeros((len(knot), nx))
        guards = LinearInequalities(knot, value.ravel(), rows[:, :nx], none, rows[:, nx:])
        return Entries(x, spans, states, guards)

    def _events(self, knots: Knots) -> Array:
        """Return the states in which transitions take place, shape (P-1, nx)."""
        begins = knots.phases.begins
        return self._step.after(knots.x[begins], knots.u[begins], self._lag)

    def _margins(self, x: Array, u: Array, number: int) -> Array:
        """Return the margins of a transition at states (..., nx), shape (..., 4)."""
        guard = self._model.guards(x, u)[..., number - 1, :]
        return np.asarray(guard @ MARGINS.T - self._reserves)

    def _slopes(self, function: Callable[[Array, Array], Array], z: Array) -> Array:
        nx = self._model.nx
        rows = central_differences(lambda z: function(z[:, :nx], z[:, nx:]), z[None], self._scales)
        return np.asarray(rows[0])

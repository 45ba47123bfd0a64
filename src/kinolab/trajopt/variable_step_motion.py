"""A motion in steps of any length, from which pieces are cut and into which others are put."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import StateSpace
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.decision import Knots, resampled

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class VariableStepMotion:
    """States, the inputs held between them, and how long each is held.

    Attributes:
        x: States, shape (N+1, nx).
        u: Inputs, shape (N, nu): references where the machine has feedback.
        spans: Length of every step in [s], shape (N,).
    """

    x: Array
    u: Array
    spans: Array

    @property
    def duration(self) -> float:
        """Length in time, in [s]."""
        return float(self.spans.sum())

    @property
    def times(self) -> Array:
        """Times of the states in [s], shape (N+1,), from 0."""
        return np.concatenate([[0.0], np.cumsum(self.spans)])

    def piece(self, begin: int, end: int) -> VariableStepMotion:
        """Return the motion from one state to another, by their places."""
        own = slice(begin, end)
        return VariableStepMotion(self.x[begin : end + 1], self.u[own], self.spans[own])

    def with_piece(
        self, begin: int, end: int, other: VariableStepMotion, space: StateSpace
    ) -> VariableStepMotion:
        """Return the motion with a piece replaced by another one.

        What follows begins where that ends: entries of the state that may come out differently
        keep the difference, quaternions their sign.

        Args:
            begin: Place of the state with which the piece begins.
            end: Place of the state with which it ends.
            other: From the same state to the same one, as far as that matters.
            space: Of the states.
        """
        rest = space.carried(self.x[end:], other.x[-1])
        return VariableStepMotion(
            np.vstack([self.x[:begin], other.x[:-1], rest]),
            np.vstack([self.u[:begin], other.u, self.u[end:]]),
            np.concatenate([self.spans[:begin], other.spans, self.spans[end:]]),
        )

    def in_steps(self, count: int, space: StateSpace) -> Knots:
        """Return as many even steps of the same duration, by ``resampled``."""
        return resampled(self.times, self.x, self.u, count, space)


def variable_step_motion(trajectory: Trajectory) -> VariableStepMotion:
    """Return a trajectory as a course."""
    return VariableStepMotion(trajectory.x, trajectory.inputs, np.diff(trajectory.t))

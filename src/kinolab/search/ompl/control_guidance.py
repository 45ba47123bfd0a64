"""Control guidance: replaces the control that OMPL samples by one that leads somewhere better.

OMPL samples a control and its duration blindly, and Python cannot change that: the wheel's control
samplers cannot be subclassed, and the directed one, which compares several, cannot be constructed.
But the control passed to the propagator is no copy: what is written there is what OMPL keeps.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal import SEARCHED_FRACTION
from kinolab.search.ompl.goal_errors import GoalErrors
from kinolab.search.ompl.goal_region import GoalSamples
from kinolab.simulation import CandidateRollouts


class ControlGuide:
    """Chooses the input of every motion by lookahead, ignoring obstacles.

    Far from the goal, take the first candidate that violates no limit, or the one that does so
    last; OMPL's own comes first. Near the goal, with a given probability, take the one that leads
    nearest to a state of the goal region, up to its nearest approach. Motions end in the goal
    region.

    Args:
        control_samples: Maximum number of candidate inputs per motion.
        goal_bias: Probability of extending towards the goal from a state near it.
        min_steps: Minimum propagation steps of a motion.
        max_steps: Maximum propagation steps of a motion.
        goal_region_scale: What counts as near the goal, in its tolerances.
        seed: Random seed of the candidate inputs.
    """

    def __init__(
        self,
        problem: PlanningTask,
        samples: GoalSamples,
        *,
        control_samples: int = 32,
        goal_bias: float = 0.5,
        min_steps: int,
        max_steps: int,
        goal_region_scale: float,
        seed: int,
    ) -> None:
        horizon = min(max_steps, 50)  # maximum lookahead horizon
        self._rollouts = CandidateRollouts(problem, control_samples, horizon)
        self._shortest, self._horizon, self._longest = min(min_steps, horizon), horizon, max_steps
        # Goal points and axes of bodies would need the poses of every candidate state.
        self._goal_bias = 0.0 if problem.goal.needs_frames else goal_bias
        self._near, self._inside = (
            GoalErrors(problem, goal_region_scale),
            GoalErrors(problem, SEARCHED_FRACTION),
        )
        self._problem, self._samples = problem, samples
        self._low, self._high = problem.bounds.T
        lowest, highest = problem.model.control_bounds.T
        self._input_limits = lowest, highest
        self._generator = np.random.default_rng(seed)
        self._begin: list[float] = []
        self._here: list[float] = []
        self._held: list[float] = []
        self._stopped: list[float] = []
        self._steps = self._left = 0

    @property
    def propagations(self) -> int:
        """Steps simulated so far to compare inputs."""
        return self._rollouts.propagations

    def hold(self, state: list[float], drawn: list[float], control: Any) -> list[float]:
        """Return the input to apply from a state; for a new motion also write it to ``control``."""
        if state == self._here and drawn == self._held:
            return drawn
        self._begin, self._steps = state, 0
        self._held, self._left = self._choose(state, drawn)
        for i, value in enumerate(self._held):
            control[i] = value
        return self._held

    def ends(self) -> bool:
        """Say whether the motion must end."""
        self._stopped = []
        return self._left <= 0

    def reached(self, before: list[float], after: list[float], *, free: bool) -> None:
        """Record a step."""
        if not free:
            self._here, self._stopped = [], before
            return
        self._here, self._left, self._steps = after, self._left - 1, self._steps + 1
        if self._steps >= self._shortest and self._inside.fractions(after):
            self._left = 0

    def counted(self, state: list[float]) -> list[float]:
        """Return the state whose cell represents a state in the projection.

        A state stopped by an obstacle or a limit is counted where its motion began: it is hard to
        extend, and in a cell of its own it would be chosen again and again.
        """
        return self._begin if self.stopped(state) else state

    def stopped(self, state: list[float]) -> bool:
        """Say whether an obstacle or a limit stopped the last motion in a state."""
        return state == self._stopped

    def ended_in(self, state: list[float]) -> bool:
        """Say whether the last motion ended in a state, stopped or not."""
        return state in (self._here, self._stopped)

    def _choose(self, start: list[float], drawn: list[float]) -> tuple[list[float], int]:
        """Return the input of a motion and its maximum number of steps."""
        inputs = self._rollouts.inputs
        inputs[0] = drawn
        inputs[1:] = self._generator.uniform(*self._input_limits, size=inputs[1:].shape)
        if self._generator.uniform() < self._goal_bias and self._near.fractions(start):
            k, steps = self._nearest_to_goal(start)
        else:
            k, steps = self._lasting(start), self._longest
        held: list[float] = inputs[k].tolist()
        return held, steps

    def _lasting(self, start: Sequence[float]) -> int:
        """Return the first input that violates no limit, else the one that violates one last."""
        lasted = []
        for k in range(len(self._rollouts.inputs)):
            kept = self._keeps_limits(self._rollouts.follow(start, k))
            if kept.all():
                return k
            lasted.append(int(kept.argmin()))
        return int(np.argmax(lasted))

    def _nearest_to_goal(self, start: Sequence[float]) -> tuple[int, int]:
        """Return the input that leads nearest to a goal sample, and its number of steps."""
        for k in range(len(self._rollouts.inputs)):
            self._rollouts.follow(start, k)
        states = self._rollouts.states
        kept = np.logical_and.accumulate(self._keeps_limits(states), axis=1)
        distances = np.where(kept, self._distances(states, self._samples.draw()), np.inf)
        first = self._shortest - 1
        k, j = divmod(int(distances[:, first:].argmin()), self._horizon - first)
        return k, first + j + 1

    def _keeps_limits(self, states: Array) -> Any:
        return ((states >= self._low) & (states <= self._high)).all(axis=-1)

    def _distances(self, states: Array, target: list[float]) -> Array:
        """Return squared distances of states (..., nx) from a goal sample, in goal tolerances."""
        goal, aim = self._problem.goal, np.array(target)
        entries = list(goal.indices)
        with np.errstate(all="ignore"):  # diverged states are discarded afterwards
            apart = states[..., entries] - aim[entries]
            shares = np.where(goal.circular, wrapped(apart), apart) / goal.tolerances
            total: Array = (shares**2).sum(axis=-1)
            for one in goal.parts:
                own = one.part.own
                total += (one.part.distance(states[..., own], aim[own]) / one.tolerance) ** 2
        return total

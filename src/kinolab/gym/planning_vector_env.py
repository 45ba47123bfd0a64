"""Copies of a planning problem as a vector environment of Gymnasium."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from kinolab.gym.planning_env import action_space, observation_space, require_options
from kinolab.gym.step_batch import StepBatch
from kinolab.problem import PlanningTask

Rows = NDArray[np.float32]


class PlanningVectorEnv(VectorEnv[Rows, Rows, NDArray[Any]]):
    """Copies of a planning problem that one call steps; ``kinolab.gym.make`` returns it.

    A copy whose episode has ended is reset by the next step, which ignores its action.

    Attributes:
        problem: The problem.
    """

    def __init__(self, batch: StepBatch) -> None:
        self._batch, self.num_envs = batch, batch.count
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}
        self.single_observation_space = observation_space(batch)
        self.single_action_space = action_space(batch)
        self.observation_space = batch_space(self.single_observation_space, batch.count)
        self.action_space = batch_space(self.single_action_space, batch.count)
        self._ended = np.zeros(batch.count, dtype=np.bool_)

    @property
    def problem(self) -> PlanningTask:
        """The problem."""
        return self._batch.problem

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Rows, dict[str, Any]]:
        """Begin an episode of every copy; with a list of seeds the first one counts.

        ``options`` are those of a single environment: ``{"x": state}`` begins all at one state.
        """
        super().reset(seed=seed[0] if isinstance(seed, list) else seed)
        given = require_options(options)
        for k in range(self.num_envs):
            self._batch.reset(k, self.np_random, given.get("x"))
        self._ended[:] = False
        return self._batch.observations(), self._info(np.zeros(self.num_envs, dtype=np.bool_))

    def step(
        self, actions: Rows
    ) -> tuple[Rows, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Hold an action (nu,) of each copy, shape (n, nu), for a step of the scenario."""
        batch, anew = self._batch, self._ended.copy()
        outcome = batch.step(actions)
        for k in np.flatnonzero(anew):
            batch.reset(int(k), self.np_random)
        reached = outcome.reached & ~anew
        failed = np.array([bool(cause) for cause in outcome.failed]) & ~anew
        terminated = reached | failed
        truncated = batch.truncated & ~terminated
        self._ended = terminated | truncated
        reward = np.where(anew, 0.0, outcome.reward)
        return batch.observations(), reward, terminated, truncated, self._info(reached)

    def _info(self, reached: NDArray[np.bool_]) -> dict[str, Any]:
        return {"x": self._batch.x.copy(), "is_success": reached}

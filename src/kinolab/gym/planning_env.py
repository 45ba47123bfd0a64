"""A planning problem as an environment of Gymnasium."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from kinolab.arguments import require_numbers
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.gym.step_batch import StepBatch
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory

Observation = NDArray[np.float32]
Box32 = Box[np.float32]


def observation_space(batch: StepBatch) -> Box32:
    """Return the space of one copy's observations."""
    low, high = batch.observation_bounds.T.astype(np.float32)
    return Box(low, high, dtype=np.float32)


def require_options(options: dict[str, Any] | None) -> dict[str, Any]:
    """Return what ``reset`` is given, which may only be a state x.

    Raises:
        InputError: If it is something else.
    """
    if options is not None and not isinstance(options, dict):
        what = f"they are {options!r}."
        raise InputError([Mistake("reset options", what, 'Give {"x": state} or None.')])
    for name in options or {}:
        if name != "x":
            raise UnknownNameError("option", str(name), known=("x",), where="reset options")
    return options or {}


def action_space(batch: StepBatch) -> Box32:
    """Return the space of one copy's actions: inputs between their limits, as -1 to 1."""
    return Box(-1.0, 1.0, (batch.problem.model.nu,), np.float32)


class PlanningEnv(gymnasium.Env[Observation, NDArray[np.float32]]):
    """A planning problem as an environment; ``kinolab.gym.make`` returns it.

    ``info`` has ``x``, the state (nx,), ``t`` in [s], ``is_success``, and ``failed``: ``limit``,
    ``collision``, ``equations``, or nothing.

    Attributes:
        problem: The problem.
        observation_names: What the entries of an observation are; states are divided by
            ``problem.scales``.
    """

    def __init__(self, batch: StepBatch, render_mode: Literal["rgb_array"] | None = None) -> None:
        if render_mode not in (None, "rgb_array"):
            what, remedy = f"it is {render_mode!r}.", 'Give "rgb_array" or None.'
            raise InputError([Mistake("make render_mode", what, remedy)])
        self._batch, self.render_mode = batch, render_mode
        rate = round(1.0 / batch.problem.step)
        self.metadata = {"render_modes": ["rgb_array"], "render_fps": max(rate, 1)}
        self.observation_space = observation_space(batch)
        self.action_space = action_space(batch)

    @property
    def problem(self) -> PlanningTask:
        """The problem."""
        return self._batch.problem

    @property
    def observation_names(self) -> list[str]:
        """What the entries of an observation are."""
        return self._batch.observation_names

    def actions(self, motion: Trajectory) -> NDArray[np.float32]:
        """Return the actions (N, nu) that lead along a motion in steps of the scenario.

        Args:
            motion: Such as the trajectory of ``solve(optimize=False, improve=0)``.

        Raises:
            InputError: If it is another machine's, or has other steps.
        """
        return self._batch.actions(motion)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode.

        Args:
            options: ``{"x": state}`` begins at a state (nx,).

        Raises:
            InputError: If there is another option, or the state is not made of numbers.
        """
        super().reset(seed=seed)
        given = require_options(options)
        self._batch.reset(0, self.np_random, given.get("x"))
        return self._batch.observations()[0], self._info("", reached=False)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold an action (nu,) for a step of the scenario."""
        nu = self.problem.model.nu
        outcome = self._batch.step(require_numbers("action", action, (nu,))[None])
        reached, failed = bool(outcome.reached[0]), outcome.failed[0]
        ended = reached or bool(failed)
        truncated = bool(self._batch.truncated[0]) and not ended
        seen = self._batch.observations()[0]
        return seen, float(outcome.reward[0]), ended, truncated, self._info(failed, reached=reached)

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of the machine in its world, shape (480, 640, 3)."""
        if self.render_mode is None:
            return None
        self._batch.require_begun("render")
        from kinolab.show.film.film import staged
        from kinolab.show.film.staging.script import Playback, Script
        from kinolab.show.scene.problem_picture import picture

        problem = self.problem
        states = np.stack([problem.start, self._batch.x[0]])
        poses, cables = problem.model.frames(states[1:]), problem.model.cables(states[1:])
        shown = replace(picture(problem, states), follow=False)
        now = Playback(np.array([self._batch.steps[0] * problem.step]), problem.step, 1.0)
        # The size of rendered frames [pixel].
        return staged(Script(shown, poses, now, poses, cables, (640, 480))).frame(0)

    def _info(self, failed: str, *, reached: bool) -> dict[str, Any]:
        batch = self._batch
        t = float(batch.steps[0]) * batch.problem.step
        return {"x": batch.x[0].copy(), "t": t, "is_success": reached, "failed": failed}

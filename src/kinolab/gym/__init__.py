"""Planning problems as environments of Gymnasium, for reinforcement learning.

env = kinolab.gym.make("pendulum_swingup")
observation, info = env.reset(seed=1)
observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

Gymnasium knows every built-in scenario by an id once this package is imported:
gymnasium.make("kinolab/pendulum_swingup-v0"), or "kinolab.gym:kinolab/pendulum_swingup-v0", which
imports it.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from kinolab.arguments import require_fit
from kinolab.errors import InputError, Mistake
from kinolab.lazy import library_of
from kinolab.problem import PlanningTask

if TYPE_CHECKING:
    from kinolab.gym.planning_env import PlanningEnv
    from kinolab.gym.planning_vector_env import PlanningVectorEnv

__all__ = ["make"]

Reward = Literal["shaped", "sparse"]
Starts = Literal["scenario", "anywhere"]
Source = str | Path | Mapping[str, Any] | PlanningTask


@overload
def make(
    scenario: Source,
    *,
    num_envs: None = None,
    reward: Reward = "shaped",
    starts: Starts = "scenario",
    duration: float = 30.0,
    render_mode: Literal["rgb_array"] | None = None,
) -> PlanningEnv: ...


@overload
def make(
    scenario: Source,
    *,
    num_envs: int,
    reward: Reward = "shaped",
    starts: Starts = "scenario",
    duration: float = 30.0,
    render_mode: None = None,
) -> PlanningVectorEnv: ...


def make(
    scenario: Source,
    *,
    num_envs: int | None = None,
    reward: Reward = "shaped",
    starts: Starts = "scenario",
    duration: float = 30.0,
    render_mode: Literal["rgb_array"] | None = None,
) -> PlanningEnv | PlanningVectorEnv:
    """Return a planning problem as an environment of Gymnasium.

    An action is held for one step of the scenario (``integration.step``). The episode terminates
    in the goal, and where a step touches something, passes a limit or breaks a requirement, as in
    planners that check between the ends of a step, too.

    Args:
        scenario: What ``kinolab.load`` takes, or a problem.
        num_envs: Number of copies that one call steps at once, in compiled code; a single one,
            which is no vector, when left out.
        reward: ``sparse``: 1 in the goal, -1 where the episode ends before it, else 0. ``shaped``
            adds by how much the goal error decreases, as a fraction of the one at the scenario's
            start, which leaves the best policies what they are (for undiscounted returns).
        starts: The scenario's start, or a free state that is drawn uniformly.
        duration: Of an episode, after which it is truncated, in [s].
        render_mode: ``rgb_array`` lets ``render`` return a picture; not of vectors.

    Raises:
        InputError: If the scenario has mistakes, an argument does not fit, or Gymnasium is not
            installed.
    """
    library_of("gym", "gymnasium", "environments need Gymnasium")
    from kinolab.gym.planning_env import PlanningEnv
    from kinolab.gym.planning_vector_env import PlanningVectorEnv
    from kinolab.gym.step_batch import StepBatch
    from kinolab.loading import load

    require_fit("make scenario", str | Path | Mapping[str, Any] | PlanningTask, scenario)
    require_fit("make num_envs", int | None, num_envs)
    problem = scenario if isinstance(scenario, PlanningTask) else load(scenario)
    count = 1 if num_envs is None else num_envs
    batch = StepBatch(problem, count, reward=reward, starts=starts, duration=duration)
    if num_envs is not None and render_mode is not None:
        what = "a vector of environments draws nothing."
        raise InputError([Mistake("make render_mode", what, "Leave it out, or num_envs.")])
    if num_envs is None:
        return PlanningEnv(batch, render_mode=render_mode)
    return PlanningVectorEnv(batch)


def _register() -> None:
    """Tell Gymnasium, where it is installed, the ids of the built-in scenarios."""
    if find_spec("gymnasium") is None:
        return
    from gymnasium.envs.registration import register, registry

    from kinolab.scenario import builtin_scenarios

    for name in builtin_scenarios():
        if (known := f"kinolab/{name}-v0") not in registry:
            entry: Any = "kinolab.gym:make"
            register(known, entry, vector_entry_point=entry, kwargs={"scenario": name})


_register()

"""Several copies of a machine, stepped at once by compiled code, with rewards."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from kinolab.arguments import require_fit, require_numbers
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.problem.own_motion import other_machine
from kinolab.problem.time_steps import covering_steps
from kinolab.runs.dynobench_result import has_its_steps
from kinolab.search.tree.problem_arrays import goal_violation
from kinolab.search.tree.search_state import search_state
from kinolab.simulation.propagator import (
    COLLISION,
    EQUATIONS,
    FREE,
    LIMIT,
    Propagator,
    check_step,
    step_checks,
)
from kinolab.trajectory import Trajectory

ENDS = {LIMIT: "limit", COLLISION: "collision", EQUATIONS: "equations"}
IN_GOAL = 1.0  # largest goal error in tolerances
COMPILED = ("_search", "_checks", "_is_free")  # attributes that hold addresses
UNBEGUN = -1  # steps of an episode before the first reset


@kernel
def step_all(search, checks, x, u, after, ends, violation):  # type: ignore[no-untyped-def]
    """Make a step of every copy, and say what forbids it.

    Args:
        search: ``SearchState``.
        checks: ``StepChecks``.
        x, u: States (n, nx) and inputs (n, nu).
        after: States reached, shape (n, nx); written.
        ends: The cause by which each step is rejected, or FREE, shape (n,); written.
        violation: Goal errors after the steps, in tolerances, shape (n,); written.
    """
    for k in range(x.shape[0]):
        ends[k], _ = check_step(checks, x[k], u[k], after[k], search.problem.step, True)
        violation[k] = goal_violation(search, after[k], math.inf)


class StepOutcome(NamedTuple):
    """What a step led to, for each of n copies.

    Attributes:
        reward: Shape (n,).
        reached: Whether it ends in the goal, shape (n,).
        failed: Why the step must not be made, an empty text where it may be, n of them.
    """

    reward: Array
    reached: NDArray[np.bool_]
    failed: list[str]


class StepBatch:
    """Copies of a machine in the world of a problem.

    Args:
        count: Number of copies, n.
        reward: ``shaped`` or ``sparse``.
        starts: ``scenario`` or ``anywhere``.
        duration: Of an episode in [s].

    Raises:
        InputError: If an argument does not fit, or the problem's start or goal is impossible.

    Attributes:
        x: States, shape (n, nx).
        steps: Steps since the last reset, shape (n,); -1 before the first one.
        most_steps: Of an episode.
    """

    def __init__(
        self,
        problem: PlanningTask,
        count: int,
        *,
        reward: Literal["shaped", "sparse"],
        starts: Literal["scenario", "anywhere"],
        duration: float,
    ) -> None:
        _require_options(count, reward, starts, duration)
        problem.check_endpoints()
        self.problem, self.count = problem, count
        self._shaped, self._anywhere = reward == "shaped", starts == "anywhere"
        self.most_steps = covering_steps(duration, problem.step)
        self._compile()
        self.x = np.tile(problem.start, (count, 1))
        self.steps = np.full(count, UNBEGUN, dtype=np.int64)
        self._potential = np.zeros(count)
        self._unit = max(problem.goal_excess(problem.start), IN_GOAL)

    def _compile(self) -> None:
        """Make what compiled code takes: addresses, which no other process and no copy may have."""
        self._search = Record(search_state(self.problem, 1.0, 0))
        self._checks = Record(step_checks(self.problem))
        self._is_free = Propagator(self.problem).is_free

    def __getstate__(self) -> dict[str, Any]:
        """Return all else, for pickle and copies."""
        return {key: value for key, value in vars(self).items() if key not in COMPILED}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take it up again."""
        vars(self).update(state)
        self._compile()

    def reset(self, k: int, generator: np.random.Generator, x: ArrayLike | None = None) -> None:
        """Put a copy to its start: the scenario's, a random one, or a given state (nx,).

        Raises:
            InputError: If no free state is found, or the given one is not made of numbers.
        """
        given = None if x is None else require_numbers("reset x", x, self.problem.start.shape)
        self.x[k] = self._start(generator) if given is None else given
        self.steps[k] = 0
        self._potential[k] = -self.problem.goal_excess(self.x[k]) / self._unit

    def _start(self, generator: np.random.Generator, draws: int = 10_000) -> Array:
        if not self._anywhere:
            return self.problem.start
        for _ in range(draws):
            x = self.problem.model.project(self.problem.sample(generator))
            if self._is_free(x.tolist()):
                return x
        what = f"none of {draws} random states is free."
        raise InputError([Mistake("starts", what, 'Take starts = "scenario".')])

    def actions(self, motion: Trajectory) -> NDArray[np.float32]:
        """Return the actions (N, nu) of a motion in steps of the scenario.

        Raises:
            InputError: If it is another machine's, or has other steps.
        """
        require_fit("actions motion", Trajectory, motion)
        model, step = self.problem.model, self.problem.step
        low, high = model.control_bounds.T
        mistakes = list(other_machine(self.problem, motion))
        if not has_its_steps(self.problem, motion):
            what = f"it has other steps than {step:g} s, in which actions are held."
            remedy = "Take a plan as it was found: solve(optimize=False, improve=0)."
            mistakes.append(Mistake("actions motion", what, remedy))
        if mistakes:
            raise InputError(mistakes)
        return np.asarray(2.0 * (motion.inputs - low) / (high - low) - 1.0, dtype=np.float32)

    def step(self, actions: ArrayLike) -> StepOutcome:
        """Make a step of every copy under actions (n, nu): -1 and 1 are the limits of inputs.

        Raises:
            InputError: If the actions have another shape, or one is no number.
            ResetNeeded: If no episode has begun.
        """
        self.require_begun("step")
        low, high = self.problem.model.control_bounds.T
        given = require_numbers("action", actions, (self.count, len(low)))
        u = low + (np.clip(given, -1.0, 1.0) + 1.0) / 2.0 * (high - low)
        after, violation = np.empty_like(self.x), np.empty(self.count)
        ends = np.empty(self.count, dtype=np.int64)
        step_all(self._search, self._checks, self.x, u, after, ends, violation)
        free = ends == FREE
        reached = free & (violation <= IN_GOAL)
        after[ends == EQUATIONS] = self.x[ends == EQUATIONS]
        potential = np.where(ends == EQUATIONS, self._potential, -violation / self._unit)
        reward = reached.astype(float) - ~free
        if self._shaped:
            reward += potential - self._potential
        self.x[:], self._potential = after, potential
        self.steps += 1
        return StepOutcome(reward, reached, [ENDS.get(int(cause), "") for cause in ends])

    def require_begun(self, call: str) -> None:
        """Require that every copy was reset, as Gymnasium's own wrapper does.

        Raises:
            ResetNeeded: If one was not.
        """
        if (self.steps == UNBEGUN).any():
            raise ResetNeeded(f"{call}: no episode has begun. Call reset() first.")

    @property
    def truncated(self) -> NDArray[np.bool_]:
        """Which copies have reached the end of their time, shape (n,)."""
        return self.steps >= self.most_steps

    def observations(self) -> NDArray[np.float32]:
        """Return what a policy sees of each copy, shape (n, number of entries).

        Entries of the state divided by their scales, of an angle on the circle cosine and sine, all
        within ``observation_bounds``.
        """
        return np.clip(self._features(self.x), *self.observation_bounds.T).astype(np.float32)

    @property
    def observation_names(self) -> list[str]:
        """What the entries of an observation are."""
        circle = zip(self.problem.model.state_names, self.problem.circular, strict=True)
        named = [(f"cos {n}", f"sin {n}") if round_ else (n,) for n, round_ in circle]
        return [name for names in named for name in names]

    @property
    def observation_bounds(self) -> Array:
        """Lower and upper limit of each entry of an observation, shape (entries, 2)."""
        scaled = self.problem.bounds / self.problem.scales[:, None]
        rows = zip(self.problem.circular, scaled.tolist(), strict=True)
        return np.vstack([[[-1.0, 1.0]] * 2 if circular else [row] for circular, row in rows])

    def _features(self, x: Array) -> Array:
        columns = zip(x.T, self.problem.circular, self.problem.scales, strict=True)
        entries = [(np.cos(q), np.sin(q)) if on_circle else (q / s,) for q, on_circle, s in columns]
        return np.stack([entry for each in entries for entry in each], axis=1)


def _require_options(count: int, reward: str, starts: str, duration: float) -> None:
    require_fit("make reward", str, reward)
    require_fit("make starts", str, starts)
    require_fit("make duration", float, duration)
    mistakes = []
    if not 1 <= count <= 100_000:
        what = f"it is {count}."
        mistakes.append(Mistake("make num_envs", what, "Give a number from 1 to 100000."))
    if not (math.isfinite(duration) and duration > 0.0):
        what = f"{duration!r} s is no duration."
        mistakes.append(Mistake("make duration", what, "Give a positive number of seconds."))
    if mistakes:
        raise InputError(mistakes)
    for name, value, known in (
        ("reward", reward, ("shaped", "sparse")),
        ("starts", starts, ("scenario", "anywhere")),
    ):
        if value not in known:
            raise UnknownNameError(name, value, known=known, where=f"make {name}")

"""Checks of executed motions in the world of a problem, by machines with other parameters."""

from __future__ import annotations

from dataclasses import replace
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from kinolab.analyze.execute.failure import Failure
from kinolab.dynamics.facts.machine_facts import facts_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.modes import MODE
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal_entries import GoalEntry, goal_entries
from kinolab.verification.between_samples.clearance_margin import shown_length
from kinolab.world import NO_ENDS, CollisionChecker

VERBS = {
    "touches": "touches",
    "inside": "is inside",
    "sinks": "is pressed into",
    "error": "has no place that could be judged beside",
}


class RunMonitor:
    """Says what goes wrong along motions of machines with other parameters.

    A plan's margins to obstacles and cones are its reserve; here they are not added.

    Args:
        planned: States of the plan, shape (N+1, nx).

    Attributes:
        enough: Largest goal error, in tolerances of the plan: [goal] reserve is left to a run.
    """

    def __init__(self, problem: PlanningTask, planned: Array) -> None:
        world = replace(problem.world, clearance=0.0)
        cones = tuple(cone.forbidden for cone in problem.keep_outs)
        self._problem, self._planned = replace(problem, world=world, keep_outs=cones), planned
        self.enough = 1.0 / (1.0 - problem.scenario.goal.reserve)

    def first_fault(self, x: Array, t: Array, built: Mechanism) -> Failure | None:
        """Return what goes wrong first along a motion; None if nothing does.

        Args:
            x: States, shape (N, nx).
            t: Their times in [s], shape (N,).
        """
        problem, parameters = self.as_built(built), built.parameter_values
        frames, ends = self._placed(x, parameters)
        checker = problem.checker()
        hit = checker.first_collision(frames, ends)
        for k in range(len(x) if hit is None else hit):
            if left := list(problem.outside_world(frames[k])):
                return self._strayed(k, float(t[k]), left)
        if hit is None:
            return None
        at = frames[hit], NO_ENDS if ends is None else ends[hit]
        off = self._off_plan(hit, frames[hit])
        return _collided(hit, float(t[hit]), checker, at, off)

    def depth(self, x: Array, built: Mechanism, most: float) -> float:
        """Return by how much slimmer on every side the machine would pass along states (N, nx).

        Args:
            most: Of the depths that are tried, in [m].

        Returns:
            In [m], a little more than is needed; infinite where ``most`` does not do.
        """
        checker = self.as_built(built).checker()
        frames, ends = self._placed(x, built.parameter_values)

        def free(by: float) -> bool:
            return checker.slimmer(by).first_collision(frames, ends) is None

        if not free(most):
            return np.inf
        little = 0.0
        # 1e-4 [m], and share: a depth is told to a percent or so
        while most - little > max(1e-4, 1e-4 * most):
            middle = (little + most) / 2
            little, most = (little, middle) if free(middle) else (middle, most)
        return most

    def goal_excess(self, x: Array, parameters: dict[str, float]) -> float:
        """Return the goal error at a state (nx,), in tolerances of the plan."""
        goal, model = self._problem.goal, self._problem.model
        return goal.excess(x, model.frames(x, **parameters) if goal.asks_frames else None)

    def missed(self, x: Array, t: float, step: int, parameters: dict[str, float]) -> Failure:
        """Return which of the goal's entries are outside at the state (nx,) that came nearest.

        Its cause is the one that is farthest outside.
        """
        problem, goal = self._problem, self._problem.goal
        frames = problem.model.frames(x, **parameters) if goal.asks_frames else None
        entries = [
            replace(entry, tolerance=self.enough * entry.tolerance)
            for entry in goal_entries(problem, x, frames)
        ]
        outside = [e for e in entries if not e.reached] or entries[:1]
        outside.sort(key=lambda entry: not self._is_mode(entry))  # no other entry says as much
        detail = ", ".join(self._entry_text(entry) for entry in outside[:3])
        return Failure("missed", self._entry_name(outside[0]), f"at best {detail}", t, step)

    def slip(self, x: Array, t: Array) -> str:
        """Say since when a machine has not followed its plan from mode to mode; else nothing.

        Modes are compared in their order: a transition may come sooner or later than planned.

        Args:
            x: States, shape (n, nx).
            t: Times in [s], shape (n,) or longer.
        """
        modes, planned = self._problem.machine.modes, self._planned
        if not modes:
            return ""
        due, now = planned[: len(x), -1].astype(int), x[:, -1].astype(int)
        for late, early in zip_longest(_begins(now), _begins(due)):
            if late is not None and early is not None and now[late] == due[early]:
                continue
            first = max(late or 0, early or 0)
            here, there = modes[now[first]], modes[due[min(first, len(due) - 1)]]
            since = f"from {t[first]:.3g} s on it was in the mode {here}"
            return f"{since}, where the plan is in {there}"
        return ""

    def _entry_name(self, entry: GoalEntry) -> str:
        if self._is_mode(entry):
            modes = self._problem.machine.modes
            return f"its mode was {modes[int(entry.value)]}, not {modes[int(entry.target)]}"
        return entry.name

    def _entry_text(self, entry: GoalEntry) -> str:
        if self._is_mode(entry):
            return self._entry_name(entry)
        unit = f" {entry.unit}" if entry.unit else ""
        wanted = f"{entry.target:.4g} ± {entry.tolerance:.3g}"
        return f"{entry.name} was {entry.value:.4g}{unit} (wanted {wanted})"

    def _is_mode(self, entry: GoalEntry) -> bool:
        return bool(self._problem.machine.modes) and entry.name == MODE

    def _strayed(self, k: int, t: float, left: list[tuple[str, float, float, float]]) -> Failure:
        """Return what left the workspace, or which axis came into a forbidden cone."""
        causes, details, bodies = [], [], []
        for name, value, lower, upper in left[:3]:
            bodies.append(name.partition(" of ")[2])
            if name.startswith("the axis of"):
                causes.append(f"{name} looked into the forbidden cone")
                details.append(
                    f"{np.degrees(value):.3g}° from its middle, where {np.degrees(lower):.3g}° "
                    "is too near"
                )
                continue
            side, limit = ("above", upper) if value > upper else ("below", lower)
            causes.append(f"{name} was {side} {limit:g} m, where the workspace ends")
            details.append(f"{name} was {value:.4g} m")
        cause = ", ".join(dict.fromkeys(causes))
        return Failure("strayed", cause, ", ".join(details), t, k, tuple(dict.fromkeys(bodies)))

    def _off_plan(self, k: int, frames: Array) -> dict[str, float]:
        """Return how far each body is from where the plan has it, by name, in [m]."""
        planned = self._problem.model.frames(self._planned[min(k, len(self._planned) - 1)])
        apart = np.linalg.norm(frames[:, 3::4] - planned[:, 3::4], axis=1)
        names = (body.name for body in self._problem.bodies)
        return dict(zip(names, apart.tolist(), strict=True))

    def _placed(self, x: Array, parameters: dict[str, float]) -> tuple[Array, Array | None]:
        model = self._problem.model
        ends = model.cables(x, **parameters) if self._problem.cables else None
        return model.frames(x, **parameters), ends

    def as_built(self, system: Mechanism) -> PlanningTask:
        """Return the problem of the actual machine: its shapes may depend on parameters.

        If they do not, it is the same one, whose mesh search trees exist already.
        """
        built = replace(self._problem, machine=facts_of(system))
        same = built.bodies == self._problem.bodies and built.cables == self._problem.cables
        return self._problem if same else built


def _begins(modes: NDArray[np.intp]) -> list[int]:
    """Return where each mode of a motion begins, of its modes at every step (n,)."""
    return [0, *(np.flatnonzero(np.diff(modes)) + 1).tolist()]


def _collided(
    k: int,
    t: float,
    checker: CollisionChecker,
    at: tuple[Array, Array],
    off: dict[str, float],
) -> Failure:
    """Return who touches whom at the first pose that collides."""
    contacts = checker.contacts(*at)[:3]
    # The names of a pair that touches.
    pairs = [f"{c.body} – {c.obstacle or 'nowhere'}" for c in contacts]
    told = [f"{c.body} {VERBS.get(c.kind, 'touches')} {c.obstacle}".rstrip() for c in contacts]
    bodies = tuple(dict.fromkeys(name for c in contacts for name in (c.body, c.obstacle)))
    apart = max((off.get(body, 0.0) for body in bodies), default=0.0)
    place = f", {shown_length(apart)} from where the plan has it" if apart > 0 else ""
    detail = f"{' and '.join(told) or 'something touches'}{place}"
    return Failure("collided", ", ".join(pairs) or "unknown", detail, t, k, bodies)

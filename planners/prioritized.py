"""Prioritised planning for several machines: one after the other, each among those before it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING, ClassVar, NamedTuple, final

import numpy as np

from kinolab.dynamics.facts.machine_facts import members
from kinolab.numerics.arrays import Array
from kinolab.planners.auto import Auto
from kinolab.problem import PlanningTask
from kinolab.problem.machines.standing import among, part
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting
from kinolab.simulation.reference import resimulate
from kinolab.simulation.rollout import Rollout
from kinolab.steering import nearest_equilibrium
from kinolab.trajopt import make_exact

if TYPE_CHECKING:
    from kinolab.dynamics.language.shapes import Shape

CHORD = 0.01  # [m] between a motion and the straight lines that others avoid, by as much more


class _Motion(NamedTuple):
    """What one machine does: step by step, and then it stays."""

    states: Array  # (N+1, nx)
    inputs: Array  # (N, nu)
    held: Array  # (nu,) inputs that hold it where it has come to


@final
@dataclass(frozen=True, kw_only=True)
class Prioritized(AbstractPlanner):
    """Plans for several machines one after the other, each among those that have a motion already.

    First all are planned for as one machine, for as much work as one order gets: of few machines
    that mostly suffices. In an order, each comes to rest in its goal and stays there. Where one
    finds no motion, it goes first in the next attempt; then other orders are tried, each with twice
    the work. In the end all are one machine again, which finds what no order does: two that must
    make way for each other. One machine alone is planned for as by ``auto``.

    Source: Erdmann, Lozano-Perez, On multiple moving objects, Algorithmica 2, 1987; Bennewitz,
    Burgard, Thrun, Finding and optimizing solvable priority schemes for decoupled path planning
    techniques for teams of mobile robots, Robotics and Autonomous Systems 41, 2002 (the orders).
    """

    name: ClassVar[str] = "prioritized"
    waits: ClassVar[bool] = True

    attempts: int = setting(
        6, 0, 1000, meaning="Orders that are tried before all are planned for as one machine."
    )
    iterations: int = setting(
        20_000,
        1,
        unit="iterations",
        meaning="Of the search for one machine in the first attempt; twice as many in the next.",
    )

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Try one order after another, and then all at once."""
        names = members(problem.machine.name)
        if not names:
            return Auto().solve(problem, seed, budget)
        found = _searched(problem, seed, self.iterations, budget)
        if found.outcome is Outcome.SOLVED:
            return found
        with budget.preparing():
            alone = {name: _at_rest(part(problem, name)) for name in names}
        generator, order = np.random.default_rng(seed), [*names]
        tried: set[tuple[str, ...]] = set()
        for k in count():
            if budget.over or k >= self.attempts:
                break
            tried.add(tuple(order))
            most, drawn = self.iterations * 2**k, int(generator.integers(2**63))
            motions, failed = self._in_order({n: alone[n] for n in order}, drawn, most, budget)
            if not failed:
                inputs = _side_by_side(problem, alone, dict(zip(order, motions, strict=True)))
                times = problem.step * np.arange(len(inputs) + 1.0)
                return SearchResult(Outcome.SOLVED, times, inputs, budget.iterations)
            order.insert(0, order.pop(len(motions)))
            if tuple(order) in tried:
                order = [names[i] for i in generator.permutation(len(names))]
        return Auto().solve(problem, int(generator.integers(2**63)), budget)  # not the same again

    def _in_order(
        self, alone: Mapping[str, PlanningTask], seed: int, most: int, budget: Budget
    ) -> tuple[list[_Motion], bool]:
        """Return the motions of machines in their order, up to the first that finds none."""
        motions: list[_Motion] = []
        others: dict[str, tuple[tuple[Shape, ...], Array]] = {}
        for k, (name, task) in enumerate(alone.items()):
            if others and budget.told:
                before = ", ".join([*alone][:k])
                budget.told(f"deriving and compiling {name} among the motions of {before}")
            with budget.preparing():
                here = among(task, others, CHORD) if others else task
            found = _found(here, task, seed + k, most, budget)
            if found is None:
                return motions, True
            motions.append(found)
            others |= _paths(task, found)
        return motions, False


def _searched(task: PlanningTask, seed: int, most: int, budget: Budget) -> SearchResult:
    """Search with ``auto`` for some iterations at most, which count in the budget."""
    own = replace(budget, iterations=0, max_iterations=most, cancelled=budget.expired)
    found = Auto().solve(task, seed, own)
    budget.spend(own.iterations)
    return found


def _found(
    here: PlanningTask, alone: PlanningTask, seed: int, most: int, budget: Budget
) -> _Motion | None:
    """Return a motion of one machine that ends at rest in its goal; None if none is found."""
    found = _searched(here, seed, most, budget)
    if found.outcome is not Outcome.SOLVED:
        return None
    made = make_exact(here, resimulate(here, found.t, found.u), budget.expired, held=True)
    if made is None:
        return None
    steps = np.rint(np.diff(made.t) / here.step).astype(int)
    inputs = np.repeat(made.inputs, steps, axis=0)
    states = Rollout(here, budget.expired).follow(here.start, inputs)
    if states is None:
        return None
    kept = [here.model.state_names.index(name) for name in alone.model.state_names]
    held = nearest_equilibrium(alone, states[-1, kept])
    return None if held is None else _Motion(states[:, kept], inputs, held[1])


def _at_rest(task: PlanningTask) -> PlanningTask:
    """Return the problem whose machine comes to rest in its goal."""
    return replace(task, goal=task.goal.at_rest(task.model.speeds))


def _paths(
    task: PlanningTask, motion: _Motion
) -> Iterator[tuple[str, tuple[tuple[Shape, ...], Array]]]:
    """Yield the bodies of a machine that moves as was planned, as the others see them."""
    from kinolab.dynamics.movers import corners_of  # late: uses SymPy

    times = task.step * np.arange(float(len(motion.states)))
    poses = task.model.frames(motion.states).reshape(len(times), -1, 3, 4)
    for k, body in enumerate(task.bodies):
        if body.shapes:
            yield body.name, (body.shapes, corners_of(body.shapes, times, poses[:, k], CHORD))


def _side_by_side(
    problem: PlanningTask, alone: dict[str, PlanningTask], motions: dict[str, _Motion]
) -> Array:
    """Return the inputs of all machines step by step, (N, nu), those that have come held."""
    steps = max(len(motion.inputs) for motion in motions.values())
    names = problem.model.control_names
    inputs = np.zeros((steps, len(names)))
    for name, motion in motions.items():
        own = [names.index(entry) for entry in alone[name].model.control_names]
        inputs[: len(motion.inputs), own] = motion.inputs
        inputs[len(motion.inputs) :, own] = motion.held
    return inputs

"""Propagation and validity as OMPL calls them."""

from __future__ import annotations

from typing import Any

from kinolab.bridge.spaces import States
from kinolab.problem import Problem
from kinolab.propagation import Propagator


class Propagation:
    """A propagator between OMPL's states; OMPL asks for a step first, then whether it was free.

    Attributes:
        rejections: How many motions were refused, by cause and culprit.
    """

    def __init__(self, problem: Problem, states: States) -> None:
        self._states, self._propagator = states, Propagator(problem)
        self._inputs = range(problem.model.nu)
        self._last: tuple[list[float], bool] = ([], False)
        self.rejections = self._propagator.rejections

    def propagate(self, state: Any, control: Any, duration: float, result: Any) -> None:
        """Write the state after one step; whether the way there is free is kept for is_valid."""
        held = [control[i] for i in self._inputs]
        reached, free = self._propagator.step(self._states.read(state), held, duration)
        self._states.write(result, reached)
        self._last = (self._states.read(result), free)

    def forget(self) -> None:
        """Forget the step made last, whose end may be the state that a planner begins from."""
        self._last = ([], False)

    def is_valid(self, state: Any) -> bool:
        """Say whether a state is within its limits and free; a state just reached, with its way."""
        values = self._states.read(state)
        if values == self._last[0]:
            return self._last[1]
        return self._propagator.is_free(values)

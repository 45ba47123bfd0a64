"""Propagation and validity as OMPL calls them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from kinolab.problem import PlanningTask
from kinolab.search.ompl.control_guidance import ControlGuide
from kinolab.search.ompl.spaces import StateCodec
from kinolab.simulation import Propagator


class StatePropagator:
    """A propagator between OMPL's states; OMPL asks for a step first, then whether it was free.

    Args:
        problem: Whose machine moves.
        states: The way into and out of OMPL's states.
        guide: Chooses inputs and ends motions; None leaves both to OMPL.
        given_up: Says when no state is valid any more; a planner that finds none comes to an end.

    Attributes:
        rejections: How many motions were refused, by cause and culprit.
    """

    def __init__(
        self,
        problem: PlanningTask,
        states: StateCodec,
        guide: ControlGuide | None,
        given_up: Callable[[], bool],
    ) -> None:
        self._states, self._guide, self._propagator = states, guide, Propagator(problem)
        self._inputs = range(problem.model.nu)
        self._last: tuple[list[float], bool] = ([], False)
        self._given_up = given_up
        self.rejections = self._propagator.rejections

    def propagate(self, state: Any, control: Any, duration: float, result: Any) -> None:
        """Write the state after one step; whether the way there is free is kept for is_valid."""
        values, held = self._states.read(state), [control[i] for i in self._inputs]
        if self._guide:
            held = self._guide.hold(values, held, control)
            if self._guide.ends():
                self._states.write(result, values)
                self._last = (self._states.read(result), False)
                return
        reached, free = self._propagator.step(values, held, duration)
        self._states.write(result, reached)
        self._last = (self._states.read(result), free)
        if self._guide:
            self._guide.reached(values, self._last[0], free=free)

    def forget(self) -> None:
        """Forget the step made last, whose end may be the state that a planner begins from."""
        self._last = ([], False)

    def is_valid(self, state: Any) -> bool:
        """Say whether a state is within its limits and free; a state just reached, with its way."""
        if self._given_up():
            return False
        values = self._states.read(state)
        if values == self._last[0]:
            return self._last[1]
        return self._propagator.is_free(values)

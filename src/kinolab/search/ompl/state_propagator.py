"""State propagator and state validity checker for OMPL."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from kinolab.problem import PlanningTask
from kinolab.search.ompl.control_guidance import ControlGuide
from kinolab.search.ompl.spaces import StateCodec
from kinolab.simulation import Propagator


class StatePropagator:
    """Propagates OMPL states; OMPL first propagates a step, then asks whether it is valid.

    Args:
        states: Conversion to and from OMPL's states.
        guide: Chooses inputs and ends motions; None leaves both to OMPL.
        given_up: Whether no state is valid any more, so that the planner terminates.

    Attributes:
        rejections: Numbers of rejected motions, by cause and source.
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

    @property
    def propagations(self) -> int:
        """Steps simulated so far, with those of the lookahead."""
        ahead = 0 if self._guide is None else self._guide.propagations
        return self._propagator.propagations + ahead

    def propagate(self, state: Any, control: Any, duration: float, result: Any) -> None:
        """Write the state after one step; the validity of the step is kept for ``is_valid``."""
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
        """Discard the last step, whose end may be the state that a planner starts from."""
        self._last = ([], False)

    def is_valid(self, state: Any) -> bool:
        """Say whether a state is valid, including the step to it if that was the last one."""
        if self._given_up():
            return False
        values = self._states.read(state)
        if values == self._last[0]:
            return self._last[1]
        return self._propagator.is_free(values)

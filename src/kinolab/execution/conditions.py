"""What is wrong with the world a plan is carried out in: parameters, sensors, disturbances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.attitude import turned_at_random
from kinolab.dynamics import Model
from kinolab.errors import InputError, Mistake
from kinolab.problem import Problem

Array: TypeAlias = NDArray[np.float64]

LARGEST = 1.0  # share: beyond it a mass could be negative


@dataclass(frozen=True)
class Conditions:
    """How far the machine and what is measured of it are from what the plan assumes.

    Attributes:
        parameters: Every parameter is drawn evenly within this share of its value.
        noise: Standard deviation of what is measured of each state, as a share of its scale.
        disturbance: Standard deviation of what is added to each input in every step, as a share of
            its range.
    """

    parameters: float = 0.0
    noise: float = 0.0
    disturbance: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is no share."""
        mistakes = [
            Mistake(f"--{name}", f"{value:g} is no share.", f"Give 0 or more, below {LARGEST:g}.")
            for name, value in vars(self).items()
            if not 0.0 <= value < LARGEST
        ]
        if mistakes:
            raise InputError(mistakes)

    def machine(self, model: Model, generator: np.random.Generator) -> dict[str, float]:
        """Return parameters of a machine that somebody built, by name."""
        values = model.system.parameter_values
        shares = generator.uniform(-self.parameters, self.parameters, len(values))
        drawn = zip(values.items(), shares, strict=True)
        return {name: float(value * (1.0 + share)) for (name, value), share in drawn}

    def measured(self, problem: Problem, x: Array, generator: np.random.Generator) -> Array:
        """Return what sensors say of a state, shape (nx,)."""
        if not self.noise:
            return x
        seen = x + self.noise * problem.scales * generator.standard_normal(len(x))
        for first in problem.model.attitudes.values():
            own = slice(first, first + 4)
            seen[own] = turned_at_random(x[own], self.noise * problem.scales[first], generator)
        return seen

    def disturbed(self, model: Model, u: Array, generator: np.random.Generator) -> Array:
        """Return the inputs that act where others were meant, shape (nu,)."""
        if not self.disturbance:
            return u
        span = np.ptp(model.control_bounds, axis=1)
        acting: Array = u + self.disturbance * span * generator.standard_normal(len(u))
        return acting

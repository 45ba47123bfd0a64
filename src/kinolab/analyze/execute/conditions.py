"""Perturbations of a plan's execution: parameters, sensor noise, input disturbances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from kinolab.dynamics import Model
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

MAX_FRACTION = 1.0  # above it a mass could be negative
SHARES = ("parameters", "noise", "disturbance")
MAX_DRAWS = 100  # of parameters, until they are valid: moments of inertia must be consistent


@dataclass(frozen=True)
class Conditions:
    """Deviations of the machine and its measurements from what the plan assumes.

    Attributes:
        parameters: Every parameter is drawn uniformly within this fraction of its value.
        noise: Standard deviation of the measurement of each state, as a fraction of its scale.
        disturbance: Standard deviation of the noise on each input in every step, as a fraction of
            its range.
        built: Actual values of parameters, unknown to the plan, by name, such as friction that the
            planner neglected. They are perturbed, too.
        tracked: Whether feedback gains track the plan; a machine's own feedback always acts.
    """

    parameters: float = 0.0
    noise: float = 0.0
    disturbance: float = 0.0
    built: Mapping[str, float] = field(default_factory=dict)
    tracked: bool = True

    def __post_init__(self) -> None:
        """Reject invalid fractions."""
        mistakes = [
            Mistake(
                f"--{name}", f"{value:g} is no share.", f"Give 0 or more, below {MAX_FRACTION:g}."
            )
            for name in SHARES
            if not 0.0 <= (value := getattr(self, name)) < MAX_FRACTION
        ]
        if mistakes:
            raise InputError(mistakes)

    def require_something_to_vary(self, problem: PlanningTask) -> None:
        """Refuse perturbations of what the machine does not have: all runs would be the same.

        Raises:
            InputError: If it has no parameters that differ from 0, or no inputs with a range.
        """
        system, mistakes = problem.system, list[Mistake]()
        if self.parameters and not any(self.varied(system).parameter_values.values()):
            what = f"{system.name} has no parameter to vary, or they are all 0."
            remedy = "Describe the machine in Python, or vary --noise or --disturbance."
            mistakes.append(Mistake("--parameters", what, remedy))
        plant = (problem.whole or problem.model).plant
        if self.disturbance and not np.ptp(plant.control_bounds, axis=1).any():
            what = f"{system.name} has no input with a range."
            mistakes.append(Mistake("--disturbance", what, "Vary --parameters or --noise."))
        if mistakes:
            raise InputError(mistakes)

    def varied(self, system: Mechanism) -> Mechanism:
        """Return the actual machine, whose parameters are all that is varied.

        Raises:
            InputError: If a parameter in ``built`` does not exist.
        """
        meant = system.with_parameters(**self.built)
        further = [name for name, value in meant.offered.items() if value]
        return meant.parametric(*further) if self.parameters and further else meant

    def machine(self, system: Mechanism, generator: np.random.Generator) -> Mechanism:
        """Return a machine with perturbed parameters.

        Raises:
            InputError: If a parameter in ``built`` does not exist, or if no draw is a valid
                machine.
        """
        meant = self.varied(system)
        for _ in range(MAX_DRAWS - 1):
            try:
                return self._drawn(meant, generator)
            except InputError:
                continue  # physically impossible
        return self._drawn(meant, generator)

    def _drawn(self, meant: Mechanism, generator: np.random.Generator) -> Mechanism:
        values = meant.parameter_values
        shares = generator.uniform(-self.parameters, self.parameters, len(values))
        drawn = zip(values.items(), shares, strict=True)
        return meant.with_parameters(
            **{name: float(value * (1.0 + fraction)) for (name, value), fraction in drawn}
        )

    def measured(self, problem: PlanningTask, x: Array, generator: np.random.Generator) -> Array:
        """Return the noisy measurement of a state, shape (nx,)."""
        if not self.noise:
            return x
        seen = x + self.noise * problem.scales * generator.standard_normal(len(x))
        for part in problem.space.spheres:
            most = self.noise * problem.scales[part.first]
            seen[part.own] = part.near(x[part.own], most, generator)
        return seen

    def disturbed(self, model: Model, u: Array, generator: np.random.Generator) -> Array:
        """Return the disturbed inputs, shape (nu,)."""
        if not self.disturbance:
            return u
        span = np.ptp(model.control_bounds, axis=1)
        acting: Array = u + self.disturbance * span * generator.standard_normal(len(u))
        return acting

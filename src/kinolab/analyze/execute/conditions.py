"""Perturbations of a plan's execution: parameters, sensor noise, input disturbances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from kinolab.dynamics import Model
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.errors import InputError, Mistake, unknown_name
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.tube.uncertainty import kept_by_default


@dataclass(frozen=True)
class Conditions:
    """Deviations of the machine and its measurements from what the plan assumes.

    Attributes:
        parameters: Every parameter is drawn uniformly within this fraction of its value, but for
            the strength of gravity and those that the machine lists as ``keep``.
        noise: Standard deviation of the measurement of each state, as a fraction of its scale.
        disturbance: Standard deviation of the noise on each input in every step, as a fraction of
            its range.
        built: Actual values of parameters, unknown to the plan, by name, such as friction that the
            planner neglected. They are perturbed, too.
        tracked: Whether feedback gains track the plan; a machine's own feedback always acts.
        vary: Fractions of single parameters, by name, instead of ``parameters``.
        keep: Names of further parameters that stay as they are.
        track: Names of coordinates that are tracked though nothing depends on them, such as how far
            a wheel has rolled.
    """

    parameters: float = 0.0
    noise: float = 0.0
    disturbance: float = 0.0
    built: Mapping[str, float] = field(default_factory=dict)
    tracked: bool = True
    vary: Mapping[str, float] = field(default_factory=dict)
    keep: tuple[str, ...] = ()
    track: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Reject invalid fractions."""
        told = {f"--{name}": getattr(self, name) for name in ("parameters", "noise", "disturbance")}
        told |= {f"--vary {name}": share for name, share in self.vary.items()}
        mistakes = [
            Mistake(where, f"{value:g} is no share.", "Give 0 or more, below 1.")
            for where, value in told.items()
            if not 0.0 <= value < 1.0  # above it a mass could be negative
        ]
        for name in (name for name in self.vary if name in self.keep):
            what = f"{name} is also given to --vary."
            mistakes.append(Mistake(f"--keep {name}", what, "Leave one of the two out."))
        if mistakes:
            raise InputError(mistakes)

    def require_something_to_vary(self, problem: PlanningTask) -> None:
        """Refuse perturbations of what the machine does not have: all runs would be the same.

        Raises:
            InputError: If it has no parameters that differ from 0, or no inputs with a range.
        """
        mistakes = list(self._unknown(problem))
        system = self.varied(problem.system)
        if self.parameters and not any(self.shares(system).values()):
            what = f"{system.name} has no parameter to vary, or they are all 0."
            remedy = "Describe the machine in Python, or vary --noise or --disturbance."
            if kept := kept_by_default(system):
                what = f"{system.name} has no parameter to vary but {', '.join(kept)}."
                remedy = f"Name what shall vary: --vary {kept[0]}={self.parameters:g}."
            mistakes.append(Mistake("--parameters", what, remedy))
        plant = (problem.whole or problem.model).plant
        if self.disturbance and not np.ptp(plant.control_bounds, axis=1).any():
            what = f"{system.name} has no input with a range."
            mistakes.append(Mistake("--disturbance", what, "Vary --parameters or --noise."))
        if mistakes:
            raise InputError(mistakes)

    def _unknown(self, problem: PlanningTask) -> Iterator[Mistake]:
        """Yield what is named here and does not exist."""
        parameters = [*problem.system.parameter_values, *problem.system.offered]
        for where, names in (("--vary", self.vary), ("--keep", self.keep)):
            for name in names:
                if name not in parameters:
                    yield unknown_name("parameter", name, known=parameters, where=where)
        coordinates = problem.model.state_names[: problem.model.nq]
        for name in self.track:
            if name not in coordinates:
                yield unknown_name("coordinate", name, known=coordinates, where="--track")

    def shares(self, system: Mechanism) -> dict[str, float]:
        """Return by which fraction of its value each parameter varies, of those that do."""
        kept = {*kept_by_default(system), *self.keep}
        values = {name: value for name, value in system.parameter_values.items() if value}
        shares = {name: 0.0 if name in kept else self.parameters for name in values}
        shares |= self.vary
        return {name: share for name, share in shares.items() if share and name in values}

    def varied(self, system: Mechanism) -> Mechanism:
        """Return the actual machine, of which all that varies is a parameter.

        Raises:
            InputError: If a parameter in ``built`` does not exist.
        """
        meant = system.with_parameters(**self.built)
        further = [name for name, value in meant.offered.items() if value]
        if not self.parameters:
            further = [name for name in further if name in self.vary]
        return meant.parametric(*further) if further else meant

    def machine(self, system: Mechanism, generator: np.random.Generator) -> Mechanism:
        """Return a machine with perturbed parameters.

        Raises:
            InputError: If a parameter in ``built`` does not exist, or if no draw is a valid
                machine.
        """
        meant = self.varied(system)
        # 100 draws of parameters, until they are valid: moments of inertia must be consistent
        for _ in range(100 - 1):
            try:
                return self._drawn(meant, generator)
            except InputError:
                continue  # physically impossible
        return self._drawn(meant, generator)

    def _drawn(self, meant: Mechanism, generator: np.random.Generator) -> Mechanism:
        values, shares = meant.parameter_values, self.shares(meant)
        # All are drawn, so that a further one that is kept leaves the others as they were.
        drawn = dict(zip(values, generator.uniform(-1.0, 1.0, len(values)), strict=True))
        return meant.with_parameters(
            **{n: float(values[n] * (1.0 + share * drawn[n])) for n, share in shares.items()}
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

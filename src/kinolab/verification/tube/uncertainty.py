"""What a proof holds for: intervals of parameters, disturbances and errors of measurement."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.symbols.symbols import Parameter
from kinolab.errors import InputError, Mistake, unknown_name
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask


@dataclass(frozen=True)
class Uncertainty:
    """All that may differ from what a plan assumes, within bounds.

    Attributes:
        parameters: By which fraction of its value each parameter may be off, by name.
        noise: By how much a measured state is off at most, as a fraction of its scale.
        disturbance: By how much an input is off at most, as a fraction of its range; it may be
            another amount in every step.
    """

    parameters: Mapping[str, float] = field(default_factory=dict)
    noise: float = 0.0
    disturbance: float = 0.0

    def times(self, factor: float) -> Uncertainty:
        """Return what is a factor as uncertain."""
        shares = {name: factor * share for name, share in self.parameters.items()}
        return replace(
            self,
            parameters=shares,
            noise=factor * self.noise,
            disturbance=factor * self.disturbance,
        )

    def require(self, problem: PlanningTask) -> None:
        """Refuse what makes no sense for a machine.

        Raises:
            InputError: With every mistake that was found.
        """
        if mistakes := list(self._mistakes(problem)):
            raise InputError(mistakes)

    def _mistakes(self, problem: PlanningTask) -> Iterator[Mistake]:
        model = (problem.whole or problem.model).plant
        values = dict(zip(model.parameter_names, model.parameter_vector().tolist(), strict=True))
        shown = shown_by(problem)
        for name, share in self.parameters.items():
            where = f"parameter {name}"
            if name not in values:
                yield unknown_name(
                    "parameter", name, known=model.parameter_names, where="parameters"
                )
            elif not 0.0 <= share < 1.0:  # above it a mass could be negative
                low = values[name] * (1.0 - share)
                what = f"within {share:.0%} of {values[name]:g} it could be {low:g}."
                yield Mistake(where, what, "Give 0 % or more, below 100 %.")
            elif name in shown:
                what = "the size of a shape depends on it, and shapes are taken as they are."
                yield Mistake(where, what, "Leave it out; plan execute varies it, too.")
        for name, share in (("noise", self.noise), ("disturbance", self.disturbance)):
            if not 0.0 <= share < 1.0:
                yield Mistake(name, f"{share:g} is no share.", "Give 0 or more, below 1.")
        if self.disturbance and not np.ptp(model.control_bounds, axis=1).any():
            what = f"{problem.machine.name} has no input with a range."
            yield Mistake("disturbance", what, "Leave it out, or give intervals of parameters.")

    def radii(self, problem: PlanningTask) -> Array:
        """Return by how much each parameter of the machine is off at most, in SI units."""
        model = (problem.whole or problem.model).plant
        shares = [self.parameters.get(name, 0.0) for name in model.parameter_names]
        return np.asarray(np.abs(model.parameter_vector() * np.array(shares)) * (1.0 + 1e-15))

    def input_radii(self, problem: PlanningTask) -> Array:
        """Return by how much each input is off at most, shape (nu,)."""
        model = (problem.whole or problem.model).plant
        return np.asarray(self.disturbance * np.ptp(model.control_bounds, axis=1))

    def measurement_radii(self, problem: PlanningTask) -> Array:
        """Return by how much each measured entry of the state is off at most, shape (nx,)."""
        return np.asarray(self.noise * problem.scales)

    def __str__(self) -> str:
        """Say it in words."""
        groups: dict[float, list[str]] = {}
        for name, share in self.parameters.items():
            groups.setdefault(share, []).append(name)
        told = [f"{', '.join(names)} within {100 * share:.3g} %" for share, names in groups.items()]
        if self.noise:
            told.append(f"measurements within {100 * self.noise:.3g} % of their scales")
        if self.disturbance:
            told.append(f"inputs off by up to {100 * self.disturbance:.3g} % of their ranges")
        return " and ".join(told) or "nothing uncertain"

    @classmethod
    def of(cls, problem: PlanningTask) -> Uncertainty | None:
        """Return what the scenario's [robust] asks for; None where it has none.

        Raises:
            InputError: If it makes no sense for the machine.
        """
        section = problem.scenario.robust
        if section is None:
            return None
        shares = section.parameters
        if not isinstance(shares, dict):
            names = varied_by_default(problem, kept_by_default(problem.system))
            shares = dict.fromkeys(names, shares)
        found = cls(shares, section.noise, section.disturbance)
        found.require(problem)
        return found

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Uncertainty:
        """Return what ``to_json`` returned.

        Raises:
            KeyError: If something is missing.
            TypeError: If something is no number.
        """
        shares = {str(name): float(share) for name, share in data["parameters"].items()}
        return cls(shares, float(data["noise"]), float(data["disturbance"]))

    def to_json(self) -> dict[str, object]:
        """Return it as data."""
        return {
            "parameters": dict(self.parameters),
            "noise": self.noise,
            "disturbance": self.disturbance,
        }


def kept_by_default(system: Mechanism) -> tuple[str, ...]:
    """Return the parameters that nobody builds: the strength of gravity, and the machine's own."""
    strength = () if system.gravity is None else (system.gravity.strength,)
    weight = {entry.name for entry in strength if isinstance(entry, Parameter)}
    # "g" is what everybody calls it, also where it is written in a force of one's own
    kept = {"g", *weight, *system.keep}
    return tuple(name for name in system.parameter_values if name in kept)


def varied_by_default(problem: PlanningTask, kept: tuple[str, ...]) -> tuple[str, ...]:
    """Return the parameters that are uncertain unless one says otherwise.

    These are all that differ from 0, but for those that are kept, and those that shapes depend on.
    """
    model = (problem.whole or problem.model).plant
    values = zip(model.parameter_names, model.parameter_vector().tolist(), strict=True)
    left_out = {*kept, *shown_by(problem)}
    return tuple(name for name, value in values if value and name not in left_out)


def shown_by(problem: PlanningTask) -> set[str]:
    """Return the parameters on which the size of a shape or a cable depends."""
    from kinolab.dynamics.facts.machine_facts import facts_of

    system, found = problem.system, set()
    for name, value in system.parameter_values.items():
        # 1 %: any other value shows whether it matters
        other = system.with_parameters(**{name: 1.01 * value if value else 0.01})
        facts, own = facts_of(other), facts_of(system)
        if facts.bodies != own.bodies or facts.cables != own.cables:
            found.add(name)
    return found

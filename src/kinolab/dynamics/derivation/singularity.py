"""Where the independent velocities of a machine do not determine its motion, and what to do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.derivation.regularity import singular_configuration
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.symbolic_solve import Guards
from kinolab.dynamics.derivation.velocity_coordinates import velocity_coordinates
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import imposed_velocities
from kinolab.errors import row_of


@dataclass(frozen=True)
class Singularity:
    """A configuration within the limits at which independent velocities do not serve.

    Attributes:
        velocities: Names of the independent velocities.
        at: The configuration, by the names of its entries.
        cure: What would help, in words.
    """

    velocities: tuple[str, ...]
    at: Mapping[str, float]
    cure: str

    @property
    def sentence(self) -> str:
        """What is wrong, where, and what would help."""
        # 1e-6 of a coordinate; a smaller one is not worth a word
        place = ", ".join(f"{name} = {x:.4g}" for name, x in self.at.items() if abs(x) > 1e-6)
        subject = row_of(self.velocities)
        verb = "do" if len(self.velocities) > 1 else "does"
        where = f" at {place}" if place else " where every coordinate is 0"
        return f"{subject} {verb} not determine the motion{where}. {self.cure}"


def singularity_of(system: Mechanism) -> Singularity | None:
    """Return a configuration at which a machine's velocities are singular; None if none is found.

    Closed loops are left out: their singularities are the mechanism's own.
    """
    if system.velocities == "all" or not (system.constraints or imposed_velocities(system)):
        return None
    binding = SymbolTable.of(system)
    chart = velocity_coordinates(binding, Guards())
    rows = [row.covector for row in chart.defining]
    found = singular_configuration(binding, rows, chart.dependent)
    if found is None:
        return None
    deciding = {
        binding.tape.operations[node].label
        for row in rows
        for entry in row
        for node in binding.tape.depends_on(entry)
    }
    names = [binding.tape.operations[node].label for node in chart.states]
    imposed = (node for node in chart.input_directions if node != binding.tape.one)
    names += [binding.tape.operations[node].label for node in imposed]
    at = {name: x for name, x in found.items() if name in deciding}
    return Singularity(tuple(names), at, cure_of(system))


def cure_of(system: Mechanism) -> str:
    """Return what helps where a machine's velocities do not determine its motion."""
    if isinstance(system.velocities, tuple):
        return "Leave out velocities=[…], so that kinolab chooses them."
    if imposed_velocities(system):
        return "Limit the coordinates so that the machine stays away from there."
    return 'Limit the coordinates, name other ones with velocities=[…], or take velocities="all".'


def condition_number(system: Mechanism, values: Mapping[str, float]) -> float:
    """Return the condition number of the solve for the dependent velocities at a state.

    Args:
        values: Of the configuration and the parameters, by name.
    """
    binding = SymbolTable.of(system)
    chart = velocity_coordinates(binding, Guards())
    block = [[row.covector[i] for i in chart.dependent] for row in chart.defining]
    flat = [entry for row in block for entry in row]
    matrix = np.reshape(binding.tape.evaluate(flat, dict(values)), (len(block), -1))
    whole = [entry for row in chart.defining for entry in row.covector]
    size = np.linalg.norm(binding.tape.evaluate(whole, dict(values)))
    smallest = np.linalg.svd(matrix, compute_uv=False)[-1]
    return float(size / max(smallest, 1e-300))

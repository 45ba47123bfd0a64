"""What is kept of a machine's derivation as formulas, to be enclosed over boxes of states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.store import Kind, pickled

if TYPE_CHECKING:  # what derives a machine: one that is in the cache needs none of it
    from kinolab.dynamics.derivation.derivation import Derivation


@dataclass(frozen=True)
class ModeFormulas:
    """Formulas of a machine, or of one of its modes.

    Attributes:
        state: Names of the entries of a state.
        inputs: Names of the inputs.
        parameters: Names of the parameters.
        speeds: Bounds on the speed of all points of each body, and of each cable, in [m/s].
        requirements: What must not be negative in a plan.
        velocities: All of them, also those that follow from others.
        frames: Rows of [R | p] of each body.
        signs: Where one of them changes its sign, a body may jump.
    """

    state: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    speeds: Formulas
    requirements: Formulas
    velocities: Formulas
    frames: Formulas
    signs: Formulas

    @classmethod
    def of(cls, d: Derivation) -> ModeFormulas:
        """Return what a derivation holds of them."""
        tape, speeds = d.binding.tape, (*d.point_speeds, *d.cable_speeds)
        state, inputs, parameters = (
            tuple(tape.operations[node].label for node in nodes) for nodes in d.arguments.values()
        )
        placing = (tape.operations[node] for node in tape.needed((*d.frames, *d.cables)))
        signs = [operation.operands[0] for operation in placing if operation.name == "sign"]
        formulas = (speeds, d.requirements, d.velocities, d.frames, signs)
        kept = (Formulas.of(tape, nodes) for nodes in formulas)
        return cls(state, inputs, parameters, *kept)


FORMULAS: Kind[tuple[ModeFormulas, ...]] = pickled("formulas", tuple)  # of all modes, by a key

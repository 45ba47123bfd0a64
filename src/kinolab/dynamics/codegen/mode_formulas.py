"""What is kept of a machine's derivation as formulas, to be enclosed over boxes of states."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kinolab.dynamics.derivation.cancellation import Cancellation, without_turns
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.numerics.manifolds.state_parts import Circle
from kinolab.store import Kind, pickled

if TYPE_CHECKING:  # what derives a machine: one that is in the cache needs none of it
    from kinolab.dynamics.derivation.derivation import Derivation

# Forces of constraints are solutions of linear equations. Of many of them, intervals that are
# computed like numbers are of no use: each operation makes them wider.
MOST_OPERATIONS = 1000


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
        rates: Rates of change of the coordinates, length nq, then of each body the velocity of its
            origin in [m/s] and its spin in [rad/s], in axes of which some may turn, 6 per body.
        accelerations: Rates of change of these; NaN where they follow inputs at once, or where a
            formula would be so long that enclosing it would be of no use.
        seats: Where bodies' origins are in bodies' axes, as ``Derivation`` has them.
    """

    state: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    speeds: Formulas
    requirements: Formulas
    velocities: Formulas
    frames: Formulas
    signs: Formulas
    rates: Formulas
    accelerations: Formulas
    seats: Formulas

    @classmethod
    def of(cls, d: Derivation) -> ModeFormulas:
        """Return what a derivation holds of them."""
        tape, speeds = d.binding.tape, (*d.point_speeds, *d.cable_speeds)
        state, inputs, parameters = (
            tuple(tape.operations[node].label for node in nodes) for nodes in d.arguments.values()
        )
        placing = (tape.operations[node] for node in tape.needed((*d.frames, *d.cables)))
        signs = [operation.operands[0] for operation in placing if operation.name == "sign"]
        rates = _rates(d)
        kinds = (speeds, d.requirements, d.velocities, d.frames, signs)
        formulas = (*kinds, rates, _accelerations(d, rates), d.seats)
        kept = (Formulas.of(tape, nodes) for nodes in formulas)
        return cls(state, inputs, parameters, *kept)


def _shortened(d: Derivation, nodes: Sequence[Node]) -> list[Node]:
    """Return formulas without what cancels: in numbers it does so by itself, in intervals not."""
    tape = d.binding.tape
    circles = [d.state[part.first] for part in d.parts if isinstance(part, Circle)]
    turned = without_turns(tape, nodes, circles)
    return min(turned, Cancellation(tape).rewritten(turned), key=lambda n: len(tape.needed(n)))


def _rates(d: Derivation) -> list[Node]:
    """Return rates of coordinates and bodies, in axes where they are short."""
    tape = d.binding.tape

    def shortest(axes: Iterable[Sequence[Node]]) -> list[Node]:
        return min((_shortened(d, one) for one in axes), key=lambda n: len(tape.needed(n)))

    spins = (d.spins[k : k + 3] for k in range(0, len(d.spins), 3))
    pairs = zip(d.velocities_of_origins, spins, strict=True)
    bodies = (node for axes, spin in pairs for node in (*shortest(axes), *shortest([spin])))
    return [*_shortened(d, d.flow), *bodies]


def _accelerations(d: Derivation, rates: Sequence[Node]) -> list[Node]:
    tape, along = d.binding.tape, dict(zip(d.state, d.derivative, strict=True))
    short = len(tape.needed((*d.derivative, *rates))) <= MOST_OPERATIONS
    inputs = frozenset(d.binding.inputs)
    known = [rate for rate in rates if short and not tape.depends_on(rate) & inputs]
    found = dict(zip(known, _shortened(d, tape.derivative(known, along)), strict=True))
    return [found.get(rate, tape.constant(math.nan)) for rate in rates]


FORMULAS: Kind[tuple[ModeFormulas, ...]] = pickled("formulas", tuple)  # of all modes, by a key

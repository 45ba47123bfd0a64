"""What a machine does over whole boxes of states, enclosed by interval arithmetic.

Formulas of a machine are derived once and kept on disk as data, so that this needs no symbols.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.cache import key_of, read_record, write_record
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.dynamics.model import Model
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray

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


# Plans are verified again and again while they are improved; what was read for a machine stays.
_read: WeakKeyDictionary[Model, tuple[ModeFormulas, ...]] = WeakKeyDictionary()


class Enclosures:
    """Bounds of what a machine does over boxes of states.

    Args:
        model: The machine; without its feedback.
    """

    def __init__(self, model: Model) -> None:
        self._model = model.plant
        if self._model not in _read:
            _read[self._model] = _kept(self._model)
        self._modes = _read[self._model]

    def speed(self, x: IntervalArray, u: Array) -> Array:
        """Return bounds on the speed of all points, in [m/s], shape (m,); infinite at a jump.

        Args:
            x: Boxes of states, shape (m, nx); a box lies within one mode.
            u: Inputs of each, shape (m, nu).
        """
        bounds = self._enclosed(lambda mode: mode.speeds, x, u).high
        signs = self._enclosed(lambda mode: mode.signs, x, u)
        jumps = np.any(np.sign(signs.low) != np.sign(signs.high), axis=1)
        return np.where(jumps, np.inf, bounds.max(axis=1, initial=0.0))

    def requirements(self, x: IntervalArray, u: Array) -> IntervalArray:
        """Return the machine's requirements over boxes, shape (m, number of requirements).

        Args:
            x: As ``speed``.
            u: As ``speed``.
        """
        return self._enclosed(lambda mode: mode.requirements, x, u, undefined=True)

    def requirement_sizes(self, x: Array, u: Array) -> Array:
        """Return how large the terms of the requirements are, shape (m, number of requirements).

        Args:
            x: States, shape (m, nx).
            u: Inputs, shape (m, nu).
        """
        sizes = np.empty((len(u), len(self._modes[0].requirements.ends)))
        box = IntervalArray(x, x)
        for mode, rows in self._by_mode(x):
            values = {name: one.low for name, one in self._values(mode, box, u, rows).items()}
            for i, size in enumerate(mode.requirements.sizes(values)):
                sizes[rows, i] = size
        return sizes

    def frames(self, x: IntervalArray, u: Array) -> IntervalArray:
        """Return the rows of [R | p] of all bodies over boxes, shape (m, bodies, 12).

        Args:
            x: As ``speed``.
            u: As ``speed``.
        """
        found = self._enclosed(lambda mode: mode.frames, x, u)
        return IntervalArray(found.low.reshape(len(u), -1, 12), found.high.reshape(len(u), -1, 12))

    def velocities(self, x: IntervalArray, u: Array) -> IntervalArray:
        """Return all velocities over boxes, shape (m, number of velocities).

        Args:
            x: As ``speed``.
            u: As ``speed``.
        """
        return self._enclosed(lambda mode: mode.velocities, x, u)

    def _enclosed(
        self,
        which: Callable[[ModeFormulas], Formulas],
        x: IntervalArray,
        u: Array,
        *,
        undefined: bool = False,
    ) -> IntervalArray:
        """Enclose formulas over boxes; from minus infinity where they may be ``undefined``."""
        count = max(len(which(mode).ends) for mode in self._modes)
        low, high = np.zeros((len(u), count)), np.zeros((len(u), count))
        for mode, rows in self._by_mode(x.low):
            gaps: list[NDArray[np.bool_]] = []
            values = self._values(mode, x, u, rows)
            found = which(mode).enclose(values, gaps if undefined else None)
            for i, one in enumerate(found):
                low[rows, i], high[rows, i] = one.low, one.high
            for gap in gaps:
                low[rows[np.broadcast_to(gap, len(rows))]] = -np.inf
        return IntervalArray(low, high)

    def _by_mode(self, x: Array) -> Iterator[tuple[ModeFormulas, NDArray[np.intp]]]:
        """Yield the modes that states (m, nx) are in, with their rows."""
        of = np.round(x[:, -1]) if len(self._modes) > 1 else np.zeros(len(x))
        for k in np.unique(of):
            yield self._modes[int(k)], np.flatnonzero(of == k)

    def _values(
        self, mode: ModeFormulas, x: IntervalArray, u: Array, rows: NDArray[np.intp]
    ) -> dict[str, IntervalArray]:
        parameters = map(intervals.point, self._model.parameter_vector())
        values = dict(zip(mode.parameters, parameters, strict=True))
        values |= zip(mode.inputs, map(intervals.point, u[rows].T), strict=True)
        ends = zip(x.low[rows].T, x.high[rows].T, strict=True)
        return values | dict(zip(mode.state, (IntervalArray(*pair) for pair in ends), strict=False))


def _kept(model: Model) -> tuple[ModeFormulas, ...]:
    """Return the formulas of every mode from the disk, derived where they are not there."""
    key = key_of(f"{model.key} enclosures")
    match read_record(key):
        case tuple() as kept if kept and all(isinstance(one, ModeFormulas) for one in kept):
            return kept
    made = _derived(model)
    write_record(key, made)
    return made


def _derived(model: Model) -> tuple[ModeFormulas, ...]:
    from kinolab.dynamics.derivation.derivation import derive
    from kinolab.dynamics.mode_derivations import derive_modes

    if model.system.modes:
        derivations = [mode.derivation for mode in derive_modes(model.system)]
    else:
        derivations = [derive(model.system)]
    return tuple(map(_formulas_of, derivations))


def _formulas_of(d: Derivation) -> ModeFormulas:
    operations = d.binding.tape.operations
    state, inputs, parameters = (
        tuple(operations[node].label for node in nodes)
        for nodes in (d.state, d.binding.inputs, d.binding.parameters)
    )
    tape, places = d.binding.tape, (*d.frames, *d.cables)
    signs = [
        operations[node].operands[0]
        for node in tape.needed(places)
        if operations[node].name == "sign"
    ]
    speeds, requirements, velocities, frames, changes = (
        Formulas.of(tape, nodes)
        for nodes in (
            (*d.point_speeds, *d.cable_speeds), d.requirements, d.velocities, d.frames, signs
        )
    )  # fmt: skip
    return ModeFormulas(
        state, inputs, parameters, speeds, requirements, velocities, frames, changes
    )

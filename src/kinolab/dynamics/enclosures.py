"""What a machine does over whole boxes of states, enclosed by interval arithmetic.

Formulas of a machine are derived once and kept on disk as data, so that this needs no symbols.
"""

from __future__ import annotations

from collections.abc import Callable
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
    """

    state: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    speeds: Formulas
    requirements: Formulas
    velocities: Formulas


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
        """Return bounds on the speed of all points, in [m/s], shape (m,).

        Args:
            x: Boxes of states, shape (m, nx); a box lies within one mode.
            u: Inputs of each, shape (m, nu).
        """
        bounds = self._enclosed(lambda mode: mode.speeds, x, u).high
        return np.asarray(bounds.max(axis=1, initial=0.0))

    def requirements(self, x: IntervalArray, u: Array) -> IntervalArray:
        """Return the machine's requirements over boxes, shape (m, number of requirements).

        Args:
            x: As ``speed``.
            u: As ``speed``.
        """
        return self._enclosed(lambda mode: mode.requirements, x, u)

    def velocities(self, x: IntervalArray, u: Array) -> IntervalArray:
        """Return all velocities over boxes, shape (m, number of velocities).

        Args:
            x: As ``speed``.
            u: As ``speed``.
        """
        return self._enclosed(lambda mode: mode.velocities, x, u)

    def _enclosed(
        self, which: Callable[[ModeFormulas], Formulas], x: IntervalArray, u: Array
    ) -> IntervalArray:
        count = len(which(self._modes[0]).ends)
        low, high = np.empty((len(u), count)), np.empty((len(u), count))
        of = np.round(x.low[:, -1]) if len(self._modes) > 1 else np.zeros(len(u))
        for k in np.unique(of):
            rows, mode = np.flatnonzero(of == k), self._modes[int(k)]
            found = which(mode).enclose(self._values(mode, x, u, rows))
            for i, one in enumerate(found):
                low[rows, i], high[rows, i] = one.low, one.high
        return IntervalArray(low, high)

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
    speeds, requirements, velocities = (
        Formulas.of(d.binding.tape, nodes)
        for nodes in ((*d.point_speeds, *d.cable_speeds), d.requirements, d.velocities)
    )
    return ModeFormulas(state, inputs, parameters, speeds, requirements, velocities)

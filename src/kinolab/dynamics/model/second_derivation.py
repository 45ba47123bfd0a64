"""A machine's state derivative by its second derivation, from energies and multipliers.

It is derived once and kept on disk as data, so that comparing with it needs no symbols.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from kinolab.dynamics.lagrange.multiplier_form import MultiplierForm
from kinolab.dynamics.model.model import Model
from kinolab.numerics.arrays import Array
from kinolab.store import pickled

FORMS = pickled("multipliers", MultiplierForm)

# Plans are verified again and again while they are improved; what was read for a machine stays.
_read: WeakKeyDictionary[Model, dict[int, MultiplierForm]] = WeakKeyDictionary()


class SecondDerivation:
    """The equations of motion of a machine without its feedback, as ``MultiplierForm`` has them."""

    def __init__(self, model: Model) -> None:
        self._model = model.plant
        self._forms = _read.setdefault(self._model, {})

    def derivative(self, x: Array, u: Array) -> Array:
        """Return the derivatives of states (m, nx) under the plant's inputs (m, nu), (m, nx).

        They are NaN where something is undefined.
        """
        x, u = np.asarray(x, dtype=float), np.asarray(u, dtype=float)
        if not self._model.machine.modes:
            return self._form(0).derivative(x, u)
        changes = np.zeros_like(x)
        for mode in np.unique(x[:, -1]):
            rows = x[:, -1] == mode
            changes[rows] = self._form(int(mode)).derivative(x[rows], u[rows])
        return changes

    def _form(self, mode: int) -> MultiplierForm:
        if mode not in self._forms:
            content = self._model.key, str(mode)
            self._forms[mode] = FORMS.get(content, lambda: self._derived(mode))
        return self._forms[mode]

    def _derived(self, mode: int) -> MultiplierForm:
        from kinolab.dynamics.derivation.velocity_coordinates import chosen_quasi_velocities
        from kinolab.dynamics.facts.mode_derivations import machine_in_mode
        from kinolab.dynamics.lagrange.multiplier_equations import multiplier_form

        model, system = self._model, self._model.system
        if system.modes:
            system = machine_in_mode(system, mode)
        quasi = chosen_quasi_velocities(system) if model.quasi_velocities else ()
        return multiplier_form(system, quasi, [model.rate_names[i] for i in model.independent])

"""Friction and other forces that feed energy into a machine whose inputs are zero."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from kinolab.analyze.examine.law_check import LawCheck
from kinolab.dynamics import Model, System
from kinolab.dynamics.language.constraints import Requirement
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.mechanism_parts import atoms_of, loads_in
from kinolab.dynamics.language.symbols import (
    InputSymbol,
    Parameter,
    ReferenceSymbol,
    StateSymbol,
)

ROUNDING = 1e-9  # of the largest power of a force: a smaller one counts as zero


def energy_sources(model: Model, states: NDArray[np.float64]) -> Iterator[LawCheck]:
    """Yield the forces whose work is positive though the machine's inputs are zero.

    Friction must not do any. A wrench may, such as a wind's; but if it does so however the motion
    is reversed, it is friction with the wrong sign.

    Args:
        model: The machine.
        states: Where forces are looked at, shape (m, nx).
    """
    system = System.of(model.system)
    suspects = [effort for effort in system.efforts if _may_feed(effort)]
    if not suspects or system.feedback is not None:
        return
    margins = tuple(Requirement(effort.power, f"power {k}") for k, effort in enumerate(suspects))
    watched = system.changed(requirements=margins, flat=None).model()
    reversed_ = states.copy()
    reversed_[:, model.speeds] *= -1.0
    idle = np.zeros(model.nu)
    there, back = (watched.requirements(x, idle) for x in (states, reversed_))
    for k, effort in enumerate(suspects):
        yield from _found(effort, there[:, k], back[:, k])


def _found(
    effort: Effort, there: NDArray[np.float64], back: NDArray[np.float64]
) -> Iterator[LawCheck]:
    """Judge the powers of a force in [W] at states and at the reversed ones, shape (m,) each."""
    largest = max(np.abs(there).max(), np.abs(back).max())
    if not (np.isfinite(largest) and largest > 0):
        return
    both = float(np.minimum(there, back).max() / largest)
    most = float(np.maximum(there, back).max())
    note = f"the {effort} feeds in up to {most:.3g} W while all inputs are 0"
    if both > ROUNDING:
        note += ", whichever way the machine moves; friction has the sign of -velocity"
        yield LawCheck("friction takes energy out", both, ROUNDING, note)
    elif not effort.size and most > ROUNDING * largest:
        note = f"but {note}: right for a wind or a motor that always runs"
        yield LawCheck("no energy comes from nowhere", 0.0, 0.0, note)


def _may_feed(effort: Effort) -> bool:
    """Say whether a force might feed energy in though inputs are zero."""
    driven = InputSymbol | StateSymbol | ReferenceSymbol
    if not any(loads_in(effort)) or any(isinstance(a, driven) for a in atoms_of(effort)):
        return False  # it is, or may be, driven
    if not effort.size:
        return True
    strength = exact(getattr(effort, effort.size))  # numbers and parameters were validated
    return not all(isinstance(a, Parameter) for a in strength.free_symbols)

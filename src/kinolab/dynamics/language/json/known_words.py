"""A machine in words that files know: one from outside the package is put as what it lowers to.

A file names no module and runs no code. A force or input of somebody else's needs neither: it has
lowered itself to potentials, loads and imposed motions, which every reader knows.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Any

import sympy

from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.inputs import Input
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import up_in
from kinolab.dynamics.language.quantities import written
from kinolab.dynamics.symbols.words import primitives_of


def in_known_words(system: Mechanism, known: Collection[type]) -> Mechanism:
    """Return a machine whose forces and inputs have known classes.

    Args:
        system: The machine.
        known: Classes that stay as they are.
    """
    words = (*system.inputs, *system.efforts, *(e for mode in system.modes for e in mode.efforts))
    if all(type(word) in known for word in words):
        return system

    up = up_in(system)

    def plain(word: Any) -> Iterator[Any]:
        if type(word) in known:
            yield word
            return
        for part in primitives_of(word):
            stated = {k: v for k, v in vars(part).items() if isinstance(v, sympy.Expr)}
            yield replace(part, **{k: written(v.xreplace(up)) for k, v in stated.items()})

    parts = [part for word in (*system.efforts, *system.inputs) for part in plain(word)]
    modes = [
        replace(mode, efforts=[part for effort in mode.efforts for part in plain(effort)])
        for mode in system.modes
    ]
    return system.changed(
        inputs=[part for part in parts if isinstance(part, Input)],
        efforts=[part for part in parts if isinstance(part, Effort)],
        modes=modes,
    )

"""A machine in words that files know: one from outside the package is put as what it lowers to.

A file names no module and runs no code. A force or input of somebody else's needs neither: it has
lowered itself to potentials, loads and imposed motions, which every reader knows.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Any

from kinolab.dynamics.language.forces import Effort, Load, Potential
from kinolab.dynamics.language.inputs import Input
from kinolab.dynamics.language.mechanism import Mechanism


def in_known_words(system: Mechanism, known: Collection[type]) -> Mechanism:
    """Return a machine of whose forces and inputs all have known classes.

    Args:
        system: The machine.
        known: Classes that stay as they are.
    """
    words = (*system.inputs, *system.efforts, *(e for mode in system.modes for e in mode.efforts))
    if all(type(word) in known for word in words):
        return system

    def plain(word: Any) -> Iterator[Any]:
        if type(word) in known:
            yield word
            return
        for part in word.lowered():
            yield part.written(system.up) if isinstance(part, Load | Potential) else part

    inputs = [part for entry in system.inputs for part in plain(entry)]
    efforts = [part for effort in system.efforts for part in plain(effort)]
    return system.changed(
        inputs=[part for part in inputs if isinstance(part, Input)],
        efforts=[*efforts, *(part for part in inputs if isinstance(part, Effort))],
        modes=[
            replace(mode, efforts=[part for effort in mode.efforts for part in plain(effort)])
            for mode in system.modes
        ],
    )

"""What a machine's forces and inputs come down to: potentials, loads and imposed motions.

All that derives, checks or writes a machine asks here, and knows no force or input by its name.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import sympy

from kinolab.dynamics.language.expressions import as_written, exact
from kinolab.dynamics.language.forces import Effort, Load, Potential
from kinolab.dynamics.language.inputs import Drive, Input, Rate
from kinolab.dynamics.language.mechanism_parts import MechanismParts
from kinolab.dynamics.language.quantities import UP, written


class ImposedVelocity(NamedTuple):
    """A velocity, linear in the rates, that an input or an auxiliary state imposes.

    Attributes:
        where: What imposes it, for errors.
        velocity: The velocity.
        symbol: What it equals.
        change: The derivative of that; an input is held.
    """

    where: str
    velocity: sympy.Expr
    symbol: sympy.Symbol
    change: sympy.Expr


@lru_cache(maxsize=4096)
def _parts(word: Effort | Input) -> tuple[Effort | Input, ...]:
    return tuple(word.lowered())


def energies_in(word: Effort | Input) -> Iterator[sympy.Expr]:
    """Yield the potential energies of a force in [J]."""
    yield from (part.energy for part in _parts(word) if isinstance(part, Potential))


def loads_in(word: Effort | Input) -> Iterator[Load]:
    """Yield the loads of a force or an input."""
    yield from (part for part in _parts(word) if isinstance(part, Load))


def up_in(system: MechanismParts) -> dict[sympy.Symbol, sympy.Expr]:
    """Return the components of the unit vector against gravity; along z where there is none."""
    down = system.gravity.down if system.gravity is not None else (0, 0, -1)
    return {symbol: as_written(-part) for symbol, part in zip(UP, down, strict=True)}


def potentials(system: MechanismParts) -> Iterator[sympy.Expr]:
    """Yield the potential energies of a machine's forces in [J], weight left out."""
    up = up_in(system)
    for effort in system.efforts:
        yield from (energy.xreplace(up) for energy in energies_in(effort))


def loads(system: MechanismParts, *, dry: bool = True) -> Iterator[tuple[Effort | Input, Load]]:
    """Yield the loads of a machine's forces and inputs, each with the force or input.

    Args:
        system: The machine.
        dry: Whether dry friction counts.
    """
    kept = [effort for effort in system.efforts if dry or effort.sliding is None]
    words: list[Effort | Input] = [*kept, *system.inputs]
    yield from ((word, load) for word in words for load in loads_in(word))


def imposed_velocities(system: MechanismParts) -> list[ImposedVelocity]:
    """Return the velocities that inputs impose, then those that auxiliary states do."""
    zero = sympy.Integer(0)
    rates = (part for entry in system.inputs for part in _parts(entry))
    return [
        *(
            ImposedVelocity(f"input {e.name!r}", written(e.velocity), e.symbol, zero)
            for e in rates
            if isinstance(e, Rate)
        ),
        *(
            ImposedVelocity(f"state {s.name!r}", exact(s.velocity), s.symbol, exact(s.derivative))
            for s in system.states
            if s.velocity is not None
        ),
    ]


def imposed_accelerations(system: MechanismParts) -> dict[str, sympy.Symbol]:
    """Return the inputs that impose the accelerations of coordinates, by the coordinates' names."""
    parts = (part for entry in system.inputs for part in _parts(entry))
    return {part.on.name: part.symbol for part in parts if isinstance(part, Drive)}


def prescribes(entry: Input) -> bool:
    """Whether an input prescribes a motion, and is no symbol in loads."""
    return any(isinstance(part, Rate | Drive) for part in _parts(entry))

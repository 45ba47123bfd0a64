"""The choice of independent velocities: rates of coordinates, or quasi-velocities of frames.

They are those that the author names, or else rates that determine all velocities at a few states,
unless others serve better everywhere (``regularity``).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import comb

import numpy as np

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.regularity import (
    MAX_CHOICES,
    MIN_PIVOT,
    SampledConstraints,
    VelocityChoice,
    left_open,
    margins_of,
    regular_choice,
)
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array


def choose_velocities(
    binding: SymbolTable,
    rows: Sequence[Sequence[Node]],
    samples: Array,
    redundant: Sequence[str] = (),
) -> VelocityChoice:
    """Choose the independent velocities.

    Args:
        rows: Coefficients of all velocities in each condition, (m, nt).
        samples: Their values at a few states, shape (samples, m, nt).
        redundant: Names of constraints that follow from others, of which messages speak.

    Raises:
        InputError: If the author's choice has the wrong size, or none serves.
    """
    system = binding.system
    if system.velocities is not None and not isinstance(system.velocities, str):
        return _named(binding, rows, samples, redundant)
    if not rows:
        return VelocityChoice(())
    free = _free(binding, samples)
    dependent = _rates(system, samples, free)
    if samples.shape[2] <= samples.shape[1] or system.closures:  # no choice, or loops decide on it
        return VelocityChoice(dependent)
    return regular_choice(binding, rows, free, dependent)


def _named(
    binding: SymbolTable,
    rows: Sequence[Sequence[Node]],
    samples: Array,
    redundant: Sequence[str],
) -> VelocityChoice:
    """Take the velocities chosen by the author, three for an attitude."""
    system, quasi, symbols = binding.system, binding.quasi, binding.names(binding.tangent)
    names = [
        symbol.name
        for c in system.velocities or ()
        if not isinstance(c, QuasiVelocity | str)
        for symbol in c.rates
    ]
    count, size = len(rows), len(symbols)
    given = len(names) + len(quasi)
    if given != size - count:
        what = f"{given} velocities are named; {size - count} are independent."
        if not rows:
            what = f"{given} velocities are named; without constraints all are independent."
        if redundant:
            what += (
                f" {redundant[0]!r} follows from the other constraints: is it one of them again?"
            )
        remedy = "" if rows else "Leave velocities out."
        raise InputError([Mistake(f"system {system.name!r}", what, remedy)])
    dependent = tuple(i for i, name in enumerate(symbols) if name not in names)
    if quasi:
        covectors = [binding.slopes(v.velocity)[1] for v in quasi]
        samples = SampledConstraints.of(binding).covectors([*rows, *covectors])
    if left := left_open(samples, dependent) if rows or quasi else ():
        what = "the velocities that are named do not determine "
        what += f"{' and '.join(symbols[i] for i in left)}."
        remedy = "Is a constraint missing there, or does it hold another point? Else name others, "
        remedy += "or leave velocities out."
        raise InputError([Mistake(f"system {system.name!r}", what, remedy)])
    return VelocityChoice(dependent, quasi)


def _rates(system: Mechanism, samples: Array, free: Sequence[int]) -> tuple[int, ...]:
    """Choose the dependent velocities with the best conditioning at the worst sampled state.

    On ties, coordinates created first become dependent, so that later ones remain states.
    """
    candidates = _choices(samples, free)
    margins = [margins_of(samples, dependent) for dependent in candidates]
    best = max(
        range(len(candidates)),
        key=lambda k: (
            round(float(margins[k].min()), 9),
            round(float(np.median(margins[k])), 9),
            -k,
        ),
    )
    if np.median(margins[best]) < MIN_PIVOT:
        what = "no fixed choice of independent velocities works at all sampled states."
        remedy = 'Name them with velocities=[…], or use velocities="all" for multipliers.'
        raise InputError([Mistake(f"system {system.name!r}", what, remedy)])
    return candidates[best]


def _free(binding: SymbolTable, samples: Array) -> list[int]:
    """Return the velocities that may follow from others: all but the driven ones."""
    count, size = samples.shape[1:]
    free = [i for i in range(size) if i not in binding.driven]
    if count > len(free):
        what = f"{count} constraints, rate inputs and speeds act on {len(free)} velocities."
        raise InputError([Mistake(f"system {binding.system.name!r}", what, "Leave some out.")])
    return free


def _choices(samples: Array, free: Sequence[int]) -> list[tuple[int, ...]]:
    count = samples.shape[1]
    if comb(len(free), count) <= MAX_CHOICES:
        return list(combinations(free, count))
    from scipy.linalg import qr

    orders = (qr(sample[:, free], pivoting=True)[2] for sample in samples)
    return [tuple(sorted(free[k] for k in order[:count])) for order in orders]

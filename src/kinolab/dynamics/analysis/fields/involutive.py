"""Integrability of velocity constraints, by the involutive closure of the allowed velocities.

Brackets of allowed motions span the tangent space of the leaf of reachable configurations. The
remaining directions are annihilated by constraints that integrate to position constraints
(Frobenius).

Source: Bloch, Nonholonomic Mechanics and Control, 2003, section 2.9 (Frobenius' theorem).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy
from numpy.typing import NDArray

from kinolab.arguments import checked
from kinolab.dynamics.analysis.fields.bracket_filtration import BracketFiltration
from kinolab.dynamics.analysis.fields.growth_vectors import Filtration, filtration, stacked
from kinolab.dynamics.analysis.fields.integrals import FACTOR_DIGITS, integral_of
from kinolab.dynamics.analysis.fields.linear_controllability import flow_matrix
from kinolab.dynamics.analysis.fields.system_fields import allowed_motions
from kinolab.dynamics.analysis.fields.vector_fields import VectorFields, combination_text
from kinolab.dynamics.analysis.jets.ranks import reduced_rows, scales_of
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.velocity_coordinates import (
    ConstraintRow,
    constraint_rows,
    independent_rows,
)
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import tangent_symbols
from kinolab.dynamics.symbols.expressions import as_written
from kinolab.dynamics.symbols.symbols import TurnRate
from kinolab.numerics.arrays import Array

COEFFICIENT_TOLERANCE = 1e-6  # on variation of constant coefficients between configurations


@checked
@dataclass(frozen=True)
class InvolutiveClosure:
    """The involutive closure of the allowed velocities.

    Attributes:
        growth: Growth vector of the allowed motions at regular configurations.
        dimension: Of the configuration space, position constraints deducted.
        integrable: Names of the integrable velocity constraints.
        combinations: Integrable constant combinations of constraints, in names, where no single one
            is integrable; empty where their coefficients vary.
        integrals: Conserved functions of the coordinates, where found: in the author's symbols, or
            linear with numeric coefficients.
        redundant: Names of redundant constraints.
        disguised: Number of independent velocity constraints that are integrable.
        complete: Whether longer brackets provably add nothing.
    """

    growth: tuple[int, ...]
    dimension: int
    integrable: tuple[str, ...]
    combinations: tuple[str, ...]
    integrals: tuple[sympy.Expr, ...]
    redundant: tuple[str, ...]
    disguised: int
    complete: bool

    @property
    def leaf(self) -> int:
        """Dimension of the leaf: the configurations reachable from one."""
        return self.growth[-1] if self.growth else 0

    @property
    def nonholonomic(self) -> int:
        """Number of nonholonomic constraints: they restrict velocities but no configuration."""
        return self.leaf - (self.growth[0] if self.growth else 0)


@checked
def involutive_closure(system: Mechanism) -> InvolutiveClosure:
    """Compute the involutive closure and find a machine's integrable constraints.

    Args:
        system: The machine.

    Raises:
        InputError: If its constraints depend on inputs.
    """
    motions = allowed_motions(system)
    whole = filtration(motions)
    binding = SymbolTable.of(system)
    kept, redundant = independent_rows(binding, constraint_rows(binding))
    names = [row.name for row in kept]
    places = [_Place(binding, motions, whole, kept, point) for point in motions.points]
    held = np.min([place.held for place in places], axis=0)
    closed = [isinstance(c, PositionConstraint) for c in system.constraints if c.name in names]
    positions = sum(closed)
    integrable = [n for n, h, p in zip(names, held, closed, strict=True) if h and not p]
    missing = motions.dimension - whole.rank
    shares = _common([place.shares for place in places])
    shares = shares[[bool((row[~np.array(closed, dtype=bool)] != 0).any()) for row in shares]]
    return InvolutiveClosure(
        growth=whole.growth,
        dimension=motions.dimension,
        integrable=tuple(integrable),
        combinations=tuple(
            combination_text(row, [f"'{name}'" for name in names])
            for row in shares
            if (row != 0).sum() > 1
        ),
        integrals=_integrals(system, places, names, shares) if missing > positions else (),
        redundant=redundant,
        disguised=missing - positions,
        complete=whole.complete,
    )


class _Place:
    """The closure at one configuration, in scaled velocities.

    Attributes:
        scale: Of each velocity, shape (nt,).
        reached: Orthonormal basis of the closure, shape (r, nt).
        missing: Orthonormal basis of its annihilator, shape (nt - r, nt).
        w: Unit covectors of the constraints, shape (m, nt).
        lengths: Their norms before scaling, shape (m,).
    """

    def __init__(
        self,
        binding: SymbolTable,
        motions: VectorFields,
        whole: Filtration,
        rows: Sequence[ConstraintRow],
        point: Mapping[str, float],
    ) -> None:
        values = dict(point)
        layers = BracketFiltration.at(motions, point, max(len(whole.growth), 1))
        brackets = [bracket for layer in layers for bracket in layer]
        flow = np.linalg.pinv(flow_matrix(binding, values))
        moves, sizes = np.zeros((2, 1, len(flow)))
        if brackets:
            moves = stacked(brackets) @ flow.T
            sizes = np.array([bracket.size for bracket in brackets]) @ np.abs(flow.T)
        lengths, scale = scales_of(sizes)
        self.scale = scale[0]
        directions = np.linalg.svd(moves / lengths / scale, full_matrices=True)[2]
        self.reached, self.missing = directions[: whole.rank], directions[whole.rank :]
        flat = binding.tape.evaluate([node for row in rows for node in row.covector], values)
        w = np.reshape(flat, (len(rows), len(self.scale))) * self.scale
        self.lengths = np.linalg.norm(w, axis=1)
        self.w = w / self.lengths[:, None]

    @property
    def held(self) -> NDArray[np.bool_]:
        """Which constraints annihilate the closure, shape (m,)."""
        return np.asarray(
            np.abs(self.w @ self.reached.T).max(axis=1, initial=0.0) < COEFFICIENT_TOLERANCE
        )

    @property
    def shares(self) -> Array:
        """The combinations of constraints that annihilate the closure, in echelon form."""
        left, values, _ = np.linalg.svd(self.w @ self.reached.T, full_matrices=True)
        free = left[:, int((values > COEFFICIENT_TOLERANCE).sum()) :]
        return reduced_rows(free.T / self.lengths, COEFFICIENT_TOLERANCE)

    @property
    def covectors(self) -> Array:
        """The annihilator of the closure, in echelon form and unscaled."""
        return reduced_rows(self.missing / self.scale, COEFFICIENT_TOLERANCE)


def _integrals(
    system: Mechanism, places: Sequence[_Place], names: Sequence[str], shares: Array
) -> tuple[sympy.Expr, ...]:
    """Return conserved functions of the coordinates, linear ones if no others are found.

    Args:
        places: Closures at several configurations.
        shares: Integrable constant combinations of constraints, one per row.
    """
    found = [integral_of(system, dict(zip(names, map(float, row), strict=True))) for row in shares]
    known = tuple(integral for integral in found if integral is not None)
    linear = tuple(_linear_integrals(system, places))
    return known if len(known) >= len(linear) else linear


def _linear_integrals(system: Mechanism, places: Sequence[_Place]) -> Iterator[sympy.Expr]:
    symbols = tangent_symbols(system)
    turning = np.array([isinstance(symbol, TurnRate) for symbol in symbols])
    for row in _common([place.covectors for place in places]):
        if not row[turning].any():
            pairs = zip(row, symbols, strict=True)
            yield sympy.Add(
                *(as_written(round(float(c), FACTOR_DIGITS)) * s.coordinate for c, s in pairs if c)
            )


def _common(tables: Sequence[Array]) -> Array:
    """Return the rows common to all tables, whose numbers of rows may differ."""
    first = tables[0]
    if any(table.shape != first.shape for table in tables):
        return first[:0]
    apart = np.max([np.abs(table - first).max(axis=1, initial=0.0) for table in tables], axis=0)
    return np.asarray(first[apart < COEFFICIENT_TOLERANCE])

"""Ranks of brackets over a prime field: exact, and with nothing to round or scale.

Machine equations are rational in lengths, rates, and sines and cosines of angles, so that they can
be evaluated modulo a prime. At a random point their brackets have the rank of regular states, but
for a chance of about one in 1e16 that a minor happens to vanish.

Source: Schwartz, Fast probabilistic algorithms for verification of polynomial identities, J. ACM
27(4), 1980.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from kinolab.dynamics import VectorFields
from kinolab.dynamics.analysis.fields.bracket_filtration import Bracket, BracketFiltration
from kinolab.dynamics.analysis.fields.points import turning_variables
from kinolab.dynamics.analysis.jets.scalars import AbstractNumbers

PRIME = 2**61 - 1  # of Mersenne


class Residue:
    """A number modulo the prime; an angle also carries its cosine and sine."""

    def __init__(self, value: int, turn: tuple[int, int] | None = None) -> None:
        self.value, self.turn = value % PRIME, turn

    def __add__(self, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        other = residue(other)
        value = self.value + other.value
        if not self.turn or not other.turn:
            turned = self if self.turn and not other.value else other
            return Residue(value, turned.turn if not (self.value and other.value) else None)
        (c, s), (d, t) = self.turn, other.turn
        return Residue(value, ((c * d - s * t) % PRIME, (s * d + c * t) % PRIME))

    def __neg__(self) -> Residue:
        return Residue(-self.value, self.turn and (self.turn[0], -self.turn[1] % PRIME))

    def __sub__(self, other: Any) -> Any:
        return NotImplemented if isinstance(other, np.ndarray) else self + -residue(other)

    def __rsub__(self, other: Any) -> Any:
        return residue(other) + -self

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        other = residue(other)
        if self.turn and other.value == 1:
            return self
        if other.turn and self.value == 1:
            return other
        return Residue(self.value * other.value)

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        return Residue(self.value * pow(residue(other).value, -1, PRIME))

    def __rtruediv__(self, other: Any) -> Any:
        return residue(other) / self

    def __eq__(self, other: object) -> bool:
        return self.value == residue(other).value

    def __hash__(self) -> int:
        return hash(self.value)

    def __bool__(self) -> bool:
        return self.value != 0

    __radd__, __rmul__ = __add__, __mul__


def residue(value: Any) -> Residue:
    """Return a number as a residue; 0.1 is 1/10."""
    if isinstance(value, Residue):
        return value
    exact = Fraction(int(value)) if isinstance(value, int | np.integer) else Fraction(repr(value))
    return Residue(exact.numerator * pow(exact.denominator, -1, PRIME))


class Residues(AbstractNumbers):
    """Numbers modulo the prime."""

    dtype = object

    def constant(self, value: float) -> Residue:
        return residue(float(value))

    def function(self, name: str, value: Any) -> Residue:
        value = residue(value)
        cosine, sine = value.turn or (1, 0)
        assert value.turn or not value.value, f"{name} of what is no angle"
        return Residue({"cos": cosine, "sin": sine}[name])


def growth_over_primes(fields: VectorFields, degree: int, seed: int = 0) -> tuple[int, ...]:
    """Return the strong growth vector at a random point, as far as a degree."""
    rng = random.Random(seed)
    turning = turning_variables(fields)
    point = {name: _random(rng, name in turning) for name in fields.names}
    values = {name: residue(value) for name, value in fields.values.items()} | point
    found: list[Bracket] = []
    ranks = []
    for layer in BracketFiltration.of(fields, values, degree, Residues()):
        found += layer
        ranks.append(rank([[entry.value for entry in bracket.vector] for bracket in found]))
    return tuple(ranks)


def _random(rng: random.Random, turning: bool) -> Residue:
    if not turning:
        return Residue(rng.randrange(PRIME))
    t = rng.randrange(PRIME)  # tangent of half the angle
    share = pow(1 + t * t, -1, PRIME)
    return Residue(rng.randrange(PRIME), ((1 - t * t) * share % PRIME, 2 * t * share % PRIME))


def rank(rows: Sequence[Sequence[int]]) -> int:
    """Return the rank of a matrix modulo the prime, by elimination."""
    matrix, found = [list(row) for row in rows], 0
    for column in range(len(matrix[0]) if matrix else 0):
        pivot = next((i for i in range(found, len(matrix)) if matrix[i][column]), None)
        if pivot is None:
            continue
        matrix[found], matrix[pivot] = matrix[pivot], matrix[found]
        inverse = pow(matrix[found][column], -1, PRIME)
        for i in range(found + 1, len(matrix)):
            factor = matrix[i][column] * inverse % PRIME
            if factor:
                pairs = zip(matrix[i], matrix[found], strict=True)
                matrix[i] = [(a - factor * b) % PRIME for a, b in pairs]
        found += 1
    return found

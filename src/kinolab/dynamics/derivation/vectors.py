"""Vectors and 3x3 matrices of expression graph nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node
from kinolab.dynamics.language.frames import AXES
from kinolab.dynamics.language.shapes import AxisName

Vector: TypeAlias = tuple[Node, Node, Node]
Matrix3: TypeAlias = tuple[Vector, Vector, Vector]  # rows


@dataclass(frozen=True)
class Vectors:
    """Vector algebra on an expression graph."""

    tape: ExpressionGraph

    @property
    def zero(self) -> Vector:
        """The zero vector."""
        return (self.tape.zero,) * 3

    @property
    def identity(self) -> Matrix3:
        """The identity matrix."""
        return self.unit("x"), self.unit("y"), self.unit("z")

    def vector(self, values: Sequence[Node]) -> Vector:
        """Return three nodes as a vector."""
        x, y, z = values
        return x, y, z

    def unit(self, axis: AxisName) -> Vector:
        """Return a unit vector along an axis."""
        return self.vector([self.tape.one if name == axis else self.tape.zero for name in AXES])

    def add(self, *vectors: Vector) -> Vector:
        """Return the sum of vectors."""
        return self.vector([self.tape.sum(column) for column in zip(*vectors, strict=True)])

    def sub(self, a: Vector, b: Vector) -> Vector:
        """Return a - b."""
        return self.vector([self.tape.sub(x, y) for x, y in zip(a, b, strict=True)])

    def scale(self, factor: Node, vector: Vector) -> Vector:
        """Return a multiple of a vector."""
        return self.vector([self.tape.mul(factor, component) for component in vector])

    def cross(self, a: Vector, b: Vector) -> Vector:
        """Return the cross product a x b."""
        tape = self.tape
        x, y, z = (
            tape.sub(tape.mul(a[j], b[k]), tape.mul(a[k], b[j]))
            for j, k in ((1, 2), (2, 0), (0, 1))
        )
        return x, y, z

    def transform(self, matrix: Matrix3, vector: Vector) -> Vector:
        """Return the product of a matrix and a vector."""
        return self.vector([self.tape.dot(row, vector) for row in matrix])

    def transpose(self, matrix: Matrix3) -> Matrix3:
        """Return the transposed matrix."""
        a, b, c = (self.vector(column) for column in zip(*matrix, strict=True))
        return a, b, c

    def turn(self, axis: AxisName, angle: Node, vector: Vector, sign: int) -> Vector:
        """Rotate a vector about an axis by the angle (sign 1) or its negative (sign -1)."""
        tape, i = self.tape, AXES[axis]
        j, k = (i + 1) % 3, (i + 2) % 3
        c, s = tape.unary("cos", angle), tape.unary("sin", angle)
        s = s if sign > 0 else tape.neg(s)
        turned = list(vector)
        turned[j] = tape.sub(tape.mul(c, vector[j]), tape.mul(s, vector[k]))
        turned[k] = tape.add(tape.mul(s, vector[j]), tape.mul(c, vector[k]))
        return self.vector(turned)

"""Formulas and their derivatives as numbers, by forward differentiation.

A hyper-dual number carries a value, its first derivatives along some directions and second ones
along pairs of them. Nothing is differentiated as an expression, and nothing is compiled.

Source: Fike, Alonso, The development of hyper-dual numbers for exact second-derivative
calculations, AIAA 2011-886.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from kinolab.numerics.arrays import Array


@dataclass(frozen=True, eq=False)
class HyperDual:
    """A quantity at m instants.

    Attributes:
        value: Shape (m,).
        slope: Derivatives along all s directions, shape (m, s); None where they are zero.
        bend: Second derivatives along one of the first n and one of the first n + 1 directions,
            shape (m, n, n + 1); None where they are zero.
    """

    value: Array
    slope: Array | None = None
    bend: Array | None = None


@dataclass(frozen=True)
class Instruction:
    """A number, a named variable, or a function of earlier instructions.

    Attributes:
        name: ``number``, ``variable``, ``add``, ``mul``, ``max``, ``power``, ``change`` or one of
            ``FUNCTIONS``; ``change`` is the derivative along the direction after the first n, and
            has none of its own.
        operands: Indices of the instructions that it is a function of.
        number: The number, or the exponent of a power.
        label: Name of the variable.
    """

    name: str
    operands: tuple[int, ...] = ()
    number: float = 0.0
    label: str = ""


def _zero(u: Array) -> Array:
    return np.zeros_like(u)


# f, f' and f'' of the functions that machines are described with
FUNCTIONS: dict[str, Callable[[Array], tuple[Array, Array, Array]]] = {
    "sin": lambda u: (np.sin(u), np.cos(u), -np.sin(u)),
    "cos": lambda u: (np.cos(u), -np.sin(u), -np.cos(u)),
    "tan": lambda u: (np.tan(u), 1 / np.cos(u) ** 2, 2 * np.tan(u) / np.cos(u) ** 2),
    "exp": lambda u: (np.exp(u), np.exp(u), np.exp(u)),
    "log": lambda u: (np.log(u), 1 / u, -1 / u**2),
    "tanh": lambda u: (np.tanh(u), 1 - np.tanh(u) ** 2, -2 * np.tanh(u) * (1 - np.tanh(u) ** 2)),
    "atan": lambda u: (np.arctan(u), 1 / (1 + u**2), -2 * u / (1 + u**2) ** 2),
    "Abs": lambda u: (np.abs(u), np.sign(u), _zero(u)),
    "sign": lambda u: (np.sign(u), _zero(u), _zero(u)),
    "Heaviside": lambda u: (np.heaviside(u, 0.5), _zero(u), _zero(u)),  # in derivatives of max
    "DiracDelta": lambda u: (_zero(u), _zero(u), _zero(u)),  # in derivatives of sign
}


class Evaluation:
    """Evaluates instructions at m instants, each at most once.

    Args:
        instructions: Each after those that it is a function of.
        known: Values of all variables by name, with their derivatives.
        pairs: n, the number of directions along which second derivatives are taken.
    """

    def __init__(
        self, instructions: Sequence[Instruction], known: Mapping[str, HyperDual], pairs: int
    ) -> None:
        self._instructions, self._known, self._pairs = instructions, known, pairs
        self._memo: dict[int, HyperDual] = {}
        self._instants = len(next(iter(known.values())).value)

    def __call__(self, place: int) -> HyperDual:
        """Return the value and the derivatives of an instruction."""
        pending = [place]
        while pending:
            k = pending[-1]
            missing = [i for i in self._instructions[k].operands if i not in self._memo]
            if k in self._memo or not missing:
                pending.pop()
                self._memo.setdefault(k, self._evaluated(self._instructions[k]))
            else:
                pending += missing
        return self._memo[place]

    def _evaluated(self, instruction: Instruction) -> HyperDual:
        operands = [self._memo[k] for k in instruction.operands]
        match instruction.name:
            case "number":
                return HyperDual(np.full(self._instants, instruction.number))
            case "variable":
                return self._known[instruction.label]
            case "add":
                return reduce(_sum, operands)
            case "mul":
                return reduce(self._product, operands)
            case "max":
                return reduce(_larger, operands)
            case "change":
                (u,) = operands
                return HyperDual(_zero(u.value) if u.slope is None else u.slope[:, self._pairs])
            case "power":
                return self._power(operands[0], instruction.number)
            case name:
                return self._composed(operands[0], FUNCTIONS[name](operands[0].value))

    def _power(self, u: HyperDual, n: float) -> HyperDual:
        value, first, second = (
            factor * u.value**power if factor else _zero(u.value)  # 0 times 0**-1 is 0 here
            for factor, power in ((1.0, n), (n, n - 1), (n * (n - 1), n - 2))
        )
        return self._composed(u, (value, first, second))

    def _product(self, a: HyperDual, b: HyperDual) -> HyperDual:
        bend = _added(_scaled(a.value, b.bend), _scaled(b.value, a.bend))
        if a.slope is not None and b.slope is not None:
            bend = _added(bend, self._outer(a.slope, b.slope) + self._outer(b.slope, a.slope))
        slope = _added(_scaled(a.value, b.slope), _scaled(b.value, a.slope))
        return HyperDual(a.value * b.value, slope, bend)

    def _composed(self, u: HyperDual, derivatives: tuple[Array, Array, Array]) -> HyperDual:
        value, first, second = derivatives
        if u.slope is None:
            return HyperDual(value)
        bend = _scaled(second, self._outer(u.slope, u.slope))
        return HyperDual(value, _scaled(first, u.slope), _added(bend, _scaled(first, u.bend)))

    def _outer(self, a: Array, b: Array) -> Array:
        n = self._pairs
        return np.asarray(a[:, :n, None] * b[:, None, : n + 1])


def _sum(a: HyperDual, b: HyperDual) -> HyperDual:
    return HyperDual(a.value + b.value, _added(a.slope, b.slope), _added(a.bend, b.bend))


def _larger(a: HyperDual, b: HyperDual) -> HyperDual:
    first = a.value >= b.value

    def chosen(x: Array | None, y: Array | None) -> Array | None:
        like = y if x is None else x
        if like is None:
            return None
        x, y = (_zero(like) if part is None else part for part in (x, y))
        return np.where(first.reshape(-1, *[1] * (like.ndim - 1)), x, y)

    value = np.where(first, a.value, b.value)
    return HyperDual(value, chosen(a.slope, b.slope), chosen(a.bend, b.bend))


def _added(a: Array | None, b: Array | None) -> Array | None:
    if a is None or b is None:
        return b if a is None else a
    return a + b


def _scaled(factor: Array, a: Array | None) -> Array | None:
    return None if a is None else factor.reshape(-1, *[1] * (a.ndim - 1)) * a

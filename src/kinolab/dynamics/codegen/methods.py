"""Methods of integration, as their coefficients: a new one is one value.

Source: Hairer, Wanner, Solving ODEs II, 2nd ed., sections IV.3 (stability) and IV.7 (Rosenbrock).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinolab.errors import InputError, Mistake

FINEST, LONGEST = 1e-3, 1e9  # |h lambda| between which growth is looked at


@dataclass(frozen=True)
class Method:
    """A one-step method with s stages: Runge's and Kutta's, or a linearly implicit one.

    A step of length h leads from x to x + h sum_i b_i k_i, where stage i solves

        (1 - gamma h J) k_i = f(x + h sum_j a_ij k_j) + sum_j c_ij k_j,    j < i,

    and J is df/dx at x. Without gamma and c it is explicit. Every row of a and c may end early.

    Attributes:
        name: By which scenarios choose it; an identifier.
        order: Of its error, which is O(h^(order + 1)) in a step.
        b: Weights of the stages, s of them.
        a: Weights of former stages in the argument of each stage; row i has at most i entries.
        c: Weights of former stages beside it, as ``a``; none by default.
        gamma: Of the implicit part; 0 for explicit methods.
        geodesic: Whether attitudes turn along great circles, for one stage only (Lie-Euler).

    Raises:
        InputError: If there is no such method, or its order is not what it says for x' = lambda x.
    """

    name: str
    order: int
    b: tuple[float, ...]
    a: tuple[tuple[float, ...], ...]
    c: tuple[tuple[float, ...], ...] = ()
    gamma: float = 0.0
    geodesic: bool = False

    def __post_init__(self) -> None:
        numbers = [self.gamma, *self.b, *(entry for row in (*self.a, *self.c) for entry in row)]
        mistakes = []
        if not self.name.isidentifier():
            mistakes.append("its name is no identifier.")
        if len(self.a) != self.stages or len(self.c) not in (0, self.stages):
            mistakes.append(f"it has {self.stages} weights b, and as many rows has a; so has c.")
        if any(len(row) > i for table in (self.a, self.c) for i, row in enumerate(table)):
            mistakes.append("row i of a and c has at most i entries, the first one none.")
        if not all(map(math.isfinite, numbers)) or self.gamma < 0.0:
            mistakes.append("its coefficients are finite numbers, and gamma is not negative.")
        if self.geodesic and self.stages != 1:
            mistakes.append("along great circles goes a method of one stage.")
        if not mistakes and not self._has_order():
            mistakes.append(f"it is not of order {self.order} for x' = lambda x.")
        if mistakes:
            remedy = "Take the coefficients from a table such as Hairer's and Wanner's."
            where = f"integration method {self.name!r}"
            raise InputError([Mistake(where, what, remedy) for what in mistakes])

    @classmethod
    def of_lists(
        cls,
        name: str,
        *,
        order: int,
        a: Sequence[Sequence[float]],
        b: Sequence[float],
        c: Sequence[Sequence[float]] = (),
        gamma: float = 0.0,
    ) -> Method:
        """Return a method whose coefficients are in lists, as files have them."""
        a_rows, c_rows = (tuple(tuple(map(float, row)) for row in rows) for rows in (a, c))
        return cls(name, order, tuple(map(float, b)), a_rows, c_rows, float(gamma))

    @property
    def stages(self) -> int:
        """How often f is evaluated in a step."""
        return len(self.b)

    @property
    def implicit(self) -> bool:
        """Whether a step solves linear equations with the derivative of f."""
        return self.gamma > 0.0

    def growth(self, z: complex) -> complex:
        """Return the factor R(h lambda) by which a step changes x where x' = lambda x."""
        k: list[complex] = []  # h times the stages, by x
        for i in range(self.stages):
            at = 1.0 + sum(w * each for w, each in zip(self.a[i], k, strict=False))
            beside = sum(w * each for w, each in zip(self.c[i], k, strict=False)) if self.c else 0.0
            k.append((z * at + beside) / (1.0 - self.gamma * z))
        return 1.0 + sum(w * each for w, each in zip(self.b, k, strict=True))

    @cached_property
    def stability(self) -> float:
        """The largest r for which |R(-s)| <= 1 for all s <= r; infinite if that is so for all."""
        below = FINEST
        for above in np.geomspace(FINEST, LONGEST, 4000).tolist():
            if abs(self.growth(-above)) > 1.0 + 1e-12:
                break
            below = above
        else:
            return math.inf
        for _ in range(60):
            middle = 0.5 * (below + above)
            stable = abs(self.growth(-middle)) <= 1.0
            below, above = (middle, above) if stable else (below, middle)
        return below

    def _has_order(self) -> bool:
        """Whether R(z) is exp(z) up to what a step of the order leaves."""
        steps = [2.0**-k for k in range(2, 6)]
        return all(
            abs(self.growth(sign * z) - math.exp(sign * z)) <= z ** (self.order + 1) + 1e-14
            for z in steps
            for sign in (1.0, -1.0)
        )


METHODS: dict[str, Method] = {}  # by their names


def add_method(method: Method) -> Method:
    """Let models and scenarios integrate by a method; returns it.

    Machines that are described afterwards are compiled with it.

    Raises:
        InputError: If another one has its name.
    """
    if METHODS.setdefault(method.name, method) != method:
        what = "there is another one of this name."
        where = f"integration method {method.name!r}"
        raise InputError([Mistake(where, what, "Choose another name.")])
    return method


# Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.1
RK4 = add_method(
    Method("rk4", 4, b=(1 / 6, 1 / 3, 1 / 3, 1 / 6), a=((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)))
)
# Iserles, Munthe-Kaas, Norsett, Zanna, Lie-group methods, Acta Numerica 9, 2000, section 2.4
EULER = add_method(Method("euler", 1, b=(1.0,), a=((),), geodesic=True))
# Of order 2 and L-stable: stiff friction decays at any step.
# Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20(4), 1999, equation (3.1)
ROSENBROCK = add_method(
    Method("rosenbrock", 2, b=(1.5, 0.5), a=((), (1.0,)), c=((), (-2.0,)), gamma=1 - 0.5**0.5)
)

"""Methods of integration, as their coefficients: a new one is one value.

Source: Hairer, Wanner, Solving ODEs II, 2nd ed., sections IV.3 (stability) and IV.7 (Rosenbrock).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from keyword import iskeyword

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics.codegen.order_conditions import HIGHEST, order_of
from kinolab.errors import InputError, Mistake

FINEST, LONGEST = 1e-3, 1e9  # |h lambda| between which growth is looked at


@checked
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
        InputError: If there is no such method, or it is not of its order.
    """

    name: str
    order: int
    b: Sequence[float]
    a: Sequence[Sequence[float]]
    c: Sequence[Sequence[float]] = ()
    gamma: float = 0.0
    geodesic: bool = False

    def __post_init__(self) -> None:
        for name, rows in (("a", self.a), ("c", self.c)):
            object.__setattr__(self, name, tuple(tuple(map(float, row)) for row in rows))
        object.__setattr__(self, "b", tuple(map(float, self.b)))
        where = f"integration method {self.name!r}"
        if mistakes := [Mistake(where, *found) for found in self._mistakes()]:
            raise InputError(mistakes)

    def _mistakes(self) -> Iterator[tuple[str, str]]:
        """Yield what is wrong, and what would work."""
        if not self.name.isidentifier() or iskeyword(self.name):
            yield "its name is not an identifier.", "Use letters, digits and underscores."
        numbers = ([self.gamma], self.b, *self.a, *self.c)
        rows = "Give a row for each weight; row i has at most i entries, the first one none."
        if len(self.a) != self.stages or len(self.c) not in (0, self.stages):
            what = f"it has {self.stages} weights b, {len(self.a)} rows a and {len(self.c)} rows c."
            yield what, rows
        elif any(len(row) > i for table in (self.a, self.c) for i, row in enumerate(table)):
            yield "a row of a or c is too long.", rows
        elif self.gamma < 0.0 or not all(map(math.isfinite, chain(*numbers))):
            yield "a coefficient is not finite, or gamma is negative.", "Give other numbers."
        elif not 1 <= self.order <= HIGHEST:
            yield f"its order is {self.order}.", f"Give a whole number from 1 to {HIGHEST}."
        elif (order := order_of(self.b, self.a, self.c, self.gamma, self.order)) < self.order:
            remedy = "Give that order, or coefficients of the form that Method describes."
            yield f"it is not of order {self.order}, but of order {order}.", remedy
        if self.geodesic and self.stages != 1:
            yield "along great circles goes a method of one stage.", "Leave geodesic out."

    @property
    def stages(self) -> int:
        """How often f is evaluated in a step."""
        return len(self.b)

    @property
    def implicit(self) -> bool:
        """Whether a step solves linear equations with the derivative of f."""
        return self.gamma > 0.0

    def evaluations(self, nx: int) -> int:
        """Return how many evaluations of f with nx states a step is worth.

        The derivative and the solution of an implicit step are worth two for each state, measured
        on seven machines of 8 to 24 states, within a factor of two.
        """
        return self.stages + 2 * nx * self.implicit

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


METHODS: dict[str, Method] = {}  # by their names


def add_method(method: Method) -> Method:
    """Let scenarios that are read, and models that are made, from now on use a method; returns it.

    Raises:
        InputError: If another one has its name.
    """
    if METHODS.setdefault(method.name, method) != method:
        what = "kinolab, or something before, has another one of this name."
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
SHIPPED = frozenset(METHODS)  # the names of all others need their coefficients in files

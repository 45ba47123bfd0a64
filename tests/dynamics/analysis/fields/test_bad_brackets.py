"""Bad brackets, and their sums over exchanges of inputs, against brackets as expressions."""

from __future__ import annotations

from functools import cache
from itertools import permutations

import numpy as np
import pytest
import sympy as sp

from kinolab.dynamics import VectorField, VectorFields, lie_bracket
from kinolab.dynamics.analysis.fields.bad_brackets import is_bad, symmetrised
from kinolab.dynamics.analysis.fields.bracket_filtration import BracketFiltration, Word

x, y = sp.symbols("x y", real=True)
COMPONENTS = {
    "drift": (x * y + y**3, x**2 - y),
    "u": (1 + y**2, x),
    "v": (y - x**2, 2 + x * y),
}
FIELDS = VectorFields.of(
    (x, y), {"u": COMPONENTS["u"], "v": COMPONENTS["v"]}, drift=COMPONENTS["drift"]
)


@cache
def bracket(word: Word) -> VectorField:
    """The bracket of a word, multiplied out."""
    if len(word) == 1:
        return VectorField((x, y), COMPONENTS[word[0]])
    made = lie_bracket(bracket(word[:1]), bracket(word[1:]))
    return VectorField((x, y), [sp.expand(component) for component in made.components])


def test_a_bad_bracket_has_an_odd_number_of_drifts_and_an_even_one_of_each_input() -> None:
    assert is_bad(("drift",))
    assert is_bad(("u", "drift", "u"))
    assert is_bad(("v", "u", "drift", "v", "u"))
    assert not is_bad(("u",))
    assert not is_bad(("drift", "u"))
    assert not is_bad(("u", "drift", "v"))
    assert not is_bad(("drift", "u", "drift", "u"))


@pytest.mark.parametrize("degree", [3, 5])
def test_sums_over_exchanges_are_those_of_expressions(degree: int) -> None:
    """At (1/2, -1/3), of all bad brackets; those that are left out are sums of one kept."""
    point = {"x": 0.5, "y": -1 / 3}
    layer = list(BracketFiltration.at(FIELDS, point, degree))[-1]
    found = symmetrised(layer, ("u", "v"))
    assert 0 < len(found) <= sum(is_bad(one.word) for one in layer)
    for one in found:
        names = [dict(zip("uv", other, strict=True)) for other in permutations("uv")]
        words = [tuple(name.get(part, part) for part in one.word) for name in names]
        exact = sum(
            (bracket(w).at({x: sp.Rational(1, 2), y: -sp.Rational(1, 3)}) for w in words),
            sp.zeros(2, 1),
        )
        expected = np.array(exact, dtype=float).ravel()
        size = max(1.0, float(np.abs(expected).max()))
        np.testing.assert_allclose(one.vector, expected, rtol=0, atol=1e-11 * size)


def test_with_many_inputs_every_bad_bracket_stands_for_itself() -> None:
    names = [f"u{k}" for k in range(6)]
    fields = VectorFields.of(
        (x, y), {name: (1, k) for k, name in enumerate(names)}, drift=(y, x**2)
    )
    layer = list(BracketFiltration.at(fields, {"x": 0.3, "y": 0.1}, 3))[-1]
    assert len(symmetrised(layer, names)) == sum(is_bad(one.word) for one in layer)

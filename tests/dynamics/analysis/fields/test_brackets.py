"""Lie brackets against SymPy's own differential geometry, and by the laws that they obey."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
import sympy as sp
from sympy.diffgeom import CoordSystem, Manifold, Patch

from kinolab import systems
from kinolab.dynamics import VectorField, VectorFields, lie_bracket, vector_fields
from kinolab.dynamics.analysis.fields.bracket_filtration import BracketFiltration
from kinolab.dynamics.lagrange.printing import written_length
from kinolab.dynamics.symbols.expressions import as_written
from kinolab.errors import InputError

SYMBOLS = x, y, z = sp.symbols("x y z", real=True)
FIELDS = [
    VectorField(SYMBOLS, (sp.sin(y), x * z, 1)),
    VectorField(SYMBOLS, (x**2, sp.cos(x) * y, z - y)),
    VectorField(SYMBOLS, (sp.exp(z), 0, x * y * z)),
]


@pytest.mark.parametrize(("f", "g"), list(combinations(FIELDS, 2)))
def test_brackets_are_those_of_sympys_differential_geometry(f: VectorField, g: VectorField) -> None:
    space = CoordSystem("C", Patch("P", Manifold("M", 3)), sp.symbols("a b c", real=True))
    functions, bases = space.base_scalars(), space.base_vectors()
    named = dict(zip(SYMBOLS, functions, strict=True))

    def on_manifold(field: VectorField) -> sp.Expr:
        terms = zip(field.components, bases, strict=True)
        return sp.Add(*(sp.sympify(c).subs(named) * e for c, e in terms))

    v, w = on_manifold(f), on_manifold(g)
    for component, function in zip(lie_bracket(f, g).components, functions, strict=True):
        other = v.rcall(w.rcall(function)) - w.rcall(v.rcall(function))
        assert sp.simplify(other - component.subs(named)) == 0


def test_brackets_are_antisymmetric() -> None:
    forth, back = lie_bracket(*FIELDS[:2]), lie_bracket(*FIELDS[1::-1])
    assert all(
        sp.expand(a + b) == 0 for a, b in zip(forth.components, back.components, strict=True)
    )


def test_brackets_obey_jacobis_identity() -> None:
    f, g, k = FIELDS
    cycle = [(f, g, k), (g, k, f), (k, f, g)]
    parts = [lie_bracket(a, lie_bracket(b, c)).components for a, b, c in cycle]
    assert all(sp.expand(sum(column)) == 0 for column in zip(*parts, strict=True))


def test_the_unicycles_bracket_is_moving_aside() -> None:
    theta = sp.Symbol("theta", real=True)
    drive = VectorField((x, y, theta), (sp.cos(theta), sp.sin(theta), 0))
    turn = VectorField((x, y, theta), (0, 0, 1))
    assert lie_bracket(turn, drive).components == (-sp.sin(theta), sp.cos(theta), 0)


def test_fields_of_different_variables_have_no_bracket() -> None:
    with pytest.raises(InputError, match="the fields have different variables"):
        lie_bracket(FIELDS[0], VectorField((x, y), (1, 0)))


def test_a_field_has_a_component_per_variable() -> None:
    with pytest.raises(InputError, match="it has 2 components for 3 variables"):
        VectorField(SYMBOLS, (1, 0))


def test_a_machines_fields_are_its_equations_of_motion() -> None:
    """x_dot = drift + sum of u g, against the compiled model; the symbols are the author's."""
    disk = systems.get("rolling_disk")
    fields, model = vector_fields(disk), disk.model()
    state, u = np.array([0.3, -1.0, 0.7, 2.0, 0.4, -1.5]), np.array([0.6, -0.2])
    values = dict(zip(fields.symbols, state, strict=True)) | {
        p: disk.parameter_values[p.name] for p in disk.parameters
    }
    drift, drive, steer = (fields.field(n).at(values) for n in ("drift", "drive", "steer"))
    found = np.array(drift + u[0] * drive + u[1] * steer, dtype=float).ravel()
    np.testing.assert_allclose(found, model.f(state, u), rtol=1e-13, atol=1e-13)


def test_the_disks_fields_read_as_on_paper() -> None:
    """3/2 m R^2 phi_ddot = drive, 1/4 m R^2 psi_ddot = steer."""
    fields = vector_fields(systems.get("rolling_disk"))
    assert str(fields.field("drive").tidy()).endswith("φ̇: 2/(3 m R²)")
    assert str(fields.field("steer").tidy()).splitlines()[4] == "ψ̇: 4/(m R²)"


def test_an_unknown_field_is_refused_with_those_there_are() -> None:
    fields = vector_fields(systems.get("pendulum"))
    with pytest.raises(
        InputError, match=r"no vector field is called 'push'\. Known: drift, torque"
    ):
        fields.field("push")


@pytest.mark.parametrize(
    ("name", "degree"), [("rolling_disk", 3), ("unicycle2_v0", 3), ("acrobot_v0", 2)]
)
def test_brackets_at_a_point_need_no_expressions(name: str, degree: int) -> None:
    """Those of jets are those that SymPy differentiates."""
    system = systems.get(name)
    fields = vector_fields(system)
    point = dict(fields.points[0])
    values = {s: point[s.name] for s in fields.symbols}
    values |= {p: system.parameter_values[p.name] for p in system.parameters}
    for layer in BracketFiltration.at(fields, point, degree):
        for bracket in layer:
            *outer, inner = bracket.word
            expected = fields.field(inner)
            for word in reversed(outer):
                expected = lie_bracket(fields.field(word), expected)
            vector = np.array(expected.at(values), dtype=float).ravel()
            size = np.abs(vector).max(initial=1.0)
            np.testing.assert_allclose(bracket.vector, vector, rtol=0, atol=1e-9 * size)


def test_a_field_too_long_to_write_is_told_by_its_length() -> None:
    """Each step of x -> x cos(x) + y doubles the length l and adds 4: 5 * 2^100 - 4 after 100."""
    tower = x
    for _ in range(100):
        tower = sp.Add(sp.Mul(tower, sp.cos(tower)), y)
    assert written_length(tower) == 5 * 2**100 - 4
    field = VectorField((x, y), (tower, 1))
    assert str(field.tidy()).startswith("x: an expression of length 6e+30")


def test_lengths_count_what_is_written() -> None:
    assert written_length(x) == 1
    assert written_length(x + y) == 3
    assert written_length(sp.sin(x) * y**2) == 6


def test_fields_without_one_component_per_symbol_are_refused() -> None:
    with pytest.raises(InputError, match="vector field 'g': it has 2 components; the state has 3"):
        VectorFields.of(SYMBOLS, {"g": (1, 0)})


@pytest.mark.parametrize(
    ("value", "expected"), [(0.1, "1/10"), (0.0975, "39/400"), (1 / 3, "1/3"), (-2.5, "-5/2")]
)
def test_numbers_read_as_they_were_written(value: float, expected: str) -> None:
    assert str(as_written(value)) == expected
    assert float(as_written(value)) == value


def test_numbers_with_long_decimals_stay_what_they_are() -> None:
    assert as_written(np.pi) == sp.Float(np.pi)

"""Flat maps: symbols, expressions on arrays, what a machine may say, and what cranes do."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import sympy

from kinolab import systems
from kinolab.dynamics import (
    CURVATURE,
    Body,
    FlatOutputs,
    Force,
    PlaneCurves,
    System,
    angle,
    length,
    move,
    output,
    parameter,
    rate,
    rot_z,
)
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import InputError
from tests.oracles import crane as newton

a, b = sympy.symbols("a b")


def evaluate(expression: sympy.Expr, values: Mapping[sympy.Symbol, Any]) -> Any:
    """An expression at values of its symbols, lowered as a machine's flat map is."""
    tape = ExpressionGraph()
    lower = Lowering(tape, {symbol: tape.variable(str(symbol)) for symbol in values})
    named = {str(symbol): np.asarray(value, float) for symbol, value in values.items()}
    return Formulas.of(tape, [lower(expression)])(named)[0]


SMOOTH = [
    sympy.sin(a) * sympy.cos(b) - sympy.tan(a / 2),
    sympy.atan(a * b) + sympy.tanh(b),
    sympy.exp(-(a**2)) / (1 + b**2),
    sympy.log(2 + a) * sympy.sqrt(1 + b**2),
    sympy.Abs(a - b) + sympy.sign(b),
    (1 + a**2) ** sympy.Rational(-3, 2) - a**3,
    2 ** (a / 3),
    -a,
    sympy.Integer(7) / 3,
]


@pytest.mark.parametrize("expression", SMOOTH, ids=str)
def test_an_expression_on_arrays_is_what_sympy_makes_of_it(expression: sympy.Expr) -> None:
    generator = np.random.default_rng(0)
    x, y = generator.uniform(-1.4, 1.4, 50), 0.7
    found = evaluate(expression, {a: x, b: y})
    expected = [float(expression.subs({a: value, b: y})) for value in x]
    assert np.broadcast_to(found, 50) == pytest.approx(np.array(expected), abs=1e-12)


def test_a_symbol_without_a_value_is_named() -> None:
    with pytest.raises(InputError, match="b"):
        evaluate(a + b, {a: 1.0})


def test_outputs_are_told_apart_by_name_and_order() -> None:
    assert output("X") == output("X", 0)
    assert len({output("X"), output("X", 1), output("X", 2), output("Z")}) == 4
    assert str(output("X", 2)) == "X''"


def machine(flat: PlaneCurves | FlatOutputs | None, name: str = "glider") -> System:
    frame = move(X, Y)
    body = Body("body", frame, mass=M)
    inputs = [Force("east", on=body, along=frame.x, limit=1.0)]
    return System(name, bodies=[body], inputs=inputs, flat=flat)


X, Y, M = length("x"), length("y"), parameter("m", 2.0, "kg")


def test_a_coordinate_of_another_machine_is_refused() -> None:
    with pytest.raises(InputError) as caught:
        machine(PlaneCurves(X, Y, angle("psi")))
    assert "flat: psi is no coordinate of the machine." in str(caught.value)


@pytest.mark.parametrize("stranger", [sympy.Symbol("k"), output("Q"), output("U", 3)])
def test_a_symbol_that_means_nothing_is_refused_with_what_would_work(
    stranger: sympy.Symbol,
) -> None:
    with pytest.raises(InputError) as caught:
        machine(FlatOutputs(outputs=(("U", X),), determined=((X, output("U") + stranger),)))
    expected = (
        f"system 'glider' flat determined x: the symbol {stranger} means nothing here. "
        "Use output(name, order) up to order 2 of the outputs U, coordinates listed before, and "
        "parameters."
    )
    assert str(caught.value) == expected


@pytest.mark.parametrize(
    ("outputs", "determined", "words"),
    [
        (
            (("U", X), ("V", Y)),
            ((X, output("U")),),
            "outputs 'V': it is defined by y, which the outputs do not determine. Add (y, …) to",
        ),
        (
            (("U", X), ("V", Y)),
            ((X, output("U") - Y), (Y, output("V"))),
            "determined x: it is a function of y, which is not determined before it. Put (y, …)",
        ),
        (
            (("U", rate(X)),),
            ((X, output("U")),),
            "outputs 'U': the symbol x_dot means nothing here. Define an output by coordinates",
        ),
        (
            (("U", X), ("U", Y)),
            ((X, output("U")), (Y, output("U"))),
            "outputs 'U': 2 outputs have this name. Give each a name of its own.",
        ),
    ],
)
def test_a_flat_map_that_cannot_be_evaluated_says_where_and_what_would_work(
    outputs: Any, determined: Any, words: str
) -> None:
    with pytest.raises(InputError) as caught:
        machine(FlatOutputs(outputs=outputs, determined=determined))
    assert str(caught.value).startswith(f"system 'glider' flat {words}")


@pytest.mark.parametrize("outputs", [{"U": X}, ("U", X), ["U"]])
def test_outputs_are_pairs_and_an_error_shows_how_a_single_one_is_written(outputs: Any) -> None:
    with pytest.raises(InputError) as caught:
        FlatOutputs(outputs=outputs, determined=((X, output("U")),))
    number = "a number or an expression of the machine's symbols"
    pair = f"(a text, {number})"
    assert str(caught.value).startswith("FlatOutputs outputs: it is ")
    assert f". Give a tuple of pairs {pair}; of a single one ({pair},)." in str(caught.value)


def test_a_curve_steers_by_its_curvature_alone() -> None:
    psi = angle("psi")
    body = Body("body", move(X, Y) @ rot_z(psi), mass=M, inertia=0.1)
    with pytest.raises(InputError) as caught:
        System("cart", bodies=[body], flat=PlaneCurves(X, Y, psi, steered=((psi, output("U")),)))
    expected = "flat steered psi: the symbol U means nothing here. Use CURVATURE and parameters."
    assert expected in str(caught.value)


def test_numbers_stand_for_expressions() -> None:
    flat = FlatOutputs(outputs=(("U", X),), determined=((X, output("U")), (Y, 0)))
    assert all(isinstance(e, sympy.Expr) for _, e in flat.determined)
    assert flat.coordinates == (X, Y)
    machine(flat)


@pytest.mark.parametrize("name", ["car", "crane", "diff_drive", "rolling_disk"])
def test_a_flat_map_survives_a_machine_file(name: str) -> None:
    system = systems.get(name)
    text = machine_to_json(system)
    read = machine_from_json(text)
    assert machine_to_json(read) == text
    assert str(read.flat) == str(system.flat)  # coordinates of two machines are never equal


def test_machines_without_a_flat_map_write_none() -> None:
    for name in ("pendulum", "snakeboard", "submarine", "two_cranes"):
        assert systems.get(name).flat is None
        assert "flat" not in json.loads(machine_to_json(systems.get(name)))


def test_a_cars_steering_is_that_of_its_curves_bend() -> None:
    """A circle of radius R about a point beside the rear axle: tan(delta) = L / R."""
    flat = systems.get("car").flat
    assert isinstance(flat, PlaneCurves)
    ((_, steering),) = flat.steered
    (wheelbase,) = steering.free_symbols - {CURVATURE}
    bends = np.array([-0.2, 0.0, 0.1])
    found = evaluate(steering, {CURVATURE: bends, wheelbase: 2.7})
    assert found == pytest.approx(np.arctan(2.7 * bends))


@pytest.mark.parametrize("seed", range(4))
def test_a_cranes_coordinates_follow_from_its_loads_path_as_by_newton(seed: int) -> None:
    """The oracle measures heights from the rail, kinolab from the floor, 9 m below."""
    system, t = systems.get("crane"), sympy.Symbol("t")
    flat = system.flat
    assert isinstance(flat, FlatOutputs)
    amplitudes = np.random.default_rng(seed).uniform(0.1, 0.4, 3)
    path = [
        5 + amplitudes[0] * sympy.sin(t),
        6 + amplitudes[1] * sympy.cos(1.3 * t),
        -5 + amplitudes[2] * sympy.sin(0.7 * t + 1),
    ]
    motion = newton.flat_motion(path, t, newton.Crane(c_s=0.0))
    load = dict(zip("XYZ", (path[0], path[1], path[2] + 9), strict=True))
    for time in (0.0, 0.4, 1.7):
        values = {p: system.parameter_values[p.name] for p in system.parameters}
        for name, p in load.items():
            for order in range(3):
                values[output(name, order)] = float(sympy.diff(p, t, order).subs(t, time))
        for coordinate, expression in flat.determined:
            values[coordinate] = float(evaluate(expression, values))
        names = {c.name: values[c] for c, _ in flat.determined}
        found = [names[name] for name in newton.COORDINATES]
        assert found == pytest.approx(motion(time)[0][:5], abs=1e-12)

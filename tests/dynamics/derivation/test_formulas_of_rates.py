"""Rates and accelerations of coordinates and bodies, and what encloses them over boxes."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.dynamics.derivation.cancellation import without_turns
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray

MACHINES = ["car", "diff_drive", "helicopter", "rolling_disk", "satellite", "two_cranes"]
STEP = 1e-5  # [s] of finite differences; their error is its square times third derivatives


def values_at(model: kinolab.Model, x: Array, u: Array) -> dict[str, Array]:
    (mode,) = model.plant.formulas
    known = [*zip(mode.state, x, strict=True), *zip(mode.inputs, u, strict=True)]
    return dict([*known, *zip(mode.parameters, model.parameter_vector(), strict=True)])


def states_of(name: str, seed: int) -> tuple[kinolab.Model, Array, Array]:
    model, rng = kinolab.systems.get(name).model().plant, np.random.default_rng(seed)
    x = model.rest() + 0.2 * np.minimum(model.state_scales, 1.0) * rng.normal(size=model.nx)
    for part in model.space.spheres:
        x[part.own] /= np.linalg.norm(x[part.own])
    return model, x, rng.uniform(*np.clip(model.control_bounds, -5.0, 5.0).T)


@pytest.mark.parametrize("name", MACHINES)
def test_accelerations_are_how_rates_change_and_speeds_how_bodies_move(name: str) -> None:
    """Differences along short motions of the compiled equations, which are differentiated here."""
    model, x, u = states_of(name, 1)
    (mode,) = model.formulas
    ends = [x + sign * STEP * model.f(x, u) for sign in (-1.0, 1.0)]
    before, after = (np.array(mode.rates(values_at(model, end, u)), float) for end in ends)
    found = np.array(mode.accelerations(values_at(model, x, u)), float)
    assert found == pytest.approx((after - before) / (2 * STEP), rel=1e-5, abs=1e-5)
    rates = np.array(mode.rates(values_at(model, x, u)), float)
    assert rates[: model.nq] == pytest.approx(model.f(x, u)[: model.nq], rel=1e-9, abs=1e-12)
    moved = (model.frames(ends[1]) - model.frames(ends[0])) / (2 * STEP)
    speeds = np.linalg.norm(rates[model.nq :].reshape(-1, 2, 3)[:, 0], axis=1)
    assert speeds == pytest.approx(np.linalg.norm(moved[:, 3::4], axis=1), rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("name", MACHINES)
def test_close_enclosures_hold_what_is_inside_and_are_no_wider(name: str) -> None:
    model, x, u = states_of(name, 2)
    (mode,) = model.formulas
    rng, formulas = np.random.default_rng(3), mode.rates.beside(mode.accelerations)
    names = [n for n in (*mode.state, *mode.inputs) if n in formulas.variables]
    middle = values_at(model, x, u)
    for half in (1e-1, 1e-3):
        box = {n: IntervalArray(v, v) for n, v in ((n, np.full(1, v)) for n, v in middle.items())}
        box |= {
            n: IntervalArray(*(middle[n] + s * half * np.ones(1) for s in (-1, 1))) for n in names
        }
        with np.errstate(all="ignore"):
            close, _ = formulas.enclose_closely(box, names)
            plain = formulas.enclose(box)
        for _ in range(50):
            at = middle | {n: middle[n] + rng.uniform(-half, half) for n in names}
            for value, one in zip(formulas(at), close, strict=True):
                slack = 1e-12 * (1 + abs(float(value)))
                assert one.low - slack <= value <= one.high + slack
        for one, other in zip(close, plain, strict=True):
            assert (one.width <= other.width * (1 + 1e-12)).all()


def test_close_enclosures_become_four_times_closer_in_half_the_box() -> None:
    """Of x (1 - x) about 0.3, whose plain enclosure becomes only twice as close."""
    graph = ExpressionGraph()
    x = graph.variable("x")

    formulas = Formulas.of(graph, [graph.mul(x, graph.sub(graph.one, x))])
    excess = []
    for half in (1e-2, 5e-3):
        box = {"x": IntervalArray(np.array([0.3 - half]), np.array([0.3 + half]))}
        (found,), _ = formulas.enclose_closely(box, ["x"])
        excess.append(float(found.width[0]) - 2 * half * 0.4)
    assert 3.5 < excess[0] / excess[1] < 4.5


def test_an_angle_cancels_where_its_waves_square_to_one() -> None:
    graph = ExpressionGraph()
    a, v = graph.variable("a"), graph.variable("v")
    c, s = graph.unary("cos", a), graph.unary("sin", a)
    turned = graph.add(graph.mul(c, graph.mul(c, v)), graph.mul(s, graph.mul(s, v)))
    assert without_turns(graph, [turned], [a]) == [v]
    mixed = graph.div(graph.mul(s, graph.add(turned, graph.mul(c, c))), graph.add(v, s))
    (found,) = without_turns(graph, [mixed], [a])
    for at in ({"a": 0.3, "v": 2.0}, {"a": -1.2, "v": 0.7}):
        assert graph.evaluate([found], at) == pytest.approx(graph.evaluate([mixed], at), rel=1e-12)


def test_what_an_angle_turns_with_is_known_from_where_it_stands() -> None:

    graph = ExpressionGraph()
    a, b = graph.variable("a"), graph.variable("b")
    wave = graph.unary("sin", graph.sub(b, a))
    assert Formulas.of(graph, [graph.mul(b, wave)]).turns_with("a")
    assert not Formulas.of(graph, [graph.mul(b, wave)]).turns_with("b")
    half = graph.unary("cos", graph.mul(graph.constant(0.5), a))
    assert not Formulas.of(graph, [half]).turns_with("a")
    assert not Formulas.of(graph, [a]).turns_with("a")

"""Derivatives over boxes against SymPy's at points inside, of formulas and of linear equations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy

from kinolab.dynamics.model.flow_formulas import FlowFormulas
from kinolab.numerics import intervals
from kinolab.numerics.interval_analysis.second_derivatives import (
    Pairs,
    SecondOrder,
    closer,
    operation,
)
from kinolab.numerics.intervals import IntervalArray
from kinolab.systems.crane import crane
from kinolab.systems.pendulum import pendulum

x, y = sympy.symbols("x y")
LOW, HIGH = np.array([0.6, 0.3]), np.array([0.8, 0.5])  # away from kinks and poles
FORMULAS = {
    **{name: getattr(sympy, name)(x * y) for name in ("sin", "cos", "tan", "exp", "log", "sqrt")},
    **{"tanh": sympy.tanh(x * y), "atan": sympy.atan(x * y), "fabs": x * y},
    **{"mul": x * y * x, "div": x * y / x.subs(x, x + y)},
}


def enclosed(name: str) -> SecondOrder:
    """Return an operation on x y, and for two operands x or x + y, over one box."""
    pairs, box = Pairs(2), IntervalArray(LOW, HIGH)
    at = 0.5 * (LOW + HIGH)
    off = intervals.sub(box, intervals.point(at))
    off = IntervalArray(off.low[:, None], off.high[:, None])

    def made(ends: IntervalArray, bent: bool) -> list[SecondOrder]:
        units = [intervals.point(np.eye(2)[:, k : k + 1]) for k in range(2)]
        a, b = (
            SecondOrder(IntervalArray(ends.low[k : k + 1], ends.high[k : k + 1]), units[k])
            for k in range(2)
        )
        product = operation("mul", [a, b], pairs, bent=bent)
        match name:
            case "mul":
                return [product, a]
            case "div":
                return [product, operation("add", [a, b], pairs, bent=bent)]
        return [product]

    found = operation(name, made(box, True), pairs, bent=True)
    middle = operation(name, made(intervals.point(at), False), pairs, bent=False)
    return closer(found, middle, off, pairs)


@pytest.mark.parametrize("name", sorted(FORMULAS))
def test_values_and_derivatives_at_points_are_inside(name: str) -> None:
    f, found = FORMULAS[name], enclosed(name)
    wanted = [[f], [f.diff(x), f.diff(y)], [f.diff(x, 2), f.diff(x, y), f.diff(y, 2)]]
    assert found.slope is not None
    assert found.bend is not None
    bounds = [found.value, found.slope, found.bend]
    points = np.random.default_rng(1).uniform(LOW, HIGH, (200, 2))
    for formulas, bound in zip(wanted, bounds, strict=True):
        for k, formula in enumerate(formulas):
            value = np.broadcast_to(sympy.lambdify([x, y], formula)(*points.T), len(points))
            low, high = np.ravel(bound.low)[k], np.ravel(bound.high)[k]
            assert (value >= low - 1e-14).all()  # what SymPy's values are rounded by
            assert (value <= high + 1e-14).all()


def test_a_gradient_is_narrower_than_the_operations_give() -> None:
    """x / (x + y): what appears twice is one number, to first order."""
    pairs = Pairs(2)
    box, at = IntervalArray(LOW, HIGH), 0.5 * (LOW + HIGH)
    assert (
        enclosed("div").value.width[0]
        < intervals.div(
            intervals.mul(
                *(IntervalArray(box.low[k : k + 1], box.high[k : k + 1]) for k in (0, 1))
            ),
            intervals.add(
                *(IntervalArray(box.low[k : k + 1], box.high[k : k + 1]) for k in (0, 1))
            ),
        ).width[0]
    )
    assert len(pairs.first) == 3
    assert at.shape == (2,)


@pytest.mark.parametrize("make", [pendulum, crane])
def test_derivatives_of_accelerations_are_enclosed(make: Any) -> None:
    """Central differences of the compiled rates, which solve for accelerations otherwise."""
    model = make().model()
    flow = FlowFormulas.of(model)
    nx, nu = model.nx, model.nu
    rng = np.random.default_rng(2)
    p = model.parameter_vector()
    at = np.concatenate([rng.uniform(-0.2, 0.2, nx), model.control_bounds.mean(axis=1), p])
    at[: model.nq] += np.where(np.array(model.state_names[: model.nq]) == "l", 5.0, 0.0)
    radius = np.concatenate([np.full(nx, 0.02), np.full(nu, 1e-3), 0.02 * np.abs(p)])
    box = IntervalArray((at - radius)[:, None], (at + radius)[:, None])
    varied = np.arange(len(at))
    slopes, bends = flow.second_order(box, varied, bent=True)
    assert bends is not None

    def rates(z: np.ndarray[Any, Any]) -> Any:
        values = dict(zip(model.parameter_names, z[nx + nu :], strict=True))
        return model.with_values(values).f(z[:nx], z[nx : nx + nu])

    step = 1e-3 * np.maximum(np.abs(at), 0.1)
    for _ in range(6):
        z = rng.uniform(at - 0.9 * radius, at + 0.9 * radius)
        i, j = rng.integers(0, len(at), 2)
        a, b = step[i] * np.eye(len(at))[i], step[j] * np.eye(len(at))[j]
        first = (rates(z + a) - rates(z - a)) / (2 * step[i])
        mixed = rates(z + a + b) - rates(z + a - b) - rates(z - a + b) + rates(z - a - b)
        second = mixed / (4 * step[i] * step[j])
        # central differences err by a share of the values in the square of 1e-3, and rounding
        for value, bound in ((first, slopes), (second, bends)):
            centre, wide = (
                (bound.centre[:, i, 0], bound.radius[:, i, 0])
                if bound is slopes
                else (bound.centre[:, i, j, 0], bound.radius[:, i, j, 0])
            )
            slack = 1e-4 * (
                np.abs(value) + 1e-3 / (step[i] * (1.0 if bound is slopes else step[j]))
            )
            assert np.isfinite(wide).all()
            assert (np.abs(value - centre) <= wide + slack).all()

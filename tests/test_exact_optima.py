"""The optima of benchmarks/exact_optima.py are optimal: by linear programs and Pontryagin."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
import scipy

from benchmarks.exact_optima import (
    ACCELERATION,
    GRAVITY,
    MASS,
    ROD,
    ROPE,
    carried,
    crane_arcs,
    double_integrator_time,
    reeds_shepp_time,
    swing,
    swing_arcs,
)

INTERVALS = 400  # of constant input, of a linear program
Field = Callable[[Any, float], Sequence[float]]


def reaches(x: float, v: float, end: float, seconds: float) -> bool:
    """Say whether inputs within 1 m/s^2, held for even intervals, bring a mass there in a time."""
    h = seconds / INTERVALS
    after = h * (INTERVALS - 0.5 - np.arange(INTERVALS))  # until the end, from each middle
    equations = np.array([h * after, np.full(INTERVALS, h)])
    found = scipy.optimize.linprog(
        np.zeros(INTERVALS), A_eq=equations, b_eq=[x - v * seconds, end - v], bounds=(-1.0, 1.0)
    )
    return bool(found.status == 0)


@pytest.mark.parametrize(
    ("x", "v", "end"), [(1, 0, 0), (3, 1, 0), (2, -1, 1), (0.5, 2, 0), (-4, 0, 1)]
)
def test_a_mass_cannot_arrive_sooner_than_the_closed_form(x: float, v: float, end: float) -> None:
    """A linear program reaches the end just after that time, and not just before."""
    seconds = double_integrator_time(x, v, end, 1.0)
    assert reaches(x, v, end, 1.002 * seconds)  # held inputs lose less than that
    assert not reaches(x, v, end, 0.998 * seconds)


def test_no_random_word_of_arcs_is_shorter_than_the_closed_form_of_reeds_and_shepp() -> None:
    """Its time to where a word of unit arcs leads is at most the word's length."""
    generator = np.random.default_rng(0)
    for _ in range(200):
        x = y = psi = total = 0.0
        for _ in range(4):
            gear, side = generator.choice([-1, 1]), generator.integers(-1, 2)
            s = generator.uniform(0.1, 1.5)
            z = scipy.integrate.solve_ivp(
                lambda _, z, g=gear, k=side: [g * math.cos(z[2]), g * math.sin(z[2]), g * k],
                (0.0, s), [x, y, psi], rtol=1e-9, atol=1e-9,
            ).y[:, -1]  # fmt: skip
            (x, y, psi), total = z.tolist(), total + s
        assert reeds_shepp_time(x, y, psi) <= total + 1e-6
    assert reeds_shepp_time(3.0, 0.0, 0.0) == pytest.approx(3.0)  # straight
    assert reeds_shepp_time(1.0, 1.0, math.pi / 2) == pytest.approx(math.pi / 2)  # a quarter


def switching_function(
    slope: Field,
    start: Sequence[float],
    inputs: Sequence[float],
    durations: Sequence[float],
    by_input: Callable[[Any], Any],
    jacobian: Callable[[Any, float], Any],
) -> tuple[Any, Any, Any]:
    """Integrate a bang-bang motion with its fundamental matrix, by SciPy.

    Returns:
        Times (N,), the last state (nx,), and for each time the row that maps a costate at the start
        to the switching function there, shape (N, nx): of l^T = l(0)^T F^-1 along b.
    """
    n, x = len(start), np.concatenate([start, np.eye(len(start)).ravel()])
    times, rows, now = [], [], 0.0
    for u, seconds in zip(inputs, durations, strict=True):

        def both(_: float, z: Any, u: float = u) -> Any:
            F = z[n:].reshape(n, n)  # of the adjoint: F' = -F A
            return np.concatenate([slope(z[:n], u), (-F @ jacobian(z[:n], u)).ravel()])

        grid = np.linspace(0.0, seconds, 100)
        made = scipy.integrate.solve_ivp(
            both, (0.0, seconds), x, "DOP853", grid, rtol=1e-10, atol=1e-11
        )
        x = made.y[:, -1]
        times += (now + grid).tolist()
        rows += [z[n:].reshape(n, n) @ by_input(z[:n]) for z in made.y.T]
        now += seconds
    return np.array(times), x[:n], np.array(rows)


def is_extremal(rows: Any, inputs: Sequence[float]) -> bool:
    """Say whether one costate has a switching function of the sign of the input all the way."""
    signs = np.repeat(np.sign(inputs), 100)
    least = np.where(
        np.arange(len(rows)) == 50, 1.0, -1e-2
    )  # the time is stationary: 1e-2 is 1e-4 of it
    found = scipy.optimize.linprog(
        np.zeros(rows.shape[1]), A_ub=-signs[:, None] * rows, b_ub=-least, bounds=(None, None)
    )
    return bool(found.status == 0)  # 1 in the middle of the first arc, so that it is not all 0


@pytest.mark.parametrize("share", [0.6, 0.4])
def test_a_pendulum_is_swung_up_by_an_extremal(share: float) -> None:
    """It arrives upright, and Pontryagin's principle holds along it."""
    torque = share * MASS * GRAVITY * ROD
    inputs, durations = swing_arcs((0.0, 0.0), [(math.pi, 0.0), (-math.pi, 0.0)], torque)
    _, end, rows = switching_function(
        swing, (0.0, 0.0), inputs, durations, lambda _: np.array([0.0, 1 / (MASS * ROD**2)]),
        lambda x, _: np.array([[0.0, 1.0], [-GRAVITY / ROD * math.cos(x[0]), 0.0]]),
    )  # fmt: skip
    assert abs(end) == pytest.approx([math.pi, 0.0], abs=1e-5)
    assert is_extremal(rows, inputs)


@pytest.mark.parametrize("distance", [0.5, 1.0, 2.0, 3.0, 8.0])
def test_a_crane_sets_its_load_to_rest_by_an_extremal(distance: float) -> None:
    """The mirrored second half ends at rest, and Pontryagin's principle holds along all of it."""
    a, (d1, d2) = ACCELERATION, crane_arcs(distance)
    inputs, durations = [a, -a, a, -a], [d1, d2, d2, d1]

    def jacobian(x: Any, u: float) -> Any:
        A = np.zeros((4, 4))
        A[0, 2] = A[1, 3] = 1.0
        A[3, 1] = -(GRAVITY * math.cos(x[1]) - u * math.sin(x[1])) / ROPE
        return A

    _, end, rows = switching_function(
        carried, np.zeros(4), inputs, durations,
        lambda x: np.array([0.0, 0.0, 1.0, -math.cos(x[1]) / ROPE]), jacobian,
    )  # fmt: skip
    assert end == pytest.approx([distance, 0, 0, 0], abs=1e-5)
    assert is_extremal(rows, inputs)

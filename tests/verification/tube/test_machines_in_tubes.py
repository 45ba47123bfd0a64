"""Two hundred machines of each kind in their tubes, by a Runge-Kutta method of the test's own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.simulation.reference import resimulate
from kinolab.verification.tube.proof import Prover
from kinolab.verification.tube.uncertainty import (
    Uncertainty,
    kept_by_default,
    varied_by_default,
)
from tests.closed_loops import outside

STEP, STEPS, RUNS, SUBSTEPS = 0.1, 12, 200, 8
# Of a state's scale: RK4 errs by less in eighths of these steps, as steps of half the length say.
ROUNDING = 1e-5
Array = np.ndarray[Any, np.dtype[np.float64]]
STARTS = {"crane": {"l": 5.0}, "diff_drive": {}, "car": {}, "unicycle1_v0": {}}


def prover_of(name: str) -> Prover:
    """Return a prover of a motion with half of the inputs' range, to one side and to the other."""
    problem = kinolab.load(
        {
            "system": {"name": name},
            "start": STARTS[name],
            "world": {"bounds": {"x": [-20.0, 20.0], "y": [-20.0, 20.0]}},
            "goal": {"x": 0.0, "tolerance": 10.0},
            "integration": {"step": STEP},
        }
    )
    low, high = problem.model.control_bounds.T
    sides = np.where(np.arange(STEPS) % 6 < 3, 1.0, -1.0)[:, None]
    push = 0.5 * (low + high) + 0.2 * sides * (high - low)
    return Prover(problem, resimulate(problem, STEP * np.arange(STEPS + 1.0), push))


def driven(prover: Prover, uncertainty: Uncertainty, seed: int) -> Array:
    """Return the states of one machine at the rows, corners of all intervals for even seeds."""
    problem, tracker, rng = prover.problem, prover.tracker, np.random.default_rng(seed)

    def drawn(radii: Array) -> Array:
        share = rng.uniform(-1.0, 1.0, len(radii))
        return radii * (share if seed % 2 else np.sign(share))

    model, h = problem.whole or problem.model, STEP / SUBSTEPS
    names, p = model.parameter_names, model.parameter_vector()
    f = model.with_values(dict(zip(names, p + drawn(uncertainty.radii(problem)), strict=True))).f
    x, states = tracker.x[0].copy(), [tracker.x[0].copy()]
    for k in range(STEPS):
        seen = x + drawn(uncertainty.measurement_radii(problem))
        u = tracker.limited(tracker.wanted(k, seen)) + drawn(uncertainty.input_radii(problem))
        for _ in range(SUBSTEPS):
            a = f(x, u)
            b = f(x + 0.5 * h * a, u)
            c = f(x + 0.5 * h * b, u)
            x = x + h / 6.0 * (a + 2.0 * b + 2.0 * c + f(x + h * c, u))
        states.append(x)
    return np.array(states)


@pytest.mark.parametrize("name", sorted(STARTS))
def test_all_of_them_stay_inside(name: str) -> None:
    made = prover_of(name)
    names = varied_by_default(made.problem, kept_by_default(made.problem.system))
    uncertainty = Uncertainty(dict.fromkeys(names, 0.02), 1e-5, 1e-4)
    tube = made.prove(uncertainty).tube
    assert tube.steps >= 2
    states = np.array([driven(made, uncertainty, seed) for seed in range(RUNS)])
    for one in states:
        assert (outside(tube, one) <= ROUNDING * made.problem.scales).all()
    wide = (tube.bounds.high - tube.bounds.low).max(axis=0)
    seen = np.ptp(states, axis=0)[: tube.steps + 1].max(axis=0)
    moves = seen > 10.0 * ROUNDING * made.problem.scales
    assert (wide >= seen - 2.0 * ROUNDING * made.problem.scales)[moves].all()
    if tube.complete:
        assert np.median(wide[moves] / seen[moves]) <= 3.0

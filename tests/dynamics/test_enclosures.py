"""Bounds over boxes hold at every point inside, as the compiled functions have it there."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.dynamics.model.enclosures import Enclosures
from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray

BOXES, INSIDE = 40, 30
HALF_WIDTHS = np.array([0.0, 1e-6, 1e-3, 0.05])  # of the states' scales
MACHINES = ["rolling_disk", "car", "crane", "helicopter", "satellite", "two_cranes", "whipple"]


def points(name: str, seed: int) -> tuple[kinolab.Model, IntervalArray, Array, Array]:
    """Return boxes about random states, inputs, and states inside, (INSIDE, BOXES, nx)."""
    model, rng = kinolab.systems.get(name).model(), np.random.default_rng(seed)
    scales = np.minimum(model.state_scales, 3.0)
    middle = model.rest() + 0.3 * scales * rng.normal(size=(BOXES, model.nx))
    half = scales * rng.choice(HALF_WIDTHS, (BOXES, 1)) * np.ones(model.nx)
    if model.machine.modes:
        middle[:, -1] = rng.integers(len(model.machine.modes), size=BOXES)
        half[:, -1] = 0.0
    lower, upper = np.clip(model.control_bounds, -10, 10).T
    u = rng.uniform(lower, upper, (BOXES, model.nu))
    inside = middle + half * rng.uniform(-1, 1, (INSIDE, BOXES, model.nx))
    return model, IntervalArray(middle - half, middle + half), u, inside


@pytest.mark.parametrize("name", [*MACHINES, "biped"])
def test_speeds_requirements_and_velocities_are_inside(name: str) -> None:
    model, box, u, inside = points(name, 1)
    bounds = Enclosures(model)
    with np.errstate(all="ignore"):
        speed, margins, rates = (
            bounds.speed(box, u), bounds.requirements(box, u)[0], bounds.velocities(box, u)
        )  # fmt: skip
    close = 1e-12
    for x in inside:
        fastest = np.max(model.point_speed(x, u), axis=1)
        assert (fastest <= speed * (1 + close) + close).all()
        for found, given in ((margins, model.requirements(x, u)), (rates, model.velocity(x, u))):
            off = np.maximum(found.low - given, given - found.high)
            assert (off <= close * (1 + np.abs(given))).all()


def test_a_small_box_has_narrow_bounds() -> None:
    model, box, u, inside = points("car", 2)
    bounds, narrow = Enclosures(model), (box.width[:, 0] <= 1e-5)
    fastest = np.max(model.point_speed(inside[0], u), axis=1)
    assert narrow.sum() > 5
    assert bounds.speed(box, u)[narrow] == pytest.approx(fastest[narrow], rel=1e-4, abs=1e-4)

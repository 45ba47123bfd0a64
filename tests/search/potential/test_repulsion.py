"""Khatib's push: its closed form, its slope, its ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kinolab.search.potential.field import MIN_DISTANCE, Repulsion
from kinolab.world.collision.closest_points import Gap


def gap(distance: float) -> Gap:
    """A body above an obstacle."""
    return Gap(0, distance, np.array([1.0, 2.0, distance]), np.array([1.0, 2.0, 0.0]))


def test_the_push_is_what_khatib_writes() -> None:
    """0.3 (1/0.25 - 1/0.5) / 0.25^2 = 9.6, upwards."""
    assert Repulsion(0.3, 0.5).force(gap(0.25)) == pytest.approx([0.0, 0.0, 9.6], rel=1e-12)
    assert Repulsion(0.3, 0.5).potential(0.25) == pytest.approx(0.6, rel=1e-12)


@pytest.mark.parametrize("distance", [0.02, 0.1, 0.3, 0.49])
def test_the_push_is_the_slope_of_its_potential(distance: float) -> None:
    push, h = Repulsion(0.3, 0.5), 1e-6
    slope = (push.potential(distance + h) - push.potential(distance - h)) / (2 * h)
    # Central differences: h^2 times the third derivative, about h^2 / d^2 of the slope itself.
    assert push.force(gap(distance))[2] == pytest.approx(-slope, rel=1e-6)


def test_nothing_pushes_from_beyond_the_reach() -> None:
    push = Repulsion(0.3, 0.5)
    assert push.potential(0.5) == push.potential(7.0) == 0.0
    assert not push.force(gap(0.5)).any()
    assert push.potential(0.5 - 1e-9) < 1e-15  # it fades without a step


def test_contact_is_infinitely_high_and_pushes_nowhere() -> None:
    assert Repulsion(0.3, 0.5).potential(0.0) == math.inf
    assert not Repulsion(0.3, 0.5).force(gap(0.0)).any()


def test_almost_at_contact_the_push_is_still_a_number() -> None:
    push = Repulsion(0.3, 0.5).force(gap(1e-300))
    assert np.isfinite(push).all()
    assert push[2] <= 0.3 / MIN_DISTANCE**3

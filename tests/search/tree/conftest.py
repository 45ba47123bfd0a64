"""Problems for tests of compiled trees."""

from __future__ import annotations

import pytest

import kinolab
from kinolab.problem import PlanningTask


@pytest.fixture(scope="module")
def maze() -> PlanningTask:
    """A maze whose goal is hit by no motion."""
    return kinolab.load("rolling_disk_maze", overrides=["goal.tolerance=1e-9"])

"""Clearance at a state: known gaps, to known obstacles."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from kinolab.analyze.diagnose.diagnosis import rejection_sentences
from kinolab.analyze.diagnose.state_clearance import clearance_sentences, largest_clearance
from kinolab.verification.between_samples.clearance_margin import StateClearance, state_clearance
from tests.support import OPEN, WALL, problem_of


def test_the_clearance_of_a_coin_beside_a_wall_is_the_gap(tmp_path: Path) -> None:
    """The wall's face is at x = 2.95, the coin's rim 0.25 m ahead of its centre."""
    problem = problem_of(tmp_path, OPEN + WALL, "start.x=2.66")
    found = state_clearance(problem, problem.start, problem.checker())
    assert found.clearance == pytest.approx(2.95 - 0.25 - 2.66, abs=2e-5)
    assert found.beside == ("coin – wall",)
    assert list(clearance_sentences(found, None)) == [
        "There is little clearance at the start: 4 cm (coin – wall)."
    ]


def test_the_best_of_several_states_counts(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN + WALL)
    near, far = problem.start.copy(), problem.start.copy()
    near[0], far[0] = 2.0, 1.0
    found = largest_clearance(problem, [near, far], problem.checker())
    assert found is not None
    assert found.clearance == pytest.approx(2.95 - 0.25 - 1.0, abs=2e-5)
    assert largest_clearance(problem, [], problem.checker()) is None


def test_in_the_open_clearance_is_unbounded(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN)
    found = state_clearance(problem, problem.start, problem.checker())
    assert found == StateClearance(math.inf, ())
    assert list(clearance_sentences(found, found)) == []


def test_what_is_as_near_everywhere_is_no_finding() -> None:
    hull = StateClearance(0.028, ("truck – ground",))
    assert list(clearance_sentences(hull, hull)) == []


def test_refusals_are_named_largest_first() -> None:
    shares = {
        "collision": {"coin – wall": 0.6, "coin – crate": 0.2, "coin – bin": 0.001},
        "limit": {"phi_dot": 0.199},
    }
    assert list(rejection_sentences(shares)) == [
        "Motions were refused for: collision, coin – wall (60%); collision, coin – crate (20%); "
        "limit, phi_dot (20%)."
    ]
    assert list(rejection_sentences({})) == []

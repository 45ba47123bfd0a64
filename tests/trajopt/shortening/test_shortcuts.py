"""Which connections between two states of a motion are tried, and when it ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.options import SHORT
from kinolab.trajopt.shortening.shortcuts import Shortcuts

PIECES = 40


@pytest.fixture(scope="module")
def problem() -> Any:
    """A pendulum with a girder that is not in its way."""
    return kinolab.load("pendulum_swingup")


def crawling(problem: Any) -> Trajectory:
    """Return a motion of 20 s that takes a fraction of a second."""
    t, angle = np.linspace(0.0, 20.0, PIECES + 1), np.linspace(0.0, 0.4, PIECES + 1)
    x = np.stack([angle, np.full_like(angle, 0.02)], axis=1)
    u = np.zeros((PIECES, problem.model.nu))
    return Trajectory(t, x, u, problem.model.state_names, problem.model.control_names)


def tried(problem: Any, found: Callable[[int, Trajectory], Trajectory | None]) -> Any:
    """Return what shortcuts make of a motion where segments are found as told, and their count."""
    asked: list[Trajectory] = []

    def along(_: Any, given: Trajectory, **_last: bool) -> Trajectory | None:
        asked.append(given)
        return found(len(asked), given)

    segments: Any = SimpleNamespace(
        problem=problem, space=problem.space, along=along, cancelled=lambda: False
    )
    return next(Shortcuts(segments).taken(crawling(problem)), None), asked


def half(_: int, motion: Trajectory) -> Trajectory:
    return replace(motion, t=motion.t / 2)


def test_the_first_that_is_found_takes_the_place_of_its_piece(problem: Any) -> None:
    shorter, asked = tried(problem, half)
    assert len(asked) == 1
    assert shorter.duration == pytest.approx(20.0 - asked[0].duration / 2)


def test_one_that_cannot_be_made_is_followed_by_the_next(problem: Any) -> None:
    shorter, asked = tried(problem, lambda k, given: half(k, given) if k == 3 else None)
    assert len(asked) == 3
    assert shorter.duration == pytest.approx(20.0 - asked[2].duration / 2)
    assert asked[0].duration >= asked[1].duration >= asked[2].duration


def test_it_ends_after_some_that_cannot_be_made(problem: Any) -> None:
    shorter, asked = tried(problem, lambda *_: None)
    assert shorter is None
    assert len(asked) == SHORT.max_failed_shortcuts

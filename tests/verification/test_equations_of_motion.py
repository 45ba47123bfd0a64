"""A mistake in the derivation does not bless itself: a second one notices."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from kinolab import store
from kinolab.analyze.simulate import simulate
from kinolab.dynamics.derivation.newton_euler import NewtonEuler
from kinolab.verification import Check, verify
from tests.support import problem_of

SWING = """\
schema = 1
title = "A double pendulum"

[system]
name = "acrobot_v0"

[start]
q1 = 0.4

[goal]
q1 = 0.0
tolerance = 10.0
"""


def checks(folder: Path, *, thorough: bool = False) -> dict[str, Check]:
    """Verify a motion of half a second under small torques, as the compiled equations have it."""
    problem = problem_of(folder, SWING)
    motion = simulate(problem, 0.5, lambda t, _: {"tau": 0.2 - t})
    return {check.name: check for check in verify(problem, motion, thorough=thorough).checks}


@pytest.mark.parametrize("thorough", [False, True])
def test_equations_that_are_right_pass(tmp_path: Path, thorough: bool) -> None:
    found = checks(tmp_path, thorough=thorough)
    assert found["equations"].passed
    assert found["dynamics"].passed


@pytest.mark.parametrize("part", ["conservative_forces", "inertial_forces", "mass_matrix"])
def test_a_mistake_in_the_derivation_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    """One term of the equations is 1 % too large; nothing else than the second one can know."""
    right = getattr(NewtonEuler, part)

    def wrong(self: NewtonEuler) -> Any:
        found = right(self)
        row, tape = (found[0] if part == "mass_matrix" else found), self.binding.tape
        row[0] = tape.mul(tape.constant(1.01), row[0])
        return found

    monkeypatch.setattr(store, "folder", lambda: tmp_path / "cache")  # what is wrong is not kept
    monkeypatch.setattr(NewtonEuler, part, wrong)
    found = checks(tmp_path)
    assert found["dynamics"].passed
    assert found["drift"].passed
    assert not found["equations"].passed
    assert "derived a second way" in found["equations"].detail

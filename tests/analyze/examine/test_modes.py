"""A machine with modes is compared with the machines that have one mode each."""

from __future__ import annotations

import pytest

from kinolab.analyze.examine import modes_alone
from kinolab.analyze.simulate import drifting_constraints
from kinolab.dynamics import Model
from tests.dynamics.modes.test_light_parts import walker
from tests.verification.test_any_motion import rows


@pytest.mark.parametrize(("ratio", "holds"), [(1e-2, True), (1e-6, True), (1e-14, False)])
def test_a_mode_that_loses_its_light_feet_is_told(ratio: float, holds: bool) -> None:
    """The machine in one mode has no multipliers, and keeps its digits."""
    model: Model = walker(ratio).model()
    for name, check in zip("ab", modes_alone(model), strict=True):
        assert f"in mode {name!r}" in check.law
        assert check.holds == holds, str(check)


@pytest.mark.parametrize("name", ["f_l", "f_r", "a_l"])
@pytest.mark.parametrize("off", [1e-4, -1e-6])
def test_a_constraint_that_a_motion_leaves_is_told_with_when_and_by_how_much(
    name: str, off: float
) -> None:
    problem, motion = rows("five_bar_table")
    assert drifting_constraints(problem, motion) == ()
    motion.x[2, problem.model.state_names.index(name)] += off
    told = drifting_constraints(problem, motion)
    assert told
    assert all(f"at t = {motion.t[2]:.6g} s, more than the 1e-09" in sentence for sentence in told)

"""A mode holds what is there when it begins: a hand grasps a block where its fingers are."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.analyze.diagnose.reached_rates import unreached_directions
from kinolab.dynamics import (
    WORLD,
    Body,
    Force,
    Mode,
    System,
    Transition,
    Viscous,
    closed,
    length,
    move,
    rate,
)
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.verification import verify
from tests.support import detail, failed

REACH = 1.0  # [m] from the hand to where it holds something


def grasping(begins: float, *, grasps: bool = True) -> PlanningTask:
    """A hand that is pushed along x to a block on a damped slide, from 2 m before it."""
    x, y = (length(name, -9.0, 9.0, speed=9.0) for name in ("x", "y"))
    hand, block = Body("hand", move(x), mass=1.0), Body("block", move(y), mass=0.5)
    held = Mode("held", constraints=[closed(y - x - REACH, "the block in the hand")])
    grasp = Transition("grasp", "open", "held", until=y - x - begins)
    machine = System(
        "grasping",
        bodies=[hand, block],
        inputs=[Force("push", on=hand, along=WORLD.x, limit=2.0)],
        efforts=[Viscous(rate(y), 1.0)],
        modes=[Mode("open"), held] if grasps else [Mode("open")],
        transitions=[grasp] if grasps else [],
    )
    return kinolab.load({"system": machine, "start": {"y": 2.0}, "goal": {"x": 3.0}})


@pytest.mark.parametrize("begins", [1.0, 1.5, 0.9])
def test_a_mode_that_begins_elsewhere_than_where_it_holds_does_not_pass(begins: float) -> None:
    """The block would jump by |begins - 1| m."""
    problem = grasping(begins)
    motion = resimulate(problem, np.linspace(0.0, 3.0, 61), np.full((60, 1), 1.0))
    assert set(motion.x[:, -1]) == {0.0, 1.0}
    certificate = verify(problem, motion)
    (check,) = [one for one in certificate.checks if one.name == "transitions"]
    assert check.value == pytest.approx(abs(begins - REACH), abs=1e-6)
    assert ("transitions" in failed(certificate)) == (begins != REACH)
    if begins != REACH:
        assert "the mode held begins where the block in the hand" in detail(
            certificate, "transitions"
        )


def test_a_block_is_moved_in_one_mode_and_not_in_the_other() -> None:
    assert unreached_directions(grasping(1.0)) == ()
    (alone,) = unreached_directions(grasping(1.0, grasps=False))
    assert set(alone) == {"y_dot"}

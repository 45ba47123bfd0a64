"""Velocities that no input changes are named, and none of a machine that has inputs for all."""

from __future__ import annotations

from pathlib import Path

import pytest

import kinolab
from kinolab.analyze.diagnose.reached_rates import unreached_directions, unreached_sentences
from kinolab.scenario import builtin_scenarios
from tests.support import OPEN, problem_of

LAME = """
from kinolab.dynamics import System
from kinolab.systems.rolling_disk import rolling_disk

def lame():
    whole = rolling_disk()
    return System("lame", bodies=whole.bodies, constraints=whole.constraints,
                  inputs=whole.inputs[:1])
"""


def test_a_coin_that_cannot_steer_never_turns(tmp_path: Path) -> None:
    (tmp_path / "lame.py").write_text(LAME)
    text = OPEN.replace('name = "rolling_disk"', 'file = "lame.py:lame"')
    directions = unreached_directions(problem_of(tmp_path, text))
    assert len(directions) == 1
    assert set(directions[0]) == {"psi_dot"}
    assert list(unreached_sentences(directions)) == ["No input ever changes psi_dot."]


def test_a_direction_of_several_velocities_is_written_as_their_sum() -> None:
    half = 2**-0.5
    [sentence] = unreached_sentences([{"a_dot": half, "b_dot": -half}])
    assert sentence == "No input ever changes +0.71 a_dot -0.71 b_dot."


SLOW = "marionette_stage"  # 57 states
SCENARIOS = [
    pytest.param(n, marks=pytest.mark.long) if n == SLOW else n for n in builtin_scenarios()
]


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_machine_that_comes_with_a_scenario_can_change_all_its_velocities(name: str) -> None:
    """A crane's sway has no motor, but the trolley's pulls at it."""
    assert unreached_directions(kinolab.load(name)) == ()

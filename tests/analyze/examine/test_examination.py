"""What an examination says beside the laws: in the words of those who will ask later."""

from __future__ import annotations

from pathlib import Path
from shutil import copy

import pytest

from kinolab import systems
from kinolab.analyze.examine import examine
from kinolab.errors import InputError
from kinolab.loading import find_system
from kinolab.scenario import load_scenario
from tests.support import problem_of

TRACTOR = Path(__file__).parents[2] / "first_afternoon" / "dynamic_tractor.toml"


def test_a_missing_limit_is_told_as_the_planner_will_ask_for_it(tmp_path: Path) -> None:
    """Its forward speed is a state; the rates of x and y, which nothing limits either, are not."""
    tractor = find_system(load_scenario(TRACTOR))
    begin = "Before planning, "
    (told,) = (one for one in examine(tractor).sentences if one.startswith(begin))
    told = told.removeprefix(begin)
    assert told.startswith(
        "nothing limits V_x, the velocity of the frame of wheel along its x axis"
    )
    text = TRACTOR.read_text(encoding="utf-8").partition("[bounds]")[0]
    copy(TRACTOR.with_name("tractor.py"), tmp_path)
    with pytest.raises(InputError) as asked:
        problem_of(tmp_path, text)
    assert told in str(asked.value)


def test_rates_that_follow_from_others_need_no_limits() -> None:
    told = examine(systems.get("rolling_disk")).sentences
    assert not any("Before planning" in one for one in told)

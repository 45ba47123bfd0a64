"""Forty mistakes in eight machines are named in the right words, and right machines get no word.

They were written without knowledge of the code (``planted/README.md``).
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from kinolab.analyze.examine import examine
from kinolab.dynamics import System
from kinolab.errors import InputError
from kinolab.loading import find_scenario, find_system

HOME = Path(__file__).parent / "planted"
EXPECTED: dict[str, dict[str, Any]] = tomllib.loads((HOME / "expected.toml").read_text("utf-8"))
RIGHT = [name for name, entry in EXPECTED.items() if "kind" not in entry]
MISTAKEN = [name for name in EXPECTED if name not in RIGHT]
REFUSED = {"arm__gravity_1.py", "gantry__sign_1.py"}  # the language has no such gravity or friction
QUICK = {"gantry.py", "balancer.py", "furuta.py", "balancer__sign_1.py", "gantry__frames_1.py"}


def marked(names: list[str]) -> list[Any]:
    """Leave a few for every day; deriving them all takes minutes."""
    return [pytest.param(n, marks=() if n in QUICK else pytest.mark.every) for n in names]


def warnings(name: str) -> list[str]:
    scenario = find_scenario(str(HOME / name))
    return list(examine(System.of(find_system(scenario)), scenario.integration).faults)


def names_it(warning: str, entry: dict[str, Any]) -> bool:
    """Whether a warning has one of the words for a mistake, and one of the parts that have it."""
    about = (rf"(?<!\w){re.escape(part)}(?!\w)" for part in entry["about"])
    return all(
        any(re.search(pattern, warning, re.IGNORECASE | re.DOTALL) for pattern in patterns)
        for patterns in (entry["words"], about)
    )


@pytest.mark.parametrize("name", marked(RIGHT))
def test_a_right_machine_gets_no_warning(name: str) -> None:
    assert warnings(name) == []


@pytest.mark.parametrize("name", marked([name for name in MISTAKEN if name not in REFUSED]))
def test_a_mistake_is_named(name: str) -> None:
    found = warnings(name)
    assert any(names_it(warning, EXPECTED[name]) for warning in found), found


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_a_mistake_that_the_language_has_no_word_for_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="Give 0 or more"):
        find_system(find_scenario(str(HOME / name)))

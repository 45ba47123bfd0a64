"""What runs by default leaves out what is marked, and nothing else."""

from __future__ import annotations

import json
import tomllib
from types import SimpleNamespace
from typing import Any

import pytest

from kinolab import planners, systems
from tests import selection
from tests.support import ROOT


def law(name: str, *values: str) -> list[Any]:
    """Return tests as pytest collects them, of a law for some names."""
    return [
        SimpleNamespace(
            path=ROOT / "tests" / "test_law.py",
            originalname=name,
            callspec=SimpleNamespace(params={"name": value}),
            nodeid=value,
        )
        for value in values
    ]


def test_every_marker_is_left_out_by_default() -> None:
    options = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["pytest"]
    left_out = " or ".join(selection.MARKERS)
    assert f"-m 'not ({left_out})'" in options["ini_options"]["addopts"]


def test_those_that_stand_for_others_exist() -> None:
    for names, representatives in selection.REPRESENTATIVES.items():
        assert representatives < set(names)
    assert set(selection.MACHINES) <= set(systems.names())


def test_what_takes_long_and_runs_by_default_exists() -> None:
    for name in selection.SMOKE:
        file, _, test = name.partition("::")
        assert f"def {test.partition('[')[0]}(" in (ROOT / file).read_text(encoding="utf-8")


def test_of_a_law_for_many_machines_a_few_run() -> None:
    """A mode of a machine is called after it; machines of tests are no registered ones."""
    names = ["pendulum", "biped, left", "marionette, taut", "crane", "four_bar_of_tests"]
    assert selection.further(law("keeps_its_energy", *names)) == {"marionette, taut", "crane"}
    scenarios = ["rolling_disk_maze", "crane_factory"]
    assert selection.further(law("is_solved", *scenarios)) == {"crane_factory"}
    assert selection.further(law("ends", *planners.names())) == set(planners.names()) - {
        *("rrt", "rrt_fast", "sst", "prm")
    }


def test_of_a_law_for_many_seeds_the_first_ones_run() -> None:
    items = law("holds", "a", "b")
    items[0].callspec.params, items[1].callspec.params = {"seed": 5}, {"seed": 6}
    assert selection.further(items) == {"b"}


def test_a_law_for_machines_that_nobody_stands_for_runs_for_all_of_them() -> None:
    assert selection.further(law("is_flat", "crane", "helicopter")) == set()


def test_what_was_recorded_took_as_long_as_its_markers_say() -> None:
    recorded = json.loads(selection.RECORD.read_text(encoding="utf-8"))
    assert recorded
    assert min(recorded.values()) >= selection.SEARCH


@pytest.mark.parametrize("folder", sorted({*selection.PROCESS_FOLDERS, *selection.DOCS_FOLDERS}))
def test_folders_that_are_marked_have_tests(folder: str) -> None:
    assert any((ROOT / "tests" / folder).glob("test_*.py"))

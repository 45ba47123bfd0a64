"""What users are given: data with the conveniences that stand above it."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import kinolab
from kinolab.dynamics import System
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.loading import find_machine
from tests.support import OPEN, problem_of


def test_a_loaded_problem_keeps_its_conveniences_wherever_it_goes(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN)
    for same in (
        problem,
        pickle.loads(pickle.dumps(problem)),
        replace(problem, start=problem.goal),
    ):
        assert isinstance(same, kinolab.Problem)
        assert isinstance(same.system, System)


def test_every_way_to_a_machine_leads_to_a_system(tmp_path: Path) -> None:
    pendulum = kinolab.systems.get("pendulum")
    (tmp_path / "own.json").write_text(machine_to_json(pendulum), encoding="utf-8")
    changed = pendulum.with_parameters(m=2.0).with_feedback(None).changed(name="other")
    made = (changed, changed.model().system, find_machine(str(tmp_path / "own.json")))
    for system in (*made, find_machine("rolling_disk_maze"), pickle.loads(pickle.dumps(pendulum))):
        assert isinstance(system, System)


def test_a_machine_of_another_class_is_the_same_machine() -> None:
    pendulum = kinolab.systems.get("pendulum", m=3.0)
    again = System.of(pendulum)
    assert again == pendulum
    assert again.parameter_values["m"] == 3.0

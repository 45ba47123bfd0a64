"""Mistakes that were written down before examine saw them: what it names, and what it does not.

`truth.toml` of each folder has what was wrong and the words of a good remark. Half of its machines
are of the pages, as a user would copy them, and the others stand beside it.
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
from kinolab.loading.find import file_of_machine

HOME = Path(__file__).parents[3]
HERE = Path(__file__).parent
FOLDERS = ("unseen", "third", "fourth", "fifth")
TRUTHS = [tomllib.loads((HERE / f / "truth.toml").read_text("utf-8")) for f in FOLDERS]
MACHINES: dict[str, str] = {name: path for t in TRUTHS for name, path in t["machines"].items()}
MISTAKES = {
    f"{m['machine']}, {m['kind']}: {m['was'][:40]} {m['now'][:60]}": m
    for truth in TRUTHS
    for m in truth["mistake"]
}
QUICK = {"crane", "furuta", "scara", "elevator", "press", "drone"}  # half a minute for each other


def marked(name: str, machine: str) -> Any:
    return pytest.param(name, marks=() if machine in QUICK else pytest.mark.every)


def warnings(text: str, machine: str, folder: Path) -> list[str]:
    """Return what is remarked, or refused, about the text of a machine's file.

    What is only said is at most twelve sentences, but for the titles of modes.
    """
    file = folder / f"{machine}.py"
    file.write_text(text, encoding="utf-8")
    try:
        scenario = find_scenario(f"{file}:{machine}")
        system = System.of(find_system(scenario))
        found = examine(system, scenario.integration, file=file_of_machine(scenario))
    except InputError as refusal:
        return [str(refusal)]
    titles = sum(told.startswith(f"{system.name} in mode") for told in found.sentences)
    assert len(found.sentences) - titles <= 12
    return list(found.faults)


@pytest.mark.parametrize("machine", [marked(name, name) for name in MACHINES])
def test_a_right_machine_gets_no_warning(machine: str, tmp_path: Path) -> None:
    assert warnings((HOME / MACHINES[machine]).read_text("utf-8"), machine, tmp_path) == []


@pytest.mark.parametrize("name", [marked(name, m["machine"]) for name, m in MISTAKES.items()])
def test_a_mistake_is_named(name: str, tmp_path: Path) -> None:
    mistake = MISTAKES[name]
    right = (HOME / MACHINES[mistake["machine"]]).read_text("utf-8")
    assert right.count(mistake["was"]) == 1
    spoiled = right.replace(mistake["was"], mistake["now"])
    found = warnings(spoiled, mistake["machine"], tmp_path)
    named = [w for w in found if all(re.search(words, w) for words in mistake["words"])]
    assert bool(named) is not mistake.get("missed", False), found

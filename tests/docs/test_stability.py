"""What is promised to stay is there, and all that there is is promised."""

import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.support import ROOT


@pytest.fixture
def tool(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    import write_stable  # type: ignore[import-not-found]

    yield write_stable
    for name in ("write_stable", "write_reference"):
        sys.modules.pop(name, None)


def checked(tool, monkeypatch: pytest.MonkeyPatch) -> int:
    monkeypatch.setattr(sys, "argv", ["write_stable.py", "--check"])
    return tool.main()


def test_the_list_of_what_is_stable_is_true(tool, monkeypatch, capsys) -> None:
    """If this fails: ``python tools/write_stable.py``; with --drop where something may leave."""
    assert checked(tool, monkeypatch) == 0, capsys.readouterr().out


@pytest.mark.parametrize(
    "line",
    [
        "name kinolab.load(scenario)",  # once it had other arguments
        "key planner.speed",
        "file plan.txt",
        "command plan check --slowly",
        "exit 9 solved",
    ],
)
def test_what_has_gone_is_noticed(tool, monkeypatch, capsys, tmp_path: Path, line: str) -> None:
    there = tool.LIST.read_text(encoding="utf-8")
    changed = tmp_path / "stable.txt"
    changed.write_text(f"{there}{line}\n", encoding="utf-8")
    monkeypatch.setattr(tool, "LIST", changed)
    assert checked(tool, monkeypatch) == 1
    assert f"gone: {line}" in capsys.readouterr().out


@pytest.mark.parametrize("kind", ["name", "key", "file", "command", "exit"])
def test_what_is_new_is_noticed(tool, monkeypatch, capsys, tmp_path: Path, kind: str) -> None:
    lines = tool.LIST.read_text(encoding="utf-8").splitlines()
    left_out = next(line for line in lines if line.startswith(kind))
    changed = tmp_path / "stable.txt"
    changed.write_text("".join(f"{line}\n" for line in lines if line != left_out))
    monkeypatch.setattr(tool, "LIST", changed)
    assert checked(tool, monkeypatch) == 1
    assert f"new: {left_out}" in capsys.readouterr().out


def test_the_version_to_cite_is_the_one_there_is() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert citation["version"] == project["version"]
    if "dev" not in project["version"]:
        changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
        assert f"## {project['version']} (" in changes


def test_workflows_run_what_the_project_says_it_runs_on() -> None:
    """And what it says it runs on is what README says, and CONTRIBUTING and the first page."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = [c.split(" :: ")[-1] for c in project["classifiers"] if "Python :: 3." in c]
    workflow = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))
    assert workflow["jobs"]["versions"]["strategy"]["matrix"]["python"] == named
    assert project["requires-python"] == f">={named[0]}"
    for page in ("README.md", "CONTRIBUTING.md", "docs/start.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        assert f"Python {named[0]} to {named[-1]}" in text, page


def required(project: dict, entries: list[str]) -> Iterator[Requirement]:
    """Yield what entries ask for, those of kinolab's own extras in their place."""
    for entry in map(Requirement, entries):
        if entry.name != project["name"]:
            yield entry
        for extra in entry.extras if entry.name == project["name"] else ():
            yield from required(project, project["optional-dependencies"][extra])


def test_the_lock_has_all_that_developers_install() -> None:
    """If this fails: ``nox -s lock``."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    locked = re.findall(r"^([\w.-]+)==([\w.+!-]+)", lock, re.MULTILINE)
    entries = [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    for wanted in required(project, entries):
        versions = [v for name, v in locked if name == canonicalize_name(wanted.name)]
        assert any(map(wanted.specifier.contains, versions)), wanted

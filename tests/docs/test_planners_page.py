"""docs/planners.md lists the planners there are, and the planner in it is one that works."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from kinolab import cli, planners
from kinolab.problem import PlanningTask
from kinolab.scenario import shared_settings
from kinolab.search import Budget
from kinolab.settings import settings_of
from kinolab.simulation import Propagator
from kinolab.solve import PlanResult
from tests.conftest import SLOWEST
from tests.search.plugins.authors import Installer, install
from tests.support import OPEN, ROOT, problem_of

__all__ = ["install"]  # the fixture

SCRIPT = run_path(str(ROOT / "tools" / "write_planners.py"))
PAGE = (ROOT / "docs" / "planners.md").read_text(encoding="utf-8")
SILENT = ("--no-animation", "--no-optimize", "--quiet")  # a planner ends where it has a motion
REFERENCE = "greedy.py:Greedy"


def blocks(language: str) -> list[str]:
    """Return the page's code blocks of a language."""
    return re.findall(rf"```{language}\n(.*?)```", PAGE, flags=re.DOTALL)


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with the table in it, and the planner as the page says to save it."""
    folder = tmp_path / "home"
    folder.mkdir()
    monkeypatch.chdir(folder)
    (example,) = blocks("python")
    (folder / "greedy.py").write_text(example, encoding="utf-8")
    (folder / "table.toml").write_text(OPEN)
    return folder


# --- the list ---


def test_the_list_is_what_its_script_writes() -> None:
    """If this fails: ``python tools/write_planners.py``."""
    assert SCRIPT["page"](PAGE) == PAGE


@pytest.mark.parametrize("name", planners.built_in())
def test_every_planner_has_a_section_with_all_its_settings(name: str) -> None:
    found = re.search(rf"^### {name}\n(.*?)(?=^##|\Z)", PAGE, flags=re.MULTILINE | re.DOTALL)
    assert found, f"no section for {name}"
    rows = re.findall(r"^\| `(\w+)` \|", found[1], flags=re.MULTILINE)
    assert rows == [entry.name for entry in settings_of(planners.get(name))]


def test_the_keys_that_all_planners_share_are_listed_once() -> None:
    for entry in shared_settings():
        assert PAGE.count(f"\n| `{entry.name}` |") == 1


def test_a_page_without_its_marks_is_refused() -> None:
    with pytest.raises(ValueError, match="lacks the lines"):
        SCRIPT["page"]("# Planners\n")


# --- the example ---


def test_the_commands_of_the_page_work(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (commands,) = blocks("sh")
    searches, lists = (
        [line.split()[1:] for line in commands.splitlines() if line.startswith(begin)]
        for begin in ("plan crate.toml", "plan list")
    )
    assert searches
    scenarios = (ROOT / "docs" / "scenarios.md").read_text("utf-8")
    (home / "crate.toml").write_text(scenarios.split("```toml\n")[1].split("```")[0])
    for arguments in searches:
        assert cli.run([*arguments, *SILENT, f"--time-limit={SLOWEST}"]) == 0
    assert (home / "runs" / "crate" / "assets" / "greedy.py").is_file()
    capsys.readouterr()
    assert lists
    for arguments in lists:
        assert cli.run(arguments) == 0
        assert "patience" in capsys.readouterr().out


def test_the_scenarios_of_the_page_work(home: Path) -> None:
    sections = [block for block in blocks("toml") if block.startswith("[planner]")]
    assert len(sections) == 2
    for section in sections:
        text = OPEN[: OPEN.index("[planner]")] + section
        found = problem_of(home, text, name="own.toml").solve(seed=1, improve=0)
        assert found.status == "solved"
        assert found.planner in section


def test_the_example_works_as_an_installed_package(
    home: Path, install: Installer, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the entry point that the page shows, and without its file."""
    (project,) = (tomllib.loads(block) for block in blocks("toml") if "entry-points" in block)
    code = (home / "greedy.py").read_text()
    (home / "greedy.py").unlink()
    install("greedy", code, **project["project"]["entry-points"]["kinolab.planners"])
    assert cli.run(["table.toml", "--planner", "greedy", "--json", *SILENT]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["status"], report["planner"]) == ("solved", "greedy")
    assert cli.run(["check", "runs/table"]) == 0


def bits(found: PlanResult) -> bytes:
    assert found.trajectory is not None
    return found.trajectory.u.tobytes() + found.trajectory.x.tobytes()


@pytest.mark.usefixtures("home")
def test_the_example_keeps_the_promises_of_a_planner(table: PlanningTask) -> None:
    """The same seed gives the same bits, another one others; it ends at its iterations."""
    first, second, other = (table.solve(planner=REFERENCE, seed=seed) for seed in (1, 1, 2))
    assert bits(first) == bits(second) != bits(other)
    few = table.solve(planner=REFERENCE, seed=1, max_iterations=3)
    assert few.iterations == 3
    assert few.status == "approximate"


def test_the_example_ends_when_it_is_interrupted_and_keeps_what_it_has(home: Path) -> None:
    problem = problem_of(home, OPEN, "goal.x=4", "goal.tolerance=1e-6")
    budgets: list[Budget] = []

    def stop(*_: float) -> None:
        budgets[0].interrupted = True

    found = problem.solve(planner=REFERENCE, progress=stop, watch=budgets.append)
    assert found.status == "interrupted"
    assert found.trajectory is not None
    assert found.timings["search"] < 5.0  # [s]; it is told after a quarter of one


def test_the_example_begins_anew_where_every_way_is_blocked(home: Path) -> None:
    """Rates may hardly differ from 0: every motion breaks a limit."""
    still = ("bounds.psi_dot=[-1e-9, 1e-9]", "bounds.phi_dot=[-1e-9, 1e-9]")
    problem = problem_of(home, OPEN, *still)
    found = problem.solve(planner=REFERENCE, max_iterations=100, patience=10)
    assert (found.status, found.iterations) == ("not_found", 100)


# --- what the page says of a problem ---


def test_everything_that_the_page_says_a_problem_has_is_there(table: PlanningTask) -> None:
    """Each name of the table is looked up, each call made with the arguments it shows."""
    rows = PAGE.partition("### What `solve` works with")[2].partition("Draw random")[0]
    names = {
        "problem": table,
        "Propagator": Propagator,
        "judge": Propagator(table),
        "checker": table.checker(),
        "x": table.start,
        "u": np.zeros(2),
        "h": table.step,
        "generator": np.random.default_rng(1),
    }
    expressions = re.findall(r"`([^`]+)`", rows)
    assert len(expressions) > 12
    for expression in expressions:
        if expression == "solve":
            continue
        owner = "" if expression.startswith(("problem.", "checker.", "judge")) else "problem.model."
        eval(owner + expression.removeprefix("judge = "), dict(names))

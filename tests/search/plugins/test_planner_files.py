"""A planner in a file of one's own works wherever a planner's name does."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

import kinolab
from kinolab import cli, planners
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.runs import check_run
from kinolab.scenario import load_scenario
from tests.search.plugins.authors import PLANNER
from tests.support import OPEN, failed, plan, problem_of

Capture = pytest.CaptureFixture[str]

SILENT = ("--no-animation", "--quiet")
REFERENCE = "pusher.py:Pusher"


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a planner in it, and the table in a folder below."""
    folder = tmp_path / "home"
    (folder / "problems").mkdir(parents=True)
    monkeypatch.chdir(folder)
    (folder / "pusher.py").write_text(PLANNER)
    (folder / "problems" / "table.toml").write_text(OPEN)
    return folder


def named(reference: str, *settings: str) -> str:
    """The table, its planner being another one."""
    own = "\n".join(settings)
    return OPEN.replace('name = "rrt"', f'name = "{reference}"\n{own}')


def refusal(problem: PlanningTask, reference: str, **settings: object) -> str:
    with pytest.raises(InputError) as caught:
        problem.solve(planner=reference, **settings)
    return str(caught.value)


# --- where a path begins ---


def test_on_the_command_line_a_path_begins_at_the_working_folder(
    home: Path, capsys: Capture
) -> None:
    options = ["--planner", REFERENCE, "--json", *SILENT]
    assert cli.run(["problems/table.toml", *options]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["status"], report["planner"]) == ("solved", "pusher")
    assert cli.run(["problems/table.toml", "--planner", f"{home}/{REFERENCE}", *SILENT]) == 0


@pytest.mark.usefixtures("home")
def test_a_built_in_scenario_can_be_tried_with_it(capsys: Capture) -> None:
    """The maze is not solved by pushing on."""
    options = ["--planner", REFERENCE, "--max-iterations", "30", *SILENT]
    assert cli.run(["rolling_disk_maze", *options]) == 4
    assert capsys.readouterr().out.startswith("approximate: ")


def test_in_a_scenario_a_path_begins_at_the_scenarios_folder(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = home / "problems" / "table.toml"
    table.write_text(named(f"../{REFERENCE}", "share = 0.75"))
    monkeypatch.chdir(home.parent)
    found = kinolab.load(table).solve()
    assert (found.status, found.planner) == ("solved", "pusher")
    assert found.trajectory is not None
    assert found.trajectory.u[:, 0] == pytest.approx(0.75)  # [N m], of 1


def test_in_set_a_path_begins_there_too(home: Path) -> None:
    below = home / "problems" / "pusher.py"
    (home / "pusher.py").rename(below)
    assert cli.run(["problems/table.toml", "--set", f"planner.name={REFERENCE}", *SILENT]) == 0


def test_in_python_a_path_begins_at_the_working_folder(home: Path) -> None:
    problem = kinolab.load(home / "problems" / "table.toml")
    assert problem.solve(planner=REFERENCE, share=1.0).status == "solved"


def test_through_a_link_to_a_folder_the_file_is_found(home: Path, tmp_path: Path) -> None:
    (tmp_path / "far" / "away").mkdir(parents=True)
    (home / "link").symlink_to(tmp_path / "far" / "away")
    (home / "link" / "table.toml").write_text(OPEN)
    assert cli.run(["link/table.toml", "--planner", REFERENCE, *SILENT]) == 0


def test_an_absolute_path_in_a_scenario_is_refused_for_it_cannot_be_mailed(home: Path) -> None:
    with pytest.raises(InputError) as caught:
        problem_of(home, named(f"{home}/{REFERENCE}"))
    assert "is not relative to the scenario's folder." in str(caught.value)


@pytest.mark.parametrize("reference", ["pusher.py", "pusher.py:", "pusher.py:3", "my.py:A B"])
def test_a_file_without_a_class_is_refused(home: Path, reference: str) -> None:
    with pytest.raises(InputError) as caught:
        problem_of(home, named(reference))
    assert str(caught.value) == (
        f'table.toml [planner] name: "{reference}" does not name a class in a file. '
        'Give the name of a planner in quotes, or "my_planner.py:Class" (default "auto").'
    )


@pytest.mark.usefixtures("home")
def test_a_file_without_a_class_is_refused_in_python(table: PlanningTask) -> None:
    assert refusal(table, "pusher.py") == (
        'solve planner: "pusher.py" does not name a class in a file. '
        'Give the name of a planner in quotes, or "my_planner.py:Class" (default "auto").'
    )


# --- settings ---


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("share = 2", "share: 2 is out of range. Give at least 0.0, at most 1.0."),
        ('share = "all"', "share: 'all' does not fit. Give a number, such as the default 0.5."),
        (
            "shares = 1",
            "shares: no setting of pusher is called 'shares'. Did you mean 'share'? Known: share.",
        ),
    ],
)
def test_its_settings_are_checked_as_all_are(home: Path, setting: str, told: str) -> None:
    with pytest.raises(InputError) as caught:
        problem_of(home, named(REFERENCE, setting))
    assert str(caught.value) == f"table.toml [planner] {told}"


def test_settings_of_the_scenario_hold_for_its_own_planner_by_whatever_path(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = problem_of(home, named(REFERENCE, "share = 0.25"))
    monkeypatch.chdir(home / "problems")
    for reference, share in ((None, 0.25), ("../pusher.py:Pusher", 0.25)):
        found = problem.solve(planner=reference, seed=1)
        assert found.trajectory is not None
        assert found.trajectory.u[:, 0] == pytest.approx(share)
    assert problem.solve(planner="rrt", seed=1).status == "solved"  # which has no share


def test_mistakes_in_it_are_told_together_with_all_others(home: Path) -> None:
    text = named(REFERENCE, "share = 2").replace("x = -1.0", "z = -1.0")
    with pytest.raises(InputError) as caught:
        problem_of(home, text)
    assert len(caught.value.mistakes) == 2


# --- a run of it ---


def run_of(home: Path) -> Path:
    """Plan the table with a planner of one's own, and move the run away from it."""
    table = home / "problems" / "table.toml"
    table.write_text(named(f"../{REFERENCE}", "share = 0.75"))
    assert cli.run([str(table), *SILENT]) == 0
    return Path(shutil.move(home / "runs" / "table", home.parent / "elsewhere"))


def test_a_run_can_be_checked_where_the_planner_is_not(home: Path) -> None:
    folder = run_of(home)
    (home / "pusher.py").unlink()
    done = plan("check", "elsewhere", cwd=home.parent)
    assert done.returncode == 0, done.stderr
    assert "elsewhere: passed" in done.stdout
    assert json.loads((folder / "report.json").read_text())["planner"] == "pusher"


def test_the_check_of_a_run_does_not_run_the_planner(home: Path) -> None:
    folder = run_of(home)
    proof = folder / "it_ran"
    code = f"open({str(proof)!r}, 'w').close()\n"
    for file in (home / "pusher.py", folder / "assets" / "pusher.py"):
        file.write_text(code + PLANNER)
    assert cli.run(["check", str(folder)]) == 7  # the copy was changed
    assert not proof.exists()
    (folder / "assets" / "pusher.py").unlink()
    assert cli.run(["check", str(folder)]) == 7  # and now it is missing
    assert not proof.exists()


def test_a_run_can_be_repeated_from_its_folder_alone(home: Path) -> None:
    folder = run_of(home)
    shutil.rmtree(home / "problems")
    (home / "pusher.py").unlink()
    scenario = load_scenario(folder / "scenario.toml")
    assert scenario.planner.name == "assets/pusher.py:Pusher"
    assert scenario.planner.settings == {"share": 0.75}
    again = home.parent / "again"
    assert cli.run([str(folder / "scenario.toml"), "--out", str(again), *SILENT]) == 0
    for name in ("trajectory.csv", "assets/pusher.py", "scenario.toml"):
        assert (again / name).read_bytes() == (folder / name).read_bytes()


def test_a_run_of_a_planner_that_is_not_installed_here_can_be_checked(home: Path) -> None:
    folder = run_of(home)
    scenario = folder / "scenario.toml"
    text = scenario.read_text()
    scenario.write_text(text.replace("assets/pusher.py:Pusher", "of_some_package"))
    assert failed(check_run(folder)) == {"files"}  # it was another scenario's; the rest is proved


def test_a_run_keeps_the_text_that_ran(home: Path) -> None:
    """The file may be edited, or go away, during a long search."""
    edits = "        import pathlib\n        pathlib.Path(__file__).unlink()\n        u = self"
    text = PLANNER.replace("        u = self", edits)
    (home / "pusher.py").write_text(text)
    assert cli.run(["problems/table.toml", "--planner", REFERENCE, *SILENT]) == 0
    assert not (home / "pusher.py").exists()
    assert (home / "runs" / "table" / "assets" / "pusher.py").read_text() == text


# --- the file is code ---


def test_a_file_is_run_once_until_it_changes(home: Path, table: PlanningTask) -> None:
    count = "with open('count', 'a') as file:\n    file.write('x')\n"
    (home / "pusher.py").write_text(count + PLANNER)
    for _ in range(2):
        problem_of(home, named(REFERENCE)).solve()
        table.solve(planner=REFERENCE)
    assert (home / "count").read_text() == "x"
    (home / "pusher.py").write_text(count + PLANNER.replace("0.5, 0.0", "0.6, 0.0"))
    assert planners.get(REFERENCE)().share == 0.6  # type: ignore[attr-defined]
    assert (home / "count").read_text() == "xx"


def test_running_a_file_leaves_nothing_beside_it(home: Path) -> None:
    planners.get(REFERENCE)
    assert {path.name for path in home.iterdir()} == {"pusher.py", "problems"}


def test_two_files_of_one_name_do_not_shadow_each_other(home: Path) -> None:
    (home / "problems" / "pusher.py").write_text(PLANNER.replace('"pusher"', '"other"'))
    first, second = (planners.get(f"{at}{REFERENCE}") for at in ("", "problems/"))
    assert (first.name, second.name) == ("pusher", "other")
    assert planners.get(REFERENCE) is first


@pytest.mark.usefixtures("home")
def test_what_it_prints_is_no_result(home: Path) -> None:
    text = "print('hello')\n" + PLANNER.replace(
        "        u = self", "        print('hi')\n        u = self"
    )
    (home / "pusher.py").write_text(text)
    options = ("--planner", REFERENCE, "--json", "--no-animation", "--quiet")
    done = plan("problems/table.toml", *options, cwd=home)
    assert json.loads(done.stdout)["status"] == "solved"
    assert (done.stderr.count("hello"), done.stderr.count("hi\n")) == (1, 1)
    listed = plan("list", "planners", REFERENCE, "--json", cwd=home)
    assert json.loads(listed.stdout)["planners"][0]["name"] == REFERENCE


# --- what is wrong with it ---

CLASS = "class Pusher(AbstractPlanner):"
SHARE = 'share: float = setting(0.5, 0.0, 1.0, meaning="Share of the largest input.")'
LINE = PLANNER[: PLANNER.index("        u = self")].count("\n") + 1  # the first of solve()
BROKEN = {
    "an exception": (
        "\n1 / 0\n",
        "running pusher.py failed on line 2 (ZeroDivisionError: division by zero).",
    ),
    "an import": (
        "import nowhere\n",
        "running pusher.py failed on line 1 (ModuleNotFoundError: No module named 'nowhere').",
    ),
    "an exit": ("import sys\nsys.exit(3)\n", "running pusher.py failed on line 2 (SystemExit: 3)."),
    "no Python": (
        "a = 1\ndef (:\n",
        "running pusher.py failed on line 2 (SyntaxError: invalid syntax (pusher.py, line 2)).",
    ),
    "nothing": ("", "no class of pusher.py is called 'Pusher'. Known: none."),
    "another class": (
        PLANNER.replace("class Pusher", "class Pushr"),
        "no class of pusher.py is called 'Pusher'. Did you mean 'Pushr'? Known: Pushr.",
    ),
    "no planner": (
        "class Pusher: ...\n",
        "Pusher of pusher.py is a class, not a planner. "
        "Derive a class from kinolab.search.planner.AbstractPlanner.",
    ),
    "a function": (
        "def Pusher(): ...\n",
        "Pusher of pusher.py is a function, not a planner. "
        "Derive a class from kinolab.search.planner.AbstractPlanner.",
    ),
    "a number": (
        "Pusher = 3\n",
        "Pusher of pusher.py is an int, not a planner. "
        "Derive a class from kinolab.search.planner.AbstractPlanner.",
    ),
    "no solve": (
        PLANNER.replace("def solve", "def search"),
        "Pusher of pusher.py does not define solve(). "
        "Write def solve(self, problem, seed, budget).",
    ),
    "no name": (
        PLANNER.replace('name: ClassVar[str] = "pusher"', ""),
        'Pusher of pusher.py has no name. Write name: ClassVar[str] = "pusher" in it.',
    ),
    "kinolab's name": (
        PLANNER.replace('"pusher"', '"rrt"'),
        "Pusher of pusher.py calls itself 'rrt', as a planner of kinolab does. "
        "Choose another name.",
    ),
    "no dataclass": (
        PLANNER.replace("@dataclass(frozen=True, kw_only=True)\n", ""),
        "Pusher of pusher.py is not a dataclass. "
        "Write @dataclass(frozen=True, kw_only=True) above it.",
    ),
    "a setting without default": (
        PLANNER.replace(SHARE, "share: float"),
        "Pusher of pusher.py has a setting 'share' without a default. "
        "Write share: … = setting(DEFAULT).",
    ),
    "a setting without kind": (
        PLANNER.replace(SHARE, "share: object = None"),
        "Pusher of pusher.py has a setting 'share' whose default is None. "
        "A scenario can say: truth value, whole number, number, text, list, table.",
    ),
    "a default out of range": (
        PLANNER.replace("setting(0.5", "setting(1.5"),
        "Pusher of pusher.py has a setting 'share' whose default 1.5 is out of range. "
        "Give at least 0.0, at most 1.0.",
    ),
    "a shared key as a setting": (
        PLANNER.replace("share: float", "seed: float").replace("self.share", "self.seed"),
        "Pusher of pusher.py has a setting 'seed', a key that all planners share. "
        "Call it otherwise.",
    ),
    "its name as a setting": (
        PLANNER.replace("name: ClassVar[str]", "name: str"),
        "Pusher of pusher.py has a setting 'name', a key that all planners share. "
        "Write name: ClassVar[str].",
    ),
}


@pytest.mark.parametrize(("code", "told"), BROKEN.values(), ids=BROKEN.keys())
def test_a_file_that_is_no_planner_is_told_where_the_scenario_names_it(
    home: Path, code: str, told: str
) -> None:
    (home / "pusher.py").write_text(code)
    with pytest.raises(InputError) as caught:
        problem_of(home, named(REFERENCE))
    assert str(caught.value) == f"table.toml [planner] name: {told}"


def test_a_missing_file_is_told_by_its_whole_path(home: Path, capsys: Capture) -> None:
    assert cli.run(["problems/table.toml", "--planner", "nothing.py:Pusher"]) == 2
    told = f"error: --planner: there is no Python file {home}/nothing.py.\n"
    assert capsys.readouterr().err.endswith(told)


def test_everything_that_is_wrong_with_a_class_is_told_at_once(home: Path) -> None:
    code = PLANNER.replace('"pusher"', '"est"').replace("def solve", "def search")
    (home / "pusher.py").write_text(code.replace("setting(0.5", "setting(1.5"))
    with pytest.raises(InputError) as caught:
        planners.get(REFERENCE)
    assert len(caught.value.mistakes) == 3


FAILING = {
    "an exception": (
        "1 / 0",
        f"running Pusher.solve() of pusher.py failed on line {LINE} "
        "(ZeroDivisionError: division by zero).",
    ),
    "a wrong question to kinolab": (
        "problem.model.step([1.0], [0.0, 0.0], 0.1)",
        f"running Pusher.solve() of pusher.py failed on line {LINE} "
        "(InputError: x has shape (1,); it must be (6,) or (N, 6).).",
    ),
    "an exit": (
        "raise SystemExit(0)",
        f"running Pusher.solve() of pusher.py failed on line {LINE} (SystemExit: 0).",
    ),
    "nothing": ("return", "Pusher.solve() of pusher.py returned NoneType, not a SearchResult."),
    "a word": (
        "return SearchResult('solved', [0.0], [], 0)",
        "Pusher.solve() of pusher.py returned str, not an Outcome.",
    ),
    "too few inputs": (
        "return SearchResult(Outcome.SOLVED, [0.0, 1.0], [1.0], 0)",
        "Pusher.solve() of pusher.py returned times of shape (2,) and inputs of shape (1,). "
        "N inputs have the shape (N, 2), and the times of their ends (N+1,).",
    ),
    "no time": (
        "return SearchResult(Outcome.SOLVED, [], [[1.0, 1.0]], 0)",
        "Pusher.solve() of pusher.py returned times of shape (0,) and inputs of shape (1, 2). "
        "N inputs have the shape (N, 2), and the times of their ends (N+1,).",
    ),
    "not a number": (
        "return SearchResult(Outcome.SOLVED, [0.0, np.nan], [[1.0, 1.0]], 0)",
        "Pusher.solve() of pusher.py returned numbers that are not finite.",
    ),
    "words": (
        "return SearchResult(Outcome.SOLVED, 'abc', [[1.0, 1.0]], 0)",
        "reading what Pusher.solve() of pusher.py returned failed "
        "(ValueError: could not convert string to float: 'abc').",
    ),
}


@pytest.mark.parametrize(("line", "told"), FAILING.values(), ids=FAILING.keys())
def test_a_search_that_fails_is_told_by_its_line_and_writes_nothing(
    home: Path, capsys: Capture, line: str, told: str
) -> None:
    code = PLANNER.replace("        u = self", f"        {line}\n        u = self")
    (home / "pusher.py").write_text(code)
    assert cli.run(["problems/table.toml", "--planner", REFERENCE, *SILENT]) == 2
    assert capsys.readouterr().err == f"error: [planner]: {told}\n"
    assert not (home / "runs").exists()


def test_settings_that_the_class_itself_refuses_are_told(home: Path, table: PlanningTask) -> None:
    check = (
        "    def __post_init__(self):\n        if self.share > 0.7:\n"
        '            raise ValueError("too strong")\n\n    def solve'
    )
    (home / "pusher.py").write_text(PLANNER.replace("    def solve", check))
    told = f"making Pusher of pusher.py failed on line {LINE + 1} (ValueError: too strong)."
    assert refusal(table, REFERENCE, share=0.8) == f"[planner]: {told}"
    with pytest.raises(InputError) as caught:
        problem_of(home, named(REFERENCE, "share = 0.8"))
    assert str(caught.value) == f"table.toml [planner] name: {told}"


def test_a_planner_that_claims_too_much_is_found_out(home: Path) -> None:
    (home / "pusher.py").write_text(PLANNER.replace("<= 1.0 else", "<= 1e9 else"))
    options = ["--planner", REFERENCE, "--max-iterations", "3", *SILENT]
    assert cli.run(["problems/table.toml", *options]) == 7


def test_numbers_of_any_kind_can_be_reported(home: Path, capsys: Capture) -> None:
    extra = 'np.int64(budget.iterations), {"far": np.float32(0.5), "many": np.int64(3)})'
    (home / "pusher.py").write_text(PLANNER.replace("budget.iterations)", extra))
    assert cli.run(["problems/table.toml", "--planner", REFERENCE, "--json", *SILENT]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["statistics"] == {"far": 0.5, "many": 3.0}
    assert report["iterations"] > 1


# --- a planner that does not ask whether its time is over ---

PUSH = "x, rows = problem.model.step"


@pytest.mark.parametrize("asks", ["", "budget.spent(); ", "budget.over; budget.spend(1); "])
def test_a_planner_that_does_not_ask_its_budget_is_named(
    asks: str, home: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """While it runs, and in the summary of its plan, which counts all the same."""
    begin = "        u = self"
    code = PLANNER.replace(begin, f"        import time; {asks}time.sleep(2.1)\n{begin}")
    (home / "pusher.py").write_text(code.replace(" and not budget.spent()", ""))
    problem = kinolab.load("problems/table.toml")
    plan = problem.solve(planner=REFERENCE, time_limit=0.1, improve=0.0, share=1.0)
    since = "since" if asks else "once"
    told = f"Pusher.solve() of pusher.py does not ask its budget: it has run for .* {since}"
    pattern = re.compile(told.replace("()", r"\(\)"))
    assert any(map(pattern.search, plan.warnings)), plan.warnings
    assert any(map(pattern.search, caplog.messages)), caplog.messages


def test_a_planner_that_asks_in_time_is_not_blamed_for_a_slow_iteration(home: Path) -> None:
    (home / "pusher.py").write_text(PLANNER.replace(PUSH, f"import time; time.sleep(1.3); {PUSH}"))
    plan = kinolab.load("problems/table.toml").solve(planner=REFERENCE, time_limit=0.1)
    assert plan.status != "solved"
    assert not any("budget" in warning for warning in plan.warnings)

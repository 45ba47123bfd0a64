"""Which tests run by default, so that they take minutes and nobody marks by hand.

A test is marked ``search`` or ``long`` by the time that it took when ``--record-durations`` last
wrote ``durations.json``, ``process`` by the fixtures that it asks for or by its folder, ``docs`` by
its folder, and ``every`` if a law is stated for many registered machines, planners or seeds and
others stand for this one. One search of each class runs by default (``SMOKE``). All tests but
``long`` ones run with ``-m "not long"``.
"""

from __future__ import annotations

import json
import time
from collections import defaultdict
from collections.abc import Generator, Iterable
from pathlib import Path
from typing import Any

import pytest

from kinolab import planners, systems
from kinolab.scenario import builtin_scenarios

HERE = Path(__file__).parent
RECORD = HERE / "durations.json"
SEARCH, LONG = 0.3, 60.0  # [s], on the computer that recorded them
UNMARKED = 3.0  # [s]: what takes longer and has no marker is named at the end of a full run

MARKED, FIXTURE = "marked", "fixture"  # what a test tells the process that handed it out

MARKERS = {
    "search": f"took more than {SEARCH:g} s, as whole searches do",
    "process": "starts processes: the command line, browsers",
    "docs": "looks at pages of the documentation, or executes them",
    "every": "a law for a registered machine, planner or seed that others stand for by default",
    "long": f"took more than {LONG:g} s",
}
PROCESS_FOLDERS = {"cli", "first_afternoon"}
PROCESS_FIXTURES = {"maze_run", "table_run", "run_copy", "browser"}
DOCS_FOLDERS = {"docs", "course"}
MACHINES = ("pendulum", "rolling_disk", "satellite", "five_bar", "unicycle", "biped")
REPRESENTATIVES = {  # of which names there are
    systems.names(): set(MACHINES),
    tuple(builtin_scenarios()): {name for name in builtin_scenarios() if name.startswith(MACHINES)},
    planners.names(): {"rrt", "rrt_fast", "sst", "prm"},
}
SEEDS = 6  # of a law for many of them
SMOKE = {  # one search of each class, however long it takes and whoever stands for it
    "tests/search/potential/test_trap.py::test_escapes_are_counted_and_then_the_search_ends",
    *(
        "tests/search/tree/test_tree.py"
        f"::test_no_motion_of_a_tree_touches_anything_on_its_way[{planner}-rolling_disk_maze]"
        for planner in ("ao_rrt", "kpiece_fast", "pdst")
    ),
    "tests/solve/test_modes.py"
    "::test_a_machine_with_one_mode_that_bounces_into_itself_is_planned_for[rrt]",
}
OTHERS = {name for names, stand_in in REPRESENTATIVES.items() for name in set(names) - stand_in}


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("kinolab")
    remaining = "run only what has not passed in the last run without this option"
    group.addoption("--remaining", action="store_true", help=remaining)
    recording = f"write to {RECORD.name} how long what runs now takes"
    group.addoption("--record-durations", action="store_true", help=recording)


def pytest_configure(config: pytest.Config) -> None:
    for name, meaning in MARKERS.items():
        config.addinivalue_line("markers", f"{name}: {meaning}")
    if not hasattr(config, "workerinput"):  # the process that hands tests out
        config.pluginmanager.register(Recorder(config))


@pytest.hookimpl(tryfirst=True)  # before pytest deselects by markers
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    recorded = _recorded()
    others = further(items)
    for item in items:
        folder, fixtures = item.path.relative_to(HERE).parts[0], _fixtures(item)
        seconds = max(recorded.get(name, 0.0) for name in (item.nodeid, *fixtures.values()))
        marks = {
            "search": SEARCH <= seconds < LONG,
            "long": seconds >= LONG,
            "process": folder in PROCESS_FOLDERS or PROCESS_FIXTURES & fixtures.keys(),
            "docs": folder in DOCS_FOLDERS,
            "every": item.nodeid in others or item.path.stem.removeprefix("test_") in OTHERS,
        }
        for mark in (m for m, wanted in marks.items() if wanted and item.nodeid not in SMOKE):
            item.add_marker(mark)
        if any(item.get_closest_marker(mark) for mark in MARKERS):
            item.user_properties.append((MARKED, True))
    if config.getoption("remaining"):
        passed = set(config.cache.get("kinolab/passed", []))
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid in passed])
        items[:] = [item for item in items if item.nodeid not in passed]


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: Any) -> Generator[None, Any, Any]:
    """Note how long a fixture of many tests took: which of them makes it is a matter of order."""
    begun = time.perf_counter()
    made = yield
    if fixturedef.scope != "function":
        _made.append((_name(fixturedef), time.perf_counter() - begun))
    return made


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None, None, None]:
    _made.clear()
    yield
    item.user_properties += [(FIXTURE, spent) for spent in _made]


_made: list[tuple[str, float]] = []  # fixtures that the setup of a test has made, with their time


def _fixtures(item: pytest.Item) -> dict[str, str]:
    """Return what records call the fixtures of a test, by their names."""
    info = getattr(item, "_fixtureinfo", None)
    found = info.name2fixturedefs if info else {}
    return {name: _name(definitions[-1]) for name, definitions in found.items() if definitions}


def _name(fixturedef: Any) -> str:
    return f"{fixturedef.baseid}::{fixturedef.argname}"


def further(items: Iterable[pytest.Item]) -> set[str]:
    """Return the names of tests of a law for machines, planners or seeds that others stand for."""
    found = set()
    by_law: dict[Any, list[tuple[str, str]]] = defaultdict(list)
    for item in items:
        call = getattr(item, "callspec", None)
        for argument, value in call.params.items() if call else ():
            if argument == "seed" and value >= SEEDS:
                found.add(item.nodeid)
            elif isinstance(value, str):
                law = (item.path, getattr(item, "originalname", ""), argument)
                by_law[law].append(
                    (item.nodeid, value.partition(",")[0])
                )  # "biped, left": one mode
    for stated in by_law.values():
        names = {name for _, name in stated}
        if any(names & representatives for representatives in REPRESENTATIVES.values()):
            found |= {test for test, name in stated if name in OTHERS}
    return found


class Recorder:
    """Remembers what passed and how long it took."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._seconds: dict[str, float] = defaultdict(float)  # by test, or fixture
        self._marked: set[str] = set()
        self._passed: set[str] = set()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        spent = report.duration
        if report.when == "setup":
            for name, seconds in (value for key, value in report.user_properties if key == FIXTURE):
                self._seconds[name] = max(self._seconds[name], seconds)
                spent -= seconds
        self._seconds[report.nodeid] += max(spent, 0.0)
        if report.when == "call" and report.passed:
            self._passed.add(report.nodeid)
        if MARKED in dict(report.user_properties):
            self._marked.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        kept = getattr(self._config, "cache", None)  # there is none with -p no:cacheprovider
        part = self._config.getoption("remaining") or self._config.getoption("collectonly")
        if kept is not None and not part:
            kept.set("kinolab/passed", sorted(self._passed))
        if self._config.getoption("record_durations"):
            slow = {name: round(s, 1) for name, s in self._seconds.items() if s >= SEARCH}
            others = {name: s for name, s in _recorded().items() if self._did_not_run(name)}
            known = dict(sorted({**others, **slow}.items()))
            RECORD.write_text(json.dumps(known, indent=0) + "\n", encoding="utf-8")

    def _did_not_run(self, name: str) -> bool:
        """Say whether a test or fixture did not run, and its file or folder is still there."""
        return name not in self._seconds and (HERE.parent / name.partition("::")[0]).exists()

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        known = self._marked | _recorded().keys()
        slow = {n: s for n, s in self._seconds.items() if s > UNMARKED and n not in known}
        if slow and self._marked:  # a full run: by default nothing that is marked runs
            terminalreporter.section(f"more than {UNMARKED:g} s, and no marker")
            for name, seconds in sorted(slow.items(), key=lambda entry: -entry[1]):
                terminalreporter.write_line(f"{seconds:.1f} s  {name}")


def _recorded() -> dict[str, float]:
    """Return seconds by test or fixture."""
    found: dict[str, float] = json.loads(RECORD.read_text(encoding="utf-8"))
    return found

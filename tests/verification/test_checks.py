"""A new check is one file and one line: it stands in certificates, reports and `plan check`."""

from __future__ import annotations

import json
import sys
from importlib import import_module
from pathlib import Path

import pytest

from kinolab import cli
from kinolab.verification import verify
from kinolab.verification.certificate import conduct_checks, dynamics_checks
from kinolab.verification.checks import CHECKS, CONDUCT, DYNAMICS, PRECONDITIONS
from kinolab.verification.checks.check import CheckContext
from tests.conftest import Solved
from tests.support import OPEN

# the coin lasts: no motion may take longer than 100 s
FILE = """
from kinolab.verification.checks.check import Check, CheckContext, judged

def duration(context: CheckContext) -> Check:
    return judged("duration", float(context.motion.t[-1]), 100.0, "it takes too long")
"""


@pytest.fixture
def added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Add a check, by a file of its own and a line at the end of ``CHECKS``."""
    (tmp_path / "duration_check.py").write_text(FILE)
    monkeypatch.syspath_prepend(str(tmp_path))
    module = import_module("duration_check")
    monkeypatch.delitem(sys.modules, "duration_check")
    monkeypatch.setattr("kinolab.verification.certificate.CHECKS", (*CHECKS, module.duration))


def test_every_selection_is_of_the_checks_that_there_are() -> None:
    assert set(CHECKS) >= PRECONDITIONS | DYNAMICS | CONDUCT
    assert len(CHECKS) == len(set(CHECKS))


@pytest.mark.usefixtures("added")
def test_a_check_of_ones_own_stands_in_the_certificate(short: Solved) -> None:
    last = verify(short.problem, short.trajectory).checks[-1]
    assert (last.name, last.value, last.passed) == ("duration", short.trajectory.t[-1], True)


@pytest.mark.usefixtures("added")
def test_a_check_of_ones_own_stands_in_the_report_and_in_the_text(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "table.toml").write_text(OPEN)
    options = ["--max-iterations", "20000", "--no-animation", "--quiet"]
    run = tmp_path / "run"
    assert cli.run([str(tmp_path / "table.toml"), *options, "--out", str(run)]) == 0
    report = json.loads((run / "report.json").read_text())
    assert report["verification"][-1]["name"] == "duration"
    capsys.readouterr()
    assert cli.run(["check", str(run)]) == 0
    line = f"  passed duration ({report['duration']:.3g}, limit 100)"
    assert line in capsys.readouterr().out.splitlines()


def test_selections_are_parts_of_the_certificate(short: Solved) -> None:
    """The same checks, with the same outcome, in the same order."""
    whole = verify(short.problem, short.trajectory).checks
    feasible = dynamics_checks(short.problem, short.trajectory)
    assert feasible == tuple(check for check in whole if check in feasible)
    context = CheckContext(short.problem, short.trajectory)
    conduct = conduct_checks(short.problem, context.trajectory, context.motion)
    assert conduct == tuple(check for check in whole if check in conduct)
    assert {check.name for check in conduct} == {"limits", "goal", "collision", "requirements"}

"""What a command imports: nothing that it does not use."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import environment

UNUSED = (
    *("PIL", "matplotlib", "ompl", "piqp", "sympy", "trimesh"),
    *("scipy.interpolate", "scipy.linalg", "scipy.optimize", "scipy.spatial"),
)
PLAN = ("rolling_disk_maze", "--no-optimize", "--no-animation", "--quiet", "--out", "run")


def imported(*arguments: str, cwd: Path) -> set[str]:
    """Run a command; return the names of the modules that it has imported."""
    code = (
        "import json, sys; from kinolab.cli import run; code = run(sys.argv[1:]); "
        "print(json.dumps([code, *sys.modules]), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=cwd,
        env=environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    code, *names = json.loads(done.stderr.splitlines()[-1])
    assert code == 0, done.stderr
    return set(names)


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run, and the cache filled by it."""
    home = tmp_path_factory.mktemp("imports")
    imported(*PLAN, cwd=home)
    return home


def test_a_machine_and_a_mesh_in_the_cache_need_no_library_that_made_them(home: Path) -> None:
    assert imported(*PLAN, cwd=home).isdisjoint(UNUSED)


def test_checking_a_run_needs_no_library_that_made_it(home: Path) -> None:
    assert imported("check", "run", cwd=home).isdisjoint(UNUSED)

"""What a command imports: nothing that it does not use."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

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


def test_a_machine_and_a_mesh_in_the_cache_need_no_library_that_made_them(tmp_path: Path) -> None:
    imported(*PLAN, cwd=tmp_path)  # fills the cache
    assert imported(*PLAN, cwd=tmp_path).isdisjoint(UNUSED)


def test_checking_a_run_needs_no_library_that_made_it(tmp_path: Path) -> None:
    imported(*PLAN, cwd=tmp_path)
    assert imported("check", "run", cwd=tmp_path).isdisjoint(UNUSED)

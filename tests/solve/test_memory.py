"""Solves that are over leave nothing behind."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import ROOT, environment

SCRIPT = ROOT / "benchmarks" / "memory.py"
MOST = 20.0  # [MB] that 1000 solves of a small problem may add


# One of each kind; ``benchmarks/memory.py`` measures all.
KINDS = ("auto", "kpiece", "prm", "prm_geometric")
LONGER = [pytest.param(name, marks=pytest.mark.long) for name in ("potential_field", "shooting")]


@pytest.mark.parametrize("name", [*KINDS, *LONGER])
def test_a_thousand_solves_add_less_than_20_megabytes(name: str, tmp_path: Path) -> None:
    """Extrapolated from 20 solves: a leak shows in every quarter, an allocator's step in some."""
    assert kept(tmp_path, name) < MOST


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere freed memory is not given back")
@pytest.mark.parametrize("what", ["parameter", "limits"])
def test_changed_problems_add_no_more(what: str, tmp_path: Path) -> None:
    """Neither code that is compiled nor code that is loaded for another value stays."""
    assert kept(tmp_path, "rrt_fast", "--changed", what) < MOST


def kept(folder: Path, name: str, *options: str) -> float:
    """Return what 1000 solves leave behind at most, in [MB], with a cache of machines anew."""
    subprocess.run(
        [sys.executable, str(SCRIPT), name, "--solves", "20", "--json", "figures.json", *options],
        cwd=folder,
        env=environment() | {"KINOLAB_CACHE": str(folder / "cache")},
        capture_output=True,
        timeout=300,
        check=True,
    )
    (figures,) = json.loads((folder / "figures.json").read_text())
    assert (figures["planner"], figures["solves"]) == (name, 20)
    assert figures["solved"] > 10  # it is solving that is measured
    return float(figures["steady"])

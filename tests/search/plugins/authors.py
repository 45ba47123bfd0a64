"""What other authors write: a planner in a file, and a package that registers one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

Installer = Callable[..., None]

PLANNER = '''"""A planner that pushes on with full inputs."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kinolab.search import AbstractPlanner, Outcome, SearchResult, setting


@dataclass(frozen=True, kw_only=True)
class Pusher(AbstractPlanner):
    """Push on with one input until the goal is reached.

    Source: Newton, Principia, 1687.
    """

    name: ClassVar[str] = "pusher"

    share: float = setting(0.5, 0.0, 1.0, meaning="Share of the largest input.")

    def solve(self, problem, seed, budget):
        u = self.share * problem.model.control_bounds[:, 1] * [1.0, 0.0]
        x, rows = problem.start, []
        while problem.goal_excess(x) > 1.0 and not budget.spent():
            x, rows = problem.model.step(x, u, problem.step), [*rows, u]
        outcome = Outcome.SOLVED if problem.goal_excess(x) <= 1.0 else Outcome.APPROXIMATE
        t = problem.step * np.arange(len(rows) + 1)
        return SearchResult(outcome, t, np.reshape(rows, (-1, 2)), budget.iterations)
'''


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Installer:
    """Install packages of one module each: a folder on the path with what pip leaves there."""
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(str(site))

    def installed(package: str, code: str | None = None, **planners: str) -> None:
        """Install a package with a module of its name, which registers name = "module:Class"."""
        module = package.replace("-", "_")
        monkeypatch.delitem(__import__("sys").modules, module, raising=False)
        if code is not None:
            (site / f"{module}.py").write_text(code)
        data = site / f"{module}-1.0.dist-info"
        data.mkdir()
        (data / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
        entries = "".join(f"{name} = {value}\n" for name, value in planners.items())
        (data / "entry_points.txt").write_text(f"[kinolab.planners]\n{entries}")

    return installed

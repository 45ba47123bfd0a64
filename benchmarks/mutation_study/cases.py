"""Plans that were kept, read with what their faults are judged with; problems are shared."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from kinolab.problem import PlanningTask
from kinolab.runs import read_run

from .faults import Case
from .judge import Judge
from .plans import kept
from .solids import Bodies


class Cases:
    """The plans of a folder, read as they are asked for.

    Args:
        plans: The folder.
    """

    def __init__(self, plans: Path) -> None:
        self.plans = plans
        self._shared: dict[str, tuple[PlanningTask, Judge, Bodies]] = {}
        self.read = lru_cache(maxsize=64)(self._read)

    def of(self, scenario: str) -> list[Path]:
        """Return the folders of a scenario's plans."""
        return list(kept(self.plans, [scenario]))

    def _read(self, folder: Path) -> Case:
        run, scenario = read_run(folder), folder.parent.name
        if scenario not in self._shared:
            self._shared[scenario] = run.problem, Judge(run.problem), Bodies(run.problem)
        problem, judge, bodies = self._shared[scenario]
        name = f"{scenario}/{folder.name}"
        return Case(name, problem, run.trajectory, judge, bodies, folder)

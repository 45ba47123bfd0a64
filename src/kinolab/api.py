"""The public API: ``load``, ``Problem`` and ``Plan``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinolab import loading
from kinolab.problem import PlanningTask
from kinolab.solve.plan import PlanResult

if TYPE_CHECKING:
    from kinolab.search.ompl import OmplSetup


def load(source: str | Path, *, overrides: Sequence[str] = ()) -> Problem:
    """Read a scenario and build its problem.

    Args:
        source: Path of a TOML file, the name of a built-in scenario, or the path of an environment
            of dynobench, a YAML file.
        overrides: ``KEY=VALUE`` strings that replace keys of the file. Where one selects another
            planner, the settings of the file's planner are dropped.

    Raises:
        InputError: With every mistake that was found.
    """
    problem = loading.load(source, overrides=overrides)
    return Problem(**{entry.name: getattr(problem, entry.name) for entry in fields(problem)})


class Problem(PlanningTask):
    """A planning problem that can be solved, shown and handed to OMPL."""

    def solve(
        self,
        planner: str | None = None,
        seed: int | None = None,
        time_limit: float | None = None,
        **options: Any,
    ) -> Plan:
        """Search for a plan, re-simulate it and verify it.

        Args:
            planner: Name of the planner, or ``file.py:Class`` relative to the working directory;
                the scenario's when left out.
            seed: Random seed; the scenario's when left out.
            time_limit: Of the search, in [s]; the scenario's when left out.
            options: ``max_iterations``, and settings of the planner.

        Raises:
            EndpointError: If the start or the goal is infeasible.
            InputError: If the planner or a setting does not exist.
        """
        from kinolab.solve import solve

        plan = solve(self, planner, seed, time_limit, **options)
        return Plan(**vars(plan), problem=self)

    def _repr_html_(self) -> str:
        """Show world, start and goal in 3D in a notebook."""
        from kinolab.show.view import notebook_frame

        return notebook_frame(self, None)

    def to_ompl(self) -> OmplSetup:
        """Return the problem as OMPL objects, for any OMPL control planner.

        ``.space_information`` and ``.problem_definition`` are ready to use.
        """
        from kinolab.search.ompl import OmplSetup

        return OmplSetup(self)


@dataclass(frozen=True)
class Plan(PlanResult):
    """The result of planning, with the problem it solves.

    Attributes:
        problem: The problem it solves; a notebook shows the plan in its world.
    """

    problem: PlanningTask | None = field(default=None, repr=False, compare=False)

    def _repr_html_(self) -> str | None:
        """Show it in 3D in a notebook; as text where its world is unknown."""
        if self.problem is None:
            return None
        from kinolab.show.view import notebook_frame

        return notebook_frame(self.problem, self)

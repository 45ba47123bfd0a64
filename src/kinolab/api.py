"""The public API: ``load``, ``Problem`` and ``Plan``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from kinolab import loading
from kinolab.arguments import require_fit
from kinolab.problem import PlanningTask
from kinolab.solve.plan import PlanResult

if TYPE_CHECKING:
    from kinolab.search.ompl import OmplSetup


def load(source: str | Path | Mapping[str, Any], *, overrides: Sequence[str] = ()) -> Problem:
    """Read a scenario and build its problem.

    Args:
        source: Path of a TOML file, the name of a built-in scenario, the path of an environment
            of dynobench, a YAML file, or a table with the keys of a scenario file. In a table
            ``system`` may be a System, ``schema`` and ``title`` may be left out, and relative paths
            start at the working directory.
        overrides: ``KEY=VALUE`` strings that replace keys of the file. Where one selects another
            planner, the settings of the file's planner are dropped.

    Raises:
        InputError: With every mistake that was found.
    """
    return Problem.of(loading.load(source, overrides=overrides))


class Problem(PlanningTask):
    """A planning problem that can be changed, solved, shown and handed to OMPL."""

    @classmethod
    def of(cls, task: PlanningTask) -> Self:
        """Return a planning task with these conveniences."""
        return cls(**{entry.name: getattr(task, entry.name) for entry in fields(task)})

    def __repr__(self) -> str:
        """Name the scenario, the machine and what stands in the way."""
        count = len(self.world.obstacles)
        things = f"{count} obstacle{'s' if count != 1 else ''}"
        return f"<Problem {self.name}: {self.machine.name}, {things}>"

    def replace(self, changes: Mapping[str, Any] | None = None, /, **further: Any) -> Self:
        """Return the problem of the same scenario with some of its keys changed.

        ``problem.replace(**{"start.x": 1.0, "planner.name": "rrt"})``. It is built anew from its
        scenario. Where another planner is named, the settings of the former one are dropped.

        Args:
            changes: Values by the scenario's dotted keys; entries of lists count from 1.
            further: The same by keyword.

        Raises:
            InputError: With every mistake that was found.
        """
        require_fit("replace changes", Mapping[str, Any] | None, changes)
        changed = loading.read_changed(self.scenario, {**(changes or {}), **further})
        return self.of(loading.built(*changed))

    def with_obstacle(
        self,
        name: str = "",
        *,
        box: Sequence[float] | None = None,
        sphere: float | None = None,
        cylinder: Sequence[float] | None = None,
        mesh: str | Path | None = None,
        position: Sequence[float] = (0.0, 0.0, 0.0),
        rpy: Sequence[float] = (0.0, 0.0, 0.0),
        **of_mesh: Any,
    ) -> Self:
        """Return the problem with one more obstacle, of one shape, as ``[[world.obstacle]]`` has it.

        Args:
            name: What messages call it; made of its shape and the count when left out.
            box: Full edges along x, y and z in [m].
            sphere: Radius in [m].
            cylinder: Radius and length in [m].
            mesh: Path of a mesh file, relative to the scenario's folder and below it.
            position: Of its centre, or of a mesh file's origin, in [m].
            rpy: Roll, pitch and yaw in [rad].
            of_mesh: ``scale``, ``up`` and ``solid``, of a mesh.

        Raises:
            InputError: With every mistake that was found.
        """
        shapes = {"box": box, "sphere": sphere, "cylinder": cylinder, "mesh": mesh}
        given = {key: value for key, value in shapes.items() if value is not None}
        entry = {"position": position, "rpy": rpy, **given, **of_mesh}
        named = {"name": name, **entry} if name else entry
        return self.of(loading.built(*loading.read_with_obstacle(self.scenario, named)))

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

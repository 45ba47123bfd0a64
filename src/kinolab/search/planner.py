"""The planner interface: settings as fields, and ``solve``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

from kinolab.errors import InputError, Mistake, unknown_name
from kinolab.search.budget import Budget
from kinolab.search.result import SearchResult
from kinolab.settings import setting, settings_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from kinolab.problem import PlanningTask


@dataclass(frozen=True, kw_only=True)
class AbstractPlanner(ABC):
    """A motion planner; its fields are its settings.

    A subclass is a frozen dataclass with a ``name``, defaults for all its settings, and ``solve``.

    Attributes:
        name: What a scenario writes after ``[planner] name =``.
        in_threads: Whether several searches may run in threads of one process: ``solve`` writes to
            no shared data, and releases the GIL most of the time.
        work_per_iteration: What an iteration takes on an idle computer, about, in [s], apart from
            what it charges itself. Budgets that count work go by it.
        compares_costs: Whether it searches for what costs little by [objective].
        hybrid: Whether it plans for machines with modes: it follows motions only by the machine's
            own step, which switches where a mode ends.
        waits: Whether it plans among obstacles that move: the state that it searches from goes on
            with time.
    """

    name: ClassVar[str]
    in_threads: ClassVar[bool] = False
    work_per_iteration: ClassVar[float] = 2e-3
    compares_costs: ClassVar[bool] = False
    hybrid: ClassVar[bool] = False
    waits: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Take whole numbers for numbers: loops are compiled for the types of settings."""
        for entry in settings_of(type(self)):
            value = getattr(self, entry.name)
            if isinstance(entry.default, float) and type(value) is int:
                object.__setattr__(self, entry.name, float(value))

    @abstractmethod
    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Search for inputs that bring the machine from the start into the goal region.

        Failure to find any is a result; only an invalid problem raises.
        """

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> Self:
        """Make a planner from the keys of a scenario.

        Raises:
            InputError: With every unknown key and every invalid value.
        """
        mistakes = [
            Mistake(f"[planner] {key}", what, remedy) for key, what, remedy in cls.misfits(settings)
        ]
        if mistakes:
            raise InputError(mistakes)
        return cls(**settings)

    @classmethod
    def misfits(cls, settings: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
        """Yield (key, what is wrong, remedy) of invalid settings."""
        known = {entry.name: entry for entry in settings_of(cls)}
        for key, value in settings.items():
            if key not in known:
                unknown = unknown_name(f"setting of {cls.name}", key, known=sorted(known))
                yield key, unknown.what, unknown.remedy
            elif misfit := known[key].misfit(value):
                yield key, *misfit
        sound = {k: v for k, v in settings.items() if k in known and known[k].accepts(v)}
        yield from cls(**sound).conflicts()

    def conflicts(self) -> Iterator[tuple[str, str, str]]:
        """Yield (key, what is wrong, remedy) of settings that contradict each other."""
        yield from ()


@dataclass(frozen=True, kw_only=True)
class AbstractTreeSearch(AbstractPlanner):
    """A planner that grows a tree from the start by constant inputs."""

    hybrid: ClassVar[bool] = True
    waits: ClassVar[bool] = True

    min_steps: int = setting(
        1,
        1,
        100_000,
        unit="steps",
        meaning="Fewest integration steps for which an input is held.",
    )
    max_steps: int = setting(
        20,
        1,
        100_000,
        unit="steps",
        meaning="Most integration steps for which an input is held.",
    )
    goal_region_scale: float = setting(
        1.0,
        1.0,
        1e6,
        unit="tolerances",
        meaning="Size of the region around the goal that growth aims for.",
    )
    restart_after: int = setting(
        20_000,
        0,
        unit="iterations",
        meaning="Iterations before a restart, each tree 1.5 times as many; 0 for never.",
    )

    def conflicts(self) -> Iterator[tuple[str, str, str]]:
        """Yield contradicting step limits."""
        if self.min_steps > self.max_steps:
            what = f"{self.min_steps} is more than max_steps, {self.max_steps}."
            yield "min_steps", what, "Lower it, or raise max_steps."

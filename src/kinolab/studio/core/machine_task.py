"""What the studio finds out about a machine in the background."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from kinolab.problem import PlanningTask
from kinolab.studio.core.background_work import Told


@dataclass(frozen=True)
class Examined:
    """What was found out about a machine.

    Attributes:
        verdict: All of it in one line.
        told: What ``plan examine`` prints.
        equations: What ``plan equations`` prints.
    """

    verdict: str
    told: str
    equations: str


def examine_machine(tell: Callable[[Any], None], problem: PlanningTask) -> Examined:
    """Derive a machine's equations, and say what it does and whether its laws hold.

    Args:
        tell: Sends what is being done.
    """
    from kinolab.analyze.describe.each_mode import in_each_mode
    from kinolab.analyze.examine import examine
    from kinolab.dynamics import System
    from kinolab.loading import file_of_machine, stated_start

    system = System.of(problem.system)
    tell(Told("deriving its equations"))
    equations = "\n\n".join(
        "\n".join(filter(None, (title, machine.equations().text())))
        for title, machine in in_each_mode(system)
    )
    tell(Told("examining its laws"))
    scenario = problem.scenario
    file, start = file_of_machine(scenario), stated_start(scenario, system)
    found = examine(system, scenario.integration, file=file, start=start)
    return Examined(found.verdict, str(found), equations)

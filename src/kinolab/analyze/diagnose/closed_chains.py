"""Machines with loops: coordinates that cannot be chosen one by one."""

from __future__ import annotations

from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.problem import Problem


def has_loops(problem: Problem) -> bool:
    """Whether some function of the machine's position must stay zero."""
    return any(isinstance(entry, PositionConstraint) for entry in problem.system.constraints)

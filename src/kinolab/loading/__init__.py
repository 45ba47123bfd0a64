"""From a scenario to a problem: scenario -> system -> model, scenario -> world -> problem."""

from kinolab.loading.build import build_problem, built, load
from kinolab.loading.find import find_machine, find_scenario, find_system
from kinolab.loading.tables import read_changed, read_table, read_with_obstacle

__all__ = [
    "build_problem",
    "built",
    "find_machine",
    "find_scenario",
    "find_system",
    "load",
    "read_changed",
    "read_table",
    "read_with_obstacle",
]

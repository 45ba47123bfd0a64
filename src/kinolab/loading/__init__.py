"""From a scenario to a problem: scenario -> system -> model, scenario -> world -> problem."""

from kinolab.loading.build import build_problem, load
from kinolab.loading.find import find_machine, find_scenario, find_system

__all__ = ["build_problem", "find_machine", "find_scenario", "find_system", "load"]

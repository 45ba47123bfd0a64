"""The benchmark dynobench: its environments as scenarios, and plans in its format.

Source: github.com/quimortiz/dynobench, version 0.0.4.
"""

from kinolab.scenario.dynobench.environment import is_environment, read_environment
from kinolab.scenario.dynobench.machines import MACHINES, KnownMachine

__all__ = [
    "MACHINES",
    "KnownMachine",
    "is_environment",
    "read_environment",
]

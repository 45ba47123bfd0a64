"""The benchmark dynobench: its environments as scenarios, and plans in its format.

Source: github.com/quimortiz/dynobench, version 0.0.4.
"""

from kinolab.dynobench.environment import is_environment, read_environment
from kinolab.dynobench.machines import MACHINES, Machine
from kinolab.dynobench.result import has_its_steps, result_text

__all__ = [
    "MACHINES",
    "Machine",
    "has_its_steps",
    "is_environment",
    "read_environment",
    "result_text",
]

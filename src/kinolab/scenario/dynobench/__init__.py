"""The benchmark dynobench: its environments as scenarios, and plans in its format.

Source: github.com/quimortiz/dynobench, version 0.0.4.
"""

from kinolab.scenario.dynobench.environment import is_environment as is_environment
from kinolab.scenario.dynobench.environment import read_environment as read_environment
from kinolab.scenario.dynobench.machines import MACHINES as MACHINES

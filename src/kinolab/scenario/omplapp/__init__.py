"""OMPL.app's problem files: what they say, and what is wrong with them.

Source: github.com/ompl/omplapp, benchmark/BenchmarkOptions.cpp and gui/ompl_app.py.
"""

from kinolab.scenario.omplapp.cfg_text import CfgFile, CfgValue
from kinolab.scenario.omplapp.problem_file import CfgPose, ProblemFile, read_problem
from kinolab.scenario.omplapp.wanted_planner import WantedPlanner

__all__ = [
    "CfgFile",
    "CfgPose",
    "CfgValue",
    "ProblemFile",
    "WantedPlanner",
    "read_problem",
]

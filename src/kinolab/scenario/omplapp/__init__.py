"""OMPL.app's problem files: what they say, and what is wrong with them.

Source: github.com/ompl/omplapp, benchmark/BenchmarkOptions.cpp and gui/ompl_app.py.
"""

from kinolab.scenario.omplapp.cfg_text import CfgFile as CfgFile
from kinolab.scenario.omplapp.cfg_text import CfgValue as CfgValue
from kinolab.scenario.omplapp.problem_file import CfgPose as CfgPose
from kinolab.scenario.omplapp.problem_file import ProblemFile as ProblemFile
from kinolab.scenario.omplapp.problem_file import read_problem as read_problem

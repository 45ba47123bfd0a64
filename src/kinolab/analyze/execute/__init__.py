"""Closed-loop execution of plans on perturbed machines."""

from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.execution import Execution, ExecutionRun, Executor
from kinolab.analyze.execute.tracker import Tracker
from kinolab.analyze.execute.tube_plot import execution_to_json, tube_png

__all__ = [
    "Conditions",
    "Execution",
    "ExecutionRun",
    "Executor",
    "Tracker",
    "execution_to_json",
    "tube_png",
]

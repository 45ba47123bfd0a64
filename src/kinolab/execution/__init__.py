"""Plans carried out in closed loop by machines that are not quite what the plan was made for."""

from kinolab.execution.conditions import Conditions
from kinolab.execution.executing import Executed, Execution, execute
from kinolab.execution.picture import execution_to_json, tube_png
from kinolab.execution.tracking import Tracker

__all__ = [
    "Conditions",
    "Executed",
    "Execution",
    "Tracker",
    "execute",
    "execution_to_json",
    "tube_png",
]

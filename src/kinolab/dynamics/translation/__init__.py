"""A machine's equations of motion in other languages: CasADi, C, SymPy, python-control.

They come from the expressions that kinolab's own machine code comes from.
"""

from kinolab.dynamics.translation.c_source import c_source
from kinolab.dynamics.translation.casadi_functions import CasadiFunctions, casadi_functions
from kinolab.dynamics.translation.python_control import control_system
from kinolab.dynamics.translation.sympy_model import SympyModel, sympy_model

__all__ = [
    "CasadiFunctions",
    "SympyModel",
    "c_source",
    "casadi_functions",
    "control_system",
    "sympy_model",
]

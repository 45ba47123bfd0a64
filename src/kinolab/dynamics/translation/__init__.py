"""A machine's equations of motion in other languages: CasADi, C, SymPy, python-control.

They come from the expressions that kinolab's own machine code comes from.
"""

from kinolab.dynamics.translation.c_source import c_source as c_source
from kinolab.dynamics.translation.casadi_functions import CasadiFunctions as CasadiFunctions
from kinolab.dynamics.translation.casadi_functions import casadi_functions as casadi_functions
from kinolab.dynamics.translation.python_control import control_system as control_system
from kinolab.dynamics.translation.sympy_model import SympyModel as SympyModel
from kinolab.dynamics.translation.sympy_model import sympy_model as sympy_model
from kinolab.lazy import lazy_package

__all__, *_ = lazy_package(__name__, __file__)  # what it imports as itself

"""A machine's equations of motion in other languages: CasADi functions and C source.

Both come from the expressions that kinolab's own machine code comes from.
"""

from kinolab.dynamics.translation.c_source import c_source
from kinolab.dynamics.translation.casadi_functions import CasadiFunctions, casadi_functions

__all__ = ["CasadiFunctions", "c_source", "casadi_functions"]

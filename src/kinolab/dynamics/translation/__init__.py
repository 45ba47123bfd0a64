"""A machine's equations of motion in other languages: CasADi, C, SymPy, python-control.

They come from the expressions that kinolab's own machine code comes from.
"""

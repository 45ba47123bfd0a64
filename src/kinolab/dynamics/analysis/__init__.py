"""Analysis of the equations of motion: equilibria, LQR design, controllability."""

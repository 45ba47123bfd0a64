"""A problem as a nonlinear program: unknowns, constraints and their derivatives."""

"""Jets (truncated Taylor polynomials) of equations of motion, and rank computations."""

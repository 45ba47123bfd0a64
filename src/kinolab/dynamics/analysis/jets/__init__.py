"""Taylor polynomials of equations of motion, and the ranks that they decide."""

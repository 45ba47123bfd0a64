"""What follows from equations of motion: equilibria, gains, controllability."""

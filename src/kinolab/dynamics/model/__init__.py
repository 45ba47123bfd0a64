"""The face of a machine in NumPy, and what is computed by it."""

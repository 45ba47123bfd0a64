"""A motion: states at knots, the inputs held between them, and the references they follow."""

from kinolab.trajectory.trajectory import Trajectory, read_csv, reference_column

__all__ = ["Trajectory", "read_csv", "reference_column"]

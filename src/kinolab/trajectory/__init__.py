"""Trajectories: states at knots, zero-order-hold inputs and feedback references."""

from kinolab.trajectory.trajectory import Trajectory, read_csv, reference_column

__all__ = ["Trajectory", "read_csv", "reference_column"]

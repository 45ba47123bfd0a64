"""Trajectories: states at knots, zero-order-hold inputs and feedback references."""

from kinolab.trajectory.trajectory import Moment, Trajectory, read_csv, reference_column

__all__ = ["Moment", "Trajectory", "read_csv", "reference_column"]

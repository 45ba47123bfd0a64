"""Exact goals and short trajectories: optimisation after the search."""

"""Multistart: trajectories optimised from one initial guess after another until one is feasible."""

"""Interval analysis beyond single operations: Taylor series, matrices, sets of states."""

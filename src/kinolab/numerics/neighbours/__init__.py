"""Nearest neighbours in a growing set of points."""

"""Worlds as sensors see them: maps of cells, heights in pictures, and clouds of points."""

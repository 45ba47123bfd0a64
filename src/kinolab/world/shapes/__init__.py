"""Shapes of bodies and cables: points, triangles, support functions."""

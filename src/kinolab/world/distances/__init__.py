"""Distances between convex shapes and triangles, one by one, in trees, grids and fields."""

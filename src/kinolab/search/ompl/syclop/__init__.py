"""OMPL's planners that follow leads through a grid of regions."""

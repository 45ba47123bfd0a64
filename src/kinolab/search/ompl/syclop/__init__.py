"""Syclop: OMPL's planners that follow leads through a decomposition into regions."""

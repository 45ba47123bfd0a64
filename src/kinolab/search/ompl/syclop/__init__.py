"""Syclop: OMPL's planners that are guided by paths through a decomposition into regions."""

"""Numbers without machines: compiled loops, trees of points, linear algebra."""

"""Numerics independent of machines: compiled loops, nearest neighbours, linear algebra."""

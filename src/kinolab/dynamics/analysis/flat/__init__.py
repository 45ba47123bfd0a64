"""Flat outputs: found among the points and coordinates of a machine, refuted, or checked."""

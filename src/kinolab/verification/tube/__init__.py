"""Tubes: all motions of a machine with uncertain parameters, disturbances and measurements."""

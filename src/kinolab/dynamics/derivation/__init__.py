"""Derivation of the equations of motion from a machine's description."""

"""Lagrange's equations by SymPy: a second, human-readable derivation."""

"""Motions from guesses: one after another, until one meets every constraint."""

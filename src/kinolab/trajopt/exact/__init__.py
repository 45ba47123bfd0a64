"""Motions made exact: between two states, and into the centre of the goal."""

"""Artificial potential fields: attraction to the goal, repulsion from obstacles."""

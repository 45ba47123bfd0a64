"""Plots of a plan for reports and papers: over time, in phase space, in the configuration space."""

from kinolab.plots.plotting import FILES, plots

__all__ = ["FILES", "plots"]

"""Plots of a plan for reports and papers: over time, in phase space, in the configuration space."""

from kinolab.show.plots.plotting import plots

__all__ = ["plots"]

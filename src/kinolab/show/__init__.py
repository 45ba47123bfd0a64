"""Visualisation: animations, interactive pages, plots and scenes for Blender."""

"""Everything that is looked at: films, interactive pages, plots and scenes for Blender."""

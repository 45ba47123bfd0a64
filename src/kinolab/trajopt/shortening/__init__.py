"""Trajectory shortening: shortcuts, cycle removal and minimum-time segments."""

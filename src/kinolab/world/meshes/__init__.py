"""Mesh files that somebody else wrote: read, checked, kept and simplified."""

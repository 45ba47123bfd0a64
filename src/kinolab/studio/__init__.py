"""Worlds built in a browser, and watched while they are planned for: ``plan studio``."""

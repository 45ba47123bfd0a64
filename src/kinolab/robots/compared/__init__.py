"""Robots from files, compared with what other engines read in the same files."""

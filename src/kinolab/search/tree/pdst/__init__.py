"""PDST: path-directed subdivision of the motions of a tree."""

"""Boxes and capsules around the meshes of robots."""

"""Animated scenes as binary glTF 2.0, for Blender and other viewers."""

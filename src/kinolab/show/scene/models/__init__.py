"""Coloured triangle meshes of machines and ground."""

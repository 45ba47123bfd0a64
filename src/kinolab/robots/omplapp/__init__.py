"""The robots of OMPL.app: meshes that move as its equations say."""

from __future__ import annotations

from kinolab.robots.omplapp.parts import parts_of
from kinolab.robots.omplapp.placed_mesh import PlacedMesh

__all__ = ["PlacedMesh", "parts_of"]

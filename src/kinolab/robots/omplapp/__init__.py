"""The robots of OMPL.app: meshes that move as its equations say."""

from __future__ import annotations

from kinolab.robots.omplapp import rigid_machines
from kinolab.robots.omplapp.placed_mesh import PlacedMesh

__all__ = ["PlacedMesh", "rigid_machines"]

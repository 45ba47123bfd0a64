"""Kinodynamic roadmaps: milestones, motions between them, and queries."""

from kinolab.search.roadmap.roadmap import Roadmap
from kinolab.search.roadmap.roadmap_builder import RoadmapBuilder
from kinolab.search.roadmap.roadmap_file import load_roadmap, save_roadmap

__all__ = ["Roadmap", "RoadmapBuilder", "load_roadmap", "save_roadmap"]

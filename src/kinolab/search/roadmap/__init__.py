"""Roadmaps: milestones, motions between them, and the questions they answer."""

from kinolab.search.roadmap.roadmap import Roadmap
from kinolab.search.roadmap.roadmap_builder import Explorer
from kinolab.search.roadmap.roadmap_file import load_roadmap, save_roadmap

__all__ = ["Explorer", "Roadmap", "load_roadmap", "save_roadmap"]

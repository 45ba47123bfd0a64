"""Roadmaps: milestones, motions between them, and the questions they answer."""

from kinolab.roadmap.explorer import Explorer
from kinolab.roadmap.file import load_roadmap, save_roadmap
from kinolab.roadmap.roadmap import Roadmap

__all__ = ["Explorer", "Roadmap", "load_roadmap", "save_roadmap"]

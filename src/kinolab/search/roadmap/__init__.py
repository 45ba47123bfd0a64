"""Roadmaps: of states and motions between them, and of configurations at rest."""

from kinolab.search.roadmap.configuration_space import ConfigurationSpace
from kinolab.search.roadmap.geometric_roadmap import GeometricRoadmap
from kinolab.search.roadmap.roadmap import Roadmap
from kinolab.search.roadmap.roadmap_builder import RoadmapBuilder
from kinolab.search.roadmap.roadmap_file import load_roadmap, save_roadmap

__all__ = [
    "ConfigurationSpace",
    "GeometricRoadmap",
    "Roadmap",
    "RoadmapBuilder",
    "load_roadmap",
    "save_roadmap",
]

"""Robots in files of other tools, read as machines with derived equations of motion.

``read_urdf`` reads the Unified Robot Description Format of ROS, ``read_mjcf`` MuJoCo's models.
"""

from __future__ import annotations

from kinolab.robots.mjcf import read_mjcf
from kinolab.robots.urdf import read_urdf

__all__ = ["read_mjcf", "read_urdf"]

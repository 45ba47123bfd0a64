"""Robots in files of other tools, read as machines with derived equations of motion.

``read_urdf`` reads the Unified Robot Description Format of ROS.
"""

from __future__ import annotations

from kinolab.robots.urdf import read_urdf

__all__ = ["read_urdf"]

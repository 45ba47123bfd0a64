"""Robots in files of other tools, read as machines with derived equations of motion.

``read_urdf`` reads the Unified Robot Description Format of ROS, ``read_mjcf`` MuJoCo's models;
``urdf_text`` and ``mjcf_text`` write machines that are trees in these formats.
"""

from __future__ import annotations

from kinolab.robots.mjcf import read_mjcf
from kinolab.robots.urdf.urdf_file import read_urdf
from kinolab.robots.writing import mjcf_text, urdf_text

__all__ = ["mjcf_text", "read_mjcf", "read_urdf", "urdf_text"]

"""Writing machines that are trees as files of other tools: MJCF of MuJoCo, URDF of ROS."""

from __future__ import annotations

from kinolab.robots.writing.mjcf_text import mjcf_text
from kinolab.robots.writing.urdf_text import urdf_text

__all__ = ["mjcf_text", "urdf_text"]

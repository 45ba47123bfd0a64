"""Motions in the formats of other tools: tables and ROS 2's messages and bags.

What needs a library asks for it only then.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_names

if TYPE_CHECKING:
    from kinolab.interchange.motion_export import export_motion
    from kinolab.interchange.ros_messages import joint_trajectory, path_message

__all__ = [
    "export_motion",
    "joint_trajectory",
    "path_message",
]

__getattr__ = lazy_names(
    __name__,
    {
        "kinolab.interchange.motion_export": ("export_motion",),
        "kinolab.interchange.ros_messages": ("joint_trajectory", "path_message"),
    },
)

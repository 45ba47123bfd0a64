"""Motions in the formats of other tools: tables and ROS 2's messages and bags.

What needs a library asks for it only then.
"""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab.interchange.motion_export import export_motion as export_motion
    from kinolab.interchange.ros_messages import joint_trajectory as joint_trajectory
    from kinolab.interchange.ros_messages import path_message as path_message

__all__, __getattr__, __dir__ = lazy_package(__name__, __file__)

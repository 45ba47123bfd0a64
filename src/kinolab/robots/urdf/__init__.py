"""Robots in URDF files of ROS, and in the templates that they are made from."""

"""Robots in MJCF files, MuJoCo's models, from its own compiled model of them."""

from kinolab.robots.mjcf.mjcf_file import read_mjcf

__all__ = ["read_mjcf"]

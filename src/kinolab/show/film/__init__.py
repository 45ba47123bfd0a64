"""Animations: a small software renderer, and GIF and MP4 files.

A ``Picture`` describes the content, ``render_frame`` draws a frame, ``write_gif`` an animation.
"""

from kinolab.show.film.film import make_film
from kinolab.show.film.gif import gif_parts, write_gif
from kinolab.show.film.mp4 import mp4
from kinolab.show.film.picture import Cone, Ghost, GoalMarker, Picture
from kinolab.show.film.raster.camera import Camera, View, frame_scene
from kinolab.show.film.snapshot import render_frame

__all__ = [
    "Camera",
    "Cone",
    "Ghost",
    "GoalMarker",
    "Picture",
    "View",
    "frame_scene",
    "gif_parts",
    "make_film",
    "mp4",
    "render_frame",
    "write_gif",
]

"""Moving pictures: a small software renderer and the GIF and MP4 files that it fills.

A ``Picture`` says what is drawn, ``render_frame`` draws it once, ``write_gif`` makes it move.
"""

from kinolab.render.camera import Camera, View, frame_scene
from kinolab.render.film import make_film
from kinolab.render.gif import gif_parts, write_gif
from kinolab.render.mp4 import mp4
from kinolab.render.scene import Cone, Ghost, GoalRegion, Picture
from kinolab.render.still import render_frame

__all__ = [
    "Camera",
    "Cone",
    "Ghost",
    "GoalRegion",
    "Picture",
    "View",
    "frame_scene",
    "gif_parts",
    "make_film",
    "mp4",
    "render_frame",
    "write_gif",
]

"""Moving pictures: a small software renderer and the GIF files that it fills.

A ``Picture`` says what is drawn, ``render_frame`` draws it once, ``write_gif`` makes it move.
"""

from kinolab.render.camera import Camera, frame_scene
from kinolab.render.film import make_film
from kinolab.render.gif import gif_parts, write_gif
from kinolab.render.scene import Cone, Ghost, GoalRegion, Picture
from kinolab.render.still import render_frame

__all__ = [
    "Camera",
    "Cone",
    "Ghost",
    "GoalRegion",
    "Picture",
    "frame_scene",
    "gif_parts",
    "make_film",
    "render_frame",
    "write_gif",
]

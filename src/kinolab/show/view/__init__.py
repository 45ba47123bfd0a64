"""Views of plans and problems: an interactive page, and a scene for Blender."""

from kinolab.show.view.cards import gallery_of
from kinolab.show.view.page_files import (
    notebook_frame,
    save_glb,
    save_page,
    write_model,
    write_page,
    write_scene,
)
from kinolab.show.view.scenes import content_of

__all__ = [
    "content_of",
    "gallery_of",
    "notebook_frame",
    "save_glb",
    "save_page",
    "write_model",
    "write_page",
    "write_scene",
]

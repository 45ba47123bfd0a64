"""Plans and problems as things to look at: an interactive page, and a scene for Blender."""

from kinolab.pages.files import save_glb, save_page, write_scene
from kinolab.pages.gallery import gallery_of
from kinolab.pages.notebook import notebook_frame

__all__ = ["gallery_of", "notebook_frame", "save_glb", "save_page", "write_scene"]

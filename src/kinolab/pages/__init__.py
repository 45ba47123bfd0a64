"""Plans and problems as things to look at: an interactive page, and a scene for Blender."""

from kinolab.pages.files import save_glb, save_page, write_scene
from kinolab.pages.gallery import gallery_of

__all__ = ["gallery_of", "save_glb", "save_page", "write_scene"]

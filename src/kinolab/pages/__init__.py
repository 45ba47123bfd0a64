"""Plans and problems as things to look at: an interactive page, and a scene for Blender."""

from kinolab.pages.files import save_glb, save_page, write_scene

__all__ = ["save_glb", "save_page", "write_scene"]

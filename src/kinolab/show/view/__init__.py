"""Views of plans and problems: an interactive page, and a scene for Blender."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_names

if TYPE_CHECKING:
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

__getattr__ = lazy_names(  # a plan has one page, not a gallery of films
    __name__,
    {
        "kinolab.show.view.cards": ("gallery_of",),
        "kinolab.show.view.page_files": (
            "notebook_frame", "save_glb", "save_page", "write_model", "write_page", "write_scene",
        ),
        "kinolab.show.view.scenes": ("content_of",),
    },
)  # fmt: skip

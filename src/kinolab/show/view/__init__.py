"""Views of plans and problems: an interactive page, and a scene for Blender."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab.show.scene.scenes import content_of as content_of
    from kinolab.show.view.cards import gallery_of as gallery_of
    from kinolab.show.view.page_files import notebook_frame as notebook_frame
    from kinolab.show.view.page_files import save_glb as save_glb
    from kinolab.show.view.page_files import save_page as save_page
    from kinolab.show.view.page_files import views as views
    from kinolab.show.view.page_files import write_model as write_model

# a plan has one page, not a gallery of films
__all__, __getattr__, __dir__ = lazy_package(__name__, __file__)

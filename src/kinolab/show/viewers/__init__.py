"""Plans in other programs' viewers: Rerun and MeshCat."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab.show.viewers.meshcat_scene import show_in_meshcat as show_in_meshcat
    from kinolab.show.viewers.rerun_recording import show_in_rerun as show_in_rerun

__all__, __getattr__, __dir__ = lazy_package(__name__, __file__)

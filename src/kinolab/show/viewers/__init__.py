"""Plans in other programs' viewers: Rerun and MeshCat."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_names

if TYPE_CHECKING:
    from kinolab.show.viewers.meshcat_scene import show_in_meshcat
    from kinolab.show.viewers.rerun_recording import show_in_rerun

__all__ = ["show_in_meshcat", "show_in_rerun"]

__getattr__ = lazy_names(
    __name__,
    {
        "kinolab.show.viewers.meshcat_scene": ("show_in_meshcat",),
        "kinolab.show.viewers.rerun_recording": ("show_in_rerun",),
    },
)

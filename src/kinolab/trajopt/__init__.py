"""Trajectory optimisation after the search: exact goals and shorter durations."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_names

if TYPE_CHECKING:
    from kinolab.trajopt.exact import make_exact
    from kinolab.trajopt.segments import is_long
    from kinolab.trajopt.shortening.shorten import shorten, shortened

__all__ = ["is_long", "make_exact", "shorten", "shortened"]

__getattr__ = lazy_names(  # a search needs none of it
    __name__,
    {
        "kinolab.trajopt.exact": ("make_exact",),
        "kinolab.trajopt.segments": ("is_long",),
        "kinolab.trajopt.shortening.shorten": ("shorten", "shortened"),
    },
)

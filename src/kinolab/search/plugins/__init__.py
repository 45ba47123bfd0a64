"""Planners that do not come with kinolab: from a file, or from a package that registers them."""

from kinolab.search.plugins.entry_points import class_of, package_of, registered
from kinolab.search.plugins.guard import answerable, search
from kinolab.search.plugins.planner_files import class_in, full_reference, seen_from

__all__ = [
    "answerable",
    "class_in",
    "class_of",
    "full_reference",
    "package_of",
    "registered",
    "search",
    "seen_from",
]

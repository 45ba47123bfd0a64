"""Planner plug-ins: third-party planners from a file or from an installed package."""

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

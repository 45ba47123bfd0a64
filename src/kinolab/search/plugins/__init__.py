"""Planner plug-ins: third-party planners from a file or from an installed package."""

from kinolab.search.plugins.entry_points import class_of as class_of
from kinolab.search.plugins.entry_points import package_of as package_of
from kinolab.search.plugins.entry_points import registered as registered
from kinolab.search.plugins.guard import answerable as answerable
from kinolab.search.plugins.guard import search as search
from kinolab.search.plugins.planner_files import class_in as class_in
from kinolab.search.plugins.planner_files import full_reference as full_reference
from kinolab.search.plugins.planner_files import seen_from as seen_from

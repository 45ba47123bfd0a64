"""``plan list``: scenarios, systems, and planners with their settings."""

from kinolab.cli.listing.data import listed
from kinolab.cli.listing.list_text import listed_as_text, setting_rows
from kinolab.cli.listing.planner_entry import PlannerEntry, planner_entries

__all__ = ["PlannerEntry", "listed", "listed_as_text", "planner_entries", "setting_rows"]

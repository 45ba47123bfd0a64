"""``plan list``: scenarios, systems, and planners with their settings."""

from kinolab.listing.data import listed
from kinolab.listing.planner_entry import PlannerEntry, planner_entries
from kinolab.listing.text import listed_as_text, setting_rows

__all__ = ["PlannerEntry", "listed", "listed_as_text", "planner_entries", "setting_rows"]

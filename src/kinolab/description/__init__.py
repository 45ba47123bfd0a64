"""``plan describe``: what a machine is, and whether it can be controlled."""

from kinolab.description.data import description_to_json
from kinolab.description.describe import ConstraintKind, Description, describe
from kinolab.description.modes import Mode
from kinolab.description.rest import AtRest
from kinolab.description.text import described_as_text

__all__ = [
    "AtRest",
    "ConstraintKind",
    "Description",
    "Mode",
    "describe",
    "described_as_text",
    "description_to_json",
]

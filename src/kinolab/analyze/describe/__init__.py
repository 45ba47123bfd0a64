"""``plan describe``: structure and controllability of a machine."""

from kinolab.analyze.describe.at_rest import AtRest
from kinolab.analyze.describe.data import description_to_json
from kinolab.analyze.describe.description import ConstraintKind, Description, describe
from kinolab.analyze.describe.description_text import described_as_text
from kinolab.analyze.describe.each_mode import in_each_mode
from kinolab.analyze.describe.generalisations import Generalisation

__all__ = [
    "AtRest",
    "ConstraintKind",
    "Description",
    "Generalisation",
    "describe",
    "described_as_text",
    "description_to_json",
    "in_each_mode",
]

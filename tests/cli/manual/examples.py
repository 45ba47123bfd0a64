"""The examples of a manual's page."""

from __future__ import annotations

import re

from kinolab.cli.manual.sections import FENCE, ManualSection


def examples_in(section: ManualSection, language: str) -> list[str]:
    """Return a section's examples in a language, in order."""
    fenced = rf"^{FENCE}{language}\n(.*?)^{FENCE}"
    return re.findall(fenced, section.text, re.DOTALL | re.MULTILINE)

"""The pages of the manual that follow from the code: machines, scenarios, runs and studies."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module

from kinolab.cli.manual.sections import ManualSection, sections_of
from kinolab.errors import UnknownNameError

__all__ = ["PAGES", "ManualPage", "about"]


@dataclass(frozen=True)
class ManualPage:
    """A page of the manual.

    Attributes:
        file: Its name in docs/.
        module: Has the function ``page``; imported late, as each imports what it explains.
    """

    file: str
    module: str

    def text(self) -> str:
        """Return it as Markdown."""
        return str(import_module(f"{__name__}.{self.module}").page())


PAGES: Mapping[str, ManualPage] = {
    "machine": ManualPage("machines.md", "machine_words"),
    "scenario": ManualPage("scenarios.md", "scenario_keys"),
    "files": ManualPage("files.md", "run_files"),
    "study": ManualPage("benchmarking.md", "study_keys"),
}


def about(topic: str, names: Iterable[str] = ()) -> str:
    """Return a page of the manual, or the sections of it that names ask for.

    Args:
        topic: A key of ``PAGES``.
        names: Words, sections, keys or files; the whole page if left out.

    Raises:
        InputError: If a name is not on the page.
    """
    text = PAGES[topic].text()
    sections = [section for section in sections_of(text) if section.level == 3]
    asked = [section for name in names for section in _named(sections, name)]
    return "\n".join(map(str, dict.fromkeys(asked))) if asked else text


def _named(sections: list[ManualSection], name: str) -> list[ManualSection]:
    """Return the section with a title, or else all that list such an entry."""
    plain = name.strip("[]/")
    found = [section for section in sections if section.title.strip("[]/") == plain]
    row = re.compile(rf"^(?:\|[^|]*|- )`{re.escape(plain)}[`(]", re.MULTILINE)
    found = found or [section for section in sections if row.search(section.text)]
    if not found:
        titles = [section.title.strip("[]/") for section in sections]
        raise UnknownNameError("entry", name, known=titles)
    return found

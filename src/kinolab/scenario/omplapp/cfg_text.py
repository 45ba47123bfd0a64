"""The lines of a configuration file: sections, keys and values, and where they stand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from kinolab.errors import Mistake, printable, unknown_name
from kinolab.scenario.toml_text import shortened
from kinolab.untrusted import ELEMENTS, refuse_many


@dataclass(frozen=True)
class CfgValue:
    """A text behind a key, and the line it is in, from 1."""

    key: str
    text: str
    line: int


@dataclass
class CfgFile:
    """What stands in a file, and what was found wrong with it so far.

    Attributes:
        label: What mistakes call the file.
        sections: Values in the order in which they stand, by section.
        lines: Where keys stand first, by section and key.
        found: Mistakes with their lines.
    """

    label: str
    sections: dict[str, list[CfgValue]] = field(default_factory=dict)
    lines: dict[tuple[str, str], int] = field(default_factory=dict)
    found: list[tuple[int, Mistake]] = field(default_factory=list)

    def wrong(self, value: CfgValue, what: str, remedy: str = "") -> None:
        """Add a mistake in a line."""
        where = f"{self.label} line {value.line} {shortened(printable(value.key))}".rstrip()
        self.found.append((value.line, Mistake(where, what, remedy)))

    def missing(self, what: str, remedy: str) -> None:
        """Add a mistake that is in no line."""
        self.found.append((ELEMENTS["lines"] + 1, Mistake(self.label, what, remedy)))

    @property
    def mistakes(self) -> list[Mistake]:
        """All mistakes in the order of lines, those in no line last."""
        return [mistake for _, mistake in sorted(self.found, key=lambda pair: pair[0])]

    def table(self, section: str) -> dict[str, CfgValue]:
        """Return the values of a section by key; of those that stand twice, the first."""
        return {value.key: value for value in reversed(self.sections.get(section, []))}

    def check_keys(self, section: str, known: Sequence[str], beginnings: Sequence[str]) -> None:
        """Name the keys of a section that nobody knows.

        Args:
            known: Keys there are.
            beginnings: Of further keys that are known.
        """
        for value in self.sections.get(section, []):
            if value.key not in known and not value.key.startswith(tuple(beginnings)):
                unknown = unknown_name("key", printable(value.key)[:60], known=known)
                near, _, every = unknown.remedy.partition(" Known: ")  # there are thirty
                self.wrong(value, unknown.what, near if every else unknown.remedy)

    def number(self, value: CfgValue | None, *, positive: bool = False) -> float | None:
        """Return a finite number, None where there is none."""
        if value is None:
            return None
        try:
            number = float(value.text)
        except ValueError:
            number = math.nan
        if not math.isfinite(number) or (positive and not number > 0.0):
            kind = "positive" if positive else "finite"
            self.wrong(value, f"{shortened(printable(value.text))!r} is no {kind} number.")
            return None
        return number

    def chosen(self, value: CfgValue | None, kind: str, known: Mapping[str, object]) -> str | None:
        """Return one of several texts, None where there is none or another one."""
        if value is None:
            return None
        if value.text in known:
            return value.text
        self.unknown(value, kind, value.text, sorted(known))
        return None

    def unknown(self, at: CfgValue, kind: str, name: str, known: Sequence[str]) -> None:
        """Add that nothing of a kind has a name."""
        mistake = unknown_name(kind, shortened(printable(name)), known=known)
        self.wrong(at, mistake.what, mistake.remedy)

    def add(self, section: str, value: CfgValue) -> None:
        """Add a value to its section; one that stands there already is a mistake."""
        first = self.lines.setdefault((section, value.key), value.line)
        # the section whose keys may stand several times
        if first != value.line and section != "planner":
            what = f"{shortened(printable(value.key))} stands in line {first} already."
            self.wrong(value, what, "Keep one of them.")
            return
        self.sections.setdefault(section, []).append(value)


def cfg_file(text: str, label: str, sections: Sequence[str]) -> CfgFile:
    """Read the lines of a file.

    ``[section]`` begins a section, ``key = value`` is in the last one, ``section.key = value``
    before the first. What follows a ``#`` is a comment, and so is a line that begins with ``;``.

    Args:
        label: What mistakes call it.
        sections: Names that sections may have.

    Raises:
        InputError: If the file is too long.
    """
    lines = text.splitlines()
    refuse_many(len(lines), "lines", label)
    file, section = CfgFile(label), ""
    for number, whole in enumerate(lines, start=1):
        line = "" if whole.lstrip().startswith(";") else whole.partition("#")[0].strip()
        if not line:
            continue
        key, equals, value = (part.strip() for part in line.partition("="))
        entry = CfgValue(key, value, number)
        heading = line[0] == "[" and line[-1] == "]"
        if heading:
            section = line[1:-1].strip()
            entry = CfgValue(f"[{section}]", "", number)
        elif not equals or not key:
            what = f"{shortened(printable(line))!r} is no key = value."
            file.wrong(CfgValue("", line, number), what)
            continue
        name, _, rest = (
            (section, "", key) if section or heading else key.partition(".")
        )  # which begins it
        if (heading or not section) and name not in sections:
            file.unknown(entry, "section", name, sections)
        if not heading:
            file.add(name, CfgValue(rest, value, number))
    return file

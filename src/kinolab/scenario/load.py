"""From a path or a built-in name to a checked scenario."""

from __future__ import annotations

import difflib
import importlib.resources
import os
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from kinolab.errors import InputError, Mistake
from kinolab.scenario.explain import explain
from kinolab.scenario.findings import Finding, Origin
from kinolab.scenario.overrides import apply_overrides
from kinolab.scenario.places import mistake_at
from kinolab.scenario.rules import document_findings
from kinolab.scenario.salvage import salvage
from kinolab.scenario.schema import Scenario
from kinolab.scenario.toml_text import shortened

SIZE_LIMIT = 1_000_000  # [bytes]
MISTAKE_LIMIT = 100  # nobody reads more, and every one of them takes time to word
_BEGINNING = 'Begin with schema = 1, title = "…" and a [system] section.'


def builtin_scenarios() -> dict[str, Path]:
    """The scenarios that come with kinolab, by name; none where they are not installed."""
    try:
        entries = list(importlib.resources.files("kinolab.scenarios").iterdir())
    except (ModuleNotFoundError, FileNotFoundError):
        return {}
    files = [entry for entry in entries if isinstance(entry, Path) and entry.suffix == ".toml"]
    return {file.stem: file for file in sorted(files)}


def load_scenario(source: str | Path, *, overrides: Sequence[str] = ()) -> Scenario:
    """Read a scenario and check everything that can be checked without its machine.

    Args:
        source: A path, or the name of a built-in scenario. Text with a path separator or
            ending in .toml is a path; other text is a built-in name first and then a path.
        overrides: ``KEY=VALUE`` each, applied in order before the check. The key is dotted
            and counts entries of lists from 1; the value is TOML, or else text.

    Raises:
        InputError: If there is no such file or anything in it is wrong; ``.mistakes`` has
            all that was found.
    """
    scenario, mistakes = read_scenario(source, overrides=overrides)
    if mistakes or scenario is None:
        raise InputError(mistakes)
    return scenario


def read_scenario(
    source: str | Path, *, overrides: Sequence[str] = ()
) -> tuple[Scenario | None, list[Mistake]]:
    """Read a scenario and list its mistakes instead of raising them.

    Returns:
        The scenario, or what is left of it without its broken parts, or None; and the mistakes.

    Raises:
        InputError: If there is no such file or it is not TOML.
    """
    path = scenario_path(source)
    document = _parse(path, _read(path))
    applied, mistakes = apply_overrides(document, overrides)
    return _checked(document, Origin(path, applied), mistakes)


def scenario_from(
    document: dict[str, Any], path: Path, *, overrides: Sequence[str] = ()
) -> Scenario:
    """Return the scenario of keys that were never in a file.

    Args:
        document: Keys and values as TOML would have them.
        path: Where relative paths start, and what mistakes are reported for.
        overrides: As for ``load_scenario``.

    Raises:
        InputError: If anything in it is wrong.
    """
    applied, mistakes = apply_overrides(document, overrides)
    scenario, mistakes = _checked(document, Origin(path, applied), mistakes)
    if mistakes or scenario is None:
        raise InputError(mistakes)
    return scenario


def _checked(
    document: dict[str, Any], origin: Origin, mistakes: list[Mistake]
) -> tuple[Scenario | None, list[Mistake]]:
    findings = document_findings(document)
    scenario = None
    try:
        scenario = Scenario.model_validate(document).located(origin)
    except ValidationError as error:
        findings = explain(error, document, MISTAKE_LIMIT) + findings
    findings = _in_reading_order(findings[: MISTAKE_LIMIT + 1], document)
    if findings:
        scenario = salvage(document, findings, origin)
    mistakes = mistakes + [mistake_at(finding, origin) for finding in findings]
    return scenario, _readable(mistakes, origin)


def _readable(mistakes: list[Mistake], origin: Origin) -> list[Mistake]:
    if len(mistakes) < MISTAKE_LIMIT:
        return mistakes
    rest = Mistake(origin.file.name, "there may be more mistakes than these.", "Mend these first.")
    return [*mistakes[:MISTAKE_LIMIT], rest]


def _in_reading_order(findings: list[Finding], document: dict[str, Any]) -> list[Finding]:
    """Sort findings as their places stand in the document; what is missing comes last."""

    def places(finding: Finding) -> list[int]:
        holder: Any = document
        order = []
        for part in finding.path:
            keys: list[Any] = list(holder if isinstance(holder, dict) else range(_length(holder)))
            order.append(keys.index(part) if part in keys else len(keys))
            holder = holder[part] if part in keys else None
        return order

    return sorted(findings, key=places)


def _length(value: object) -> int:
    return len(value) if isinstance(value, list) else 0


def scenario_path(source: str | Path) -> Path:
    """Return the file that a path or the name of a built-in scenario means."""
    if isinstance(source, Path) or _looks_like_path(source):
        return Path(source)
    return builtin_scenarios().get(source, Path(source))


def _looks_like_path(text: str) -> bool:
    separators = {"/", os.sep, os.altsep or "/"}
    return text.endswith(".toml") or any(separator in text for separator in separators)


def _read(path: Path) -> str:
    """Read a file of at most 1 MB as UTF-8, with or without a byte order mark."""
    where = shortened(_printable(str(path)), 200)
    if not os.path.isfile(path):  # unlike pathlib's, it never raises
        raise InputError([_no_file(path, where)])
    try:
        with path.open("rb") as file:
            content = file.read(SIZE_LIMIT + 1)
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise InputError([Mistake(where, f"the file cannot be read: {reason}.")]) from None
    if len(content) > SIZE_LIMIT:
        raise InputError(
            [Mistake(where, "the file is larger than 1 MB.", "Keep meshes in files of their own.")]
        )
    return _decoded(content, path.name)


def _no_file(path: Path, where: str) -> Mistake:
    if os.path.isdir(path):
        inside = sorted(file.name for file in path.glob("*.toml"))[:10]
        remedy = f"In it: {', '.join(inside)}." if inside else "Give the .toml file."
        return Mistake(where, "this is a folder, not a scenario.", remedy)
    if os.path.exists(path):
        return Mistake(where, "this is not an ordinary file.", "Give a .toml file.")
    what = f"there is no file {shortened(_printable(os.path.abspath(path)), 400)}."
    if path.parent != Path(".") or path.suffix == ".toml":
        return Mistake(where, what, _suggestion(path.stem, _neighbours(path)))
    return Mistake(
        where,
        f"no scenario is called {shortened(path.name)!r}, and {what}",
        f"{_suggestion(path.name, [*builtin_scenarios(), *_neighbours(path)])} "
        f"Built in: {', '.join(builtin_scenarios()) or 'none'}.".lstrip(),
    )


def _neighbours(path: Path) -> list[str]:
    folder = path.parent
    return sorted(file.name for file in folder.glob("*.toml")) if os.path.isdir(folder) else []


def _suggestion(name: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return f"Did you mean {close[0]!r}?" if close else ""


def _decoded(content: bytes, label: str) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(
            [Mistake(f"{label} line {line}", "this is not UTF-8 text.", "Save the file as UTF-8.")]
        ) from None


def _parse(path: Path, text: str) -> dict[str, Any]:
    if not text.strip():
        raise InputError([Mistake(path.name, "the file is empty.", _BEGINNING)])
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError([_not_toml(path.name, text, error)]) from None
    if not document:
        raise InputError([Mistake(path.name, "the file holds no keys.", _BEGINNING)])
    return document


def _not_toml(label: str, text: str, error: Exception) -> Mistake:
    """Say where TOML broke, in tomllib's words, and show the line."""
    remedy = 'TOML has key = value, "text" in quotes, [lists] and { tables = "closed" }.'
    if isinstance(error, RecursionError):
        return Mistake(label, "its lists or tables are nested too deep.", remedy)
    if not isinstance(error, tomllib.TOMLDecodeError):  # Python reads at most 4300 digits
        return Mistake(label, "one of its numbers is too long to read.", "Shorten the number.")
    said, _, place = str(error).partition(" (at ")
    said = said[:1].lower() + said[1:]
    numbers = re.fullmatch(r"line (\d+), column (\d+)\)", place)
    if not numbers:
        line = text.rstrip().count("\n") + 1
        end = f"{label} line {line}" if place else label
        return Mistake(end, f"this is not TOML: {said}{' (at the end)' if place else ''}.", remedy)
    line = int(numbers[1])
    reads = shortened(text.replace("\r\n", "\n").split("\n")[line - 1].strip())
    where = f"{label} line {line}, column {numbers[2]}"
    return Mistake(where, f"this is not TOML: {said}. The line reads {reads!r}.", remedy)


def _printable(text: str) -> str:
    """Replace what would steer a terminal or could not be printed."""
    return "".join(character if character.isprintable() else "�" for character in text)

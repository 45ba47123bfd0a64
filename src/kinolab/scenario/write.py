"""A scenario as TOML text, with every default written out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pydantic import BaseModel

from kinolab.scenario.rules import KINDS_OF
from kinolab.scenario.schema import ObstacleEntry, Scenario, Section
from kinolab.scenario.toml_text import key_text, value_text


def write_scenario(scenario: Scenario) -> str:
    """Write TOML that reads as an equal scenario; optional keys without a value are left out."""
    sections = [(key, value) for key, value in _entries(scenario) if _is_section(value)]
    scalars = [(key, value) for key, value in _entries(scenario) if not _is_section(value)]
    blocks = ["\n".join(_lines(scalars))]
    for key, value in sections:
        blocks += _blocks(key, value)
    return "\n\n".join(blocks) + "\n"


def _blocks(path: str, value: object) -> Iterator[str]:
    """One block per table: the section itself, then the tables and lists of tables in it."""
    several = isinstance(value, tuple)
    for one in value if isinstance(value, tuple) else (value,):
        entries = _entries(one)
        own = [(key, item) for key, item in entries if not _is_nested(item)]
        yield "\n".join([f"[[{path}]]" if several else f"[{path}]", *_lines(own)])
        for key, item in entries:
            if _is_nested(item):
                yield from _blocks(f"{path}.{key}", item)


def _entries(value: object) -> list[tuple[str, object]]:
    """The keys of a section or table that have something to say, as TOML spells them."""
    if isinstance(value, Mapping):
        return list(value.items())
    assert isinstance(value, Section)
    kind = value.kind if isinstance(value, ObstacleEntry) else None
    known = [
        (field.alias or name, held)
        for name, field in type(value).model_fields.items()
        if (held := getattr(value, name)) not in (None, ())
        and (kind is None or kind in KINDS_OF.get(name, (kind,)))
    ]
    return [*(value.model_extra or {}).items(), *known]


def _is_section(value: object) -> bool:
    return isinstance(value, Mapping) or _is_nested(value)


def _is_nested(value: object) -> bool:
    entries = value if isinstance(value, tuple) else (value,)
    return any(isinstance(entry, BaseModel) for entry in entries)


def _lines(entries: list[tuple[str, object]]) -> list[str]:
    return [f"{key_text(key)} = {value_text(_plain(value))}" for key, value in entries]


def _plain(value: object) -> object:
    """Return a section as the inline table that it is within an entry of a list of tables."""
    if isinstance(value, Section | Mapping):
        return {key: _plain(held) for key, held in _entries(value)}
    return value

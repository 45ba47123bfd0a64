"""How a place in a scenario is worded, and what the schema wants there."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from kinolab.errors import Mistake
from kinolab.scenario.issues import Issue, KeyPath, Origin
from kinolab.scenario.schema import Scenario, Section
from kinolab.scenario.toml_text import key_text, shortened, value_text
from kinolab.scenario.values import Wanted

M = TypeVar("M", bound=BaseModel)

TABLE_LISTS: tuple[KeyPath, ...] = (
    ("world", "obstacle"),
    ("goal", "point"),
    ("goal", "direction"),
    ("via",),
    ("machine",),
    ("keep_out",),
)

NAME_TABLES: tuple[KeyPath, ...] = (
    ("bounds",),
    ("machine", "bounds"),
    ("machine", "metric"),
    ("machine", "start"),
    ("metric",),
    ("objective", "length"),
    ("start",),
    ("system", "locked"),
    ("system", "parameters"),
    ("world", "bounds"),
)


def mistake_at(issue: Issue, origin: Origin) -> Mistake:
    """Give a finding its address."""
    return Mistake(place_at(issue.path, origin), issue.what, issue.remedy)


def place_at(path: KeyPath, origin: Origin) -> str:
    """Name the override that wrote what stands at a path, or else its place in the file."""
    writers = [override for override in origin.overrides if override.touches(path)]
    return (
        writers[-1].where
        if writers
        else f"{origin.file.name} {place_text(origin.written(path))}".rstrip()
    )


def place_text(path: KeyPath) -> str:
    """Word a path as ``[section] key`` or ``[[section.list]] 2 key``; lists count from 1."""
    for prefix in TABLE_LISTS:
        if is_table_entry(path[: len(prefix) + 1]) and path[: len(prefix)] == prefix:
            header = f"[[{'.'.join(map(str, prefix))}]] {int(path[len(prefix)]) + 1}"
            return f"{header} {_dotted(path[len(prefix) + 1 :])}".rstrip()
    if len(path) > 1 or (path and path[0] in _SECTIONS):
        return f"[{_dotted(path[:1])}] {_dotted(path[1:])}".rstrip()
    return _dotted(path)


def is_table_entry(path: KeyPath) -> bool:
    """Whether a path leads to one table of a list of tables."""
    return path[:-1] in TABLE_LISTS and isinstance(path[-1], int)


def has_keys(path: KeyPath) -> bool:
    """Whether the schema has a table at ``path`` and nothing else."""
    return section_at(path) is not None or path in NAME_TABLES


def section_at(path: KeyPath) -> type[Section] | None:
    """The model of the table at ``path``, if the schema has one there."""
    section: type[Section] | None = Scenario
    for key in path:
        if section is not None and not isinstance(key, int):
            field = fields_of(section).get(key)
            section = model_in(field.annotation, Section) if field else None
    return section


def keys_of(section: type[Section]) -> list[str]:
    """The keys of a table as TOML spells them."""
    return list(fields_of(section))


def fields_of(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """The fields of a table, by their keys in TOML."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def wanted_at(path: KeyPath) -> str:
    """Say what the schema wants at ``path``, its unit and its default; empty where it is silent."""
    keys = [key for key in path if not isinstance(key, int)]
    for length in range(len(keys), 0, -1):
        section, key = section_at(tuple(keys[: length - 1])), keys[length - 1]
        if section is not None:
            break
    else:
        return ""
    field = fields_of(section).get(key)
    if field is None:
        return section.free.phrase if section.free else ""
    truth = bool in (field.annotation, *get_args(field.annotation))
    phrase = _phrase(field.annotation, field.metadata) or ("true or false" if truth else "a table")
    default = field.default
    plain = isinstance(default, bool | int | float | str | tuple) and default not in ("", ())
    return f"{phrase} (default {value_text(default)})" if plain else phrase


def _phrase(annotation: Any, notes: Sequence[Any] = ()) -> str:
    """Find the outermost and latest :class:`Wanted` in an annotation, and in notes on it."""
    if phrases := [note.phrase for note in notes if isinstance(note, Wanted)]:
        return phrases[-1]
    if get_origin(annotation) is Annotated:
        return _phrase(get_args(annotation)[0], get_args(annotation)[1:])
    if get_origin(annotation) is Literal:
        *others, last = map(value_text, get_args(annotation))
        return f"{', '.join(others)} or {last}" if others else last
    inner = (_phrase(argument) for argument in get_args(annotation)[::-1])
    return next(filter(None, inner), "")


def model_in(annotation: Any, base: type[M]) -> type[M] | None:
    """Return the first model of a kind that an annotation names, such as of a list's entries."""
    if inspect.isclass(annotation) and issubclass(annotation, base):
        return annotation
    models = (model_in(argument, base) for argument in get_args(annotation))
    return next(filter(None, models), None)


def _dotted(path: KeyPath) -> str:
    """Join keys with dots; an index into a list of numbers is told by the message instead."""
    return ".".join(shortened(key_text(key)) for key in path if isinstance(key, str))


_SECTIONS = tuple(key for key in keys_of(Scenario) if has_keys((key,)))

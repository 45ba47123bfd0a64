"""The keys of ``[planner]`` that all planners share: as settings, and checked one by one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, get_args

from pydantic.fields import FieldInfo

from kinolab.errors import Mistake
from kinolab.scenario.load import check_document
from kinolab.scenario.schema import PlannerSection
from kinolab.scenario.values import Meaning
from kinolab.settings import Setting

_LIMITS = {"gt": "above", "ge": "lowest", "le": "highest"}  # as pydantic and settings name them


def shared_settings() -> tuple[Setting, ...]:
    """Return what every planner's section may say besides its name, read from the schema."""
    found = []
    for name, key in PlannerSection.model_fields.items():
        if name == "name":
            continue
        told: dict[str, Any] = {}
        for note in _notes(key):
            if isinstance(note, Meaning):
                told |= {"meaning": note.sentence, "unit": note.unit}
            told |= {_LIMITS[end]: getattr(note, end) for end in _LIMITS if hasattr(note, end)}
        found.append(Setting(name, key.default, **told))
    return tuple(found)


def argument_mistakes(call: str, given: Mapping[str, tuple[str, object]]) -> Iterator[Mistake]:
    """Check arguments of a call as the keys of ``[planner]`` that they stand for.

    Args:
        call: What was called.
        given: Key and value by the argument's name.
    """
    for argument, (key, value) in given.items():
        document = {"schema": 1, "title": "-", "system": {"name": "-"}, "planner": {key: value}}
        for mistake in check_document(document, Path())[1]:
            yield Mistake(f"{call} {argument}", mistake.what, mistake.remedy)


def _notes(annotation: object) -> Iterator[object]:
    """Yield what is noted on a key's type, and on the types within it."""
    if isinstance(annotation, FieldInfo):
        yield from _notes(annotation.annotation)
        yield from annotation.metadata
    for note in getattr(annotation, "__metadata__", ()):
        yield from _notes(note) if isinstance(note, FieldInfo) else (note,)
    for part in get_args(annotation):
        yield from _notes(part)

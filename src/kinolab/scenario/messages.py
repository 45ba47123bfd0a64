"""From what pydantic says about a document to what a user can act on."""

from __future__ import annotations

import difflib
from collections.abc import Mapping

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from kinolab.scenario.issues import Issue, KeyPath
from kinolab.scenario.locations import has_keys, is_table_entry, keys_of, section_at, wanted_at
from kinolab.scenario.rules import unknown_key
from kinolab.scenario.schema import RULE_ERROR, Scenario
from kinolab.scenario.toml_text import shown
from kinolab.scenario.values import TAGS, WORLD_AXES

PREDICATES = {
    "float_type": "is not a number",
    "int_type": "is not a whole number",
    "int_parsing_size": "is too large",
    "string_type": "is not text in quotes",
    "string_too_short": "is empty",
    "string_pattern_mismatch": "is not a colour",
    "string_unicode": "is not Unicode text",
    "bool_type": "is neither true nor false",
    "finite_number": "is not finite",
    "greater_than": "is too small",
    "greater_than_equal": "is too small",
    "less_than": "is too large",
    "less_than_equal": "is too large",
    "dict_type": "is not a table",
    "model_type": "is not a table",
    "tuple_type": "is not a list",
    "list_type": "is not a list",
    "missing": "is too short",
    "too_long": "is too long",
    "literal_error": "is none of the choices",
}


def explain(error: ValidationError, document: Mapping[str, object], limit: int) -> list[Issue]:
    """Describe the first errors; what several keys did together is left to the rules."""
    lines = error.errors(include_url=False, include_input=False)[:limit]
    issues = [_issue(line, document) for line in lines if line["type"] != RULE_ERROR]
    return list(dict.fromkeys(issues))  # a list that lacks two entries lacks them once


def _issue(line: ErrorDetails, document: Mapping[str, object]) -> Issue:
    axis = line["loc"][:2] == ("world", "bounds") and line["loc"][3:] == ("[key]",)
    path = _path(line["loc"][:3] if axis else line["loc"])
    if line["type"] == "extra_forbidden" or axis:
        return _unknown(path, _value(document, path))
    if line["type"] == "missing" and isinstance(path[-1], str):
        is_section = section_at(path) is not None
        remedy = _how_to_write(path) if is_section else f"Give {wanted_at(path)}."
        return Issue(path, f"the {'section' if is_section else 'key'} is missing.", remedy)
    if line["type"] == "missing":
        path = path[:-1]
    return _misfit(path, _predicate(line, _value(document, path)), _value(document, path))


def _path(location: KeyPath) -> KeyPath:
    """Drop the branches of unions that pydantic names on the way; they are no keys."""
    path: KeyPath = ()
    branched = False
    for part in location:
        if part in TAGS and not branched and not has_keys(path):
            branched = True
        else:
            path = (*path, part)
    return path


def _value(document: object, path: KeyPath) -> object:
    for part in path:
        if isinstance(document, dict):
            document = document.get(part)
        elif isinstance(document, list) and isinstance(part, int):
            document = document[part]
    return document


def _unknown(path: KeyPath, value: object) -> Issue:
    parent, key = section_at(path[:-1]), str(path[-1])
    if path[:-1] == ("world", "bounds"):
        return unknown_key(path, key, WORLD_AXES, "axis")
    is_section = len(path) == 1 and isinstance(value, dict | list)
    return unknown_key(path, key, keys_of(parent or Scenario), "section" if is_section else "key")


def _how_to_write(path: KeyPath) -> str:
    if len(path) == 1:
        own = keys_of(section) if (section := section_at(path)) else []
        listed = f" ({', '.join(own)})" if own else ""
        remedy = f"Write [{path[0]}] on a line of its own, and its keys{listed} below it"
        return f"{remedy}; in Python, a dictionary of them."
    return "Give a table such as { key = value }."


def _misfit(path: KeyPath, predicate: str, value: object) -> Issue:
    subject = shown(value)
    if isinstance(path[-1], int) and not is_table_entry(path):
        subject = f"entry {path[-1] + 1}, {subject},"
    if predicate == PREDICATES["dict_type"]:
        return Issue(path, f"{subject} {predicate}.", _how_to_write(path))
    phrase = wanted_at(path)
    remedy = f"{_hint(path, predicate, value)}{f'Give {phrase}.' if phrase else ''}"
    return Issue(path, f"{subject} {predicate}.", remedy)


def _predicate(line: ErrorDetails, value: object) -> str:
    if line["type"] == "kinolab_value":
        return str(line["ctx"]["predicate"])
    if line["type"] == "float_type" and isinstance(value, str):
        return "is text, not a number"
    if line["type"] == "float_type" and isinstance(value, int) and not isinstance(value, bool):
        return "is too large"
    return PREDICATES.get(line["type"], "does not fit here")


def _hint(path: KeyPath, predicate: str, value: object) -> str:
    """Guess what was meant: a misspelt choice, or a shared key among free ones."""
    if predicate == PREDICATES["literal_error"]:
        word = value if isinstance(value, str) else ""
        close = difflib.get_close_matches(word, wanted_at(path).split('"')[1::2], n=1)
        return f'Did you mean "{close[0]}"? ' if close else ""
    section = section_at(path[:1])
    if section is None or section.free is None or len(path) != 2 or path[1] in keys_of(section):
        return ""
    close = difflib.get_close_matches(str(path[1]), keys_of(section), n=1)
    return f"Did you mean {close[0]!r}? " if close else ""

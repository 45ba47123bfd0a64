"""YAML as a tree of values that know where they stand, with every key once and no aliases."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, TypeAlias

import yaml

from kinolab.errors import InputError, Mistake
from kinolab.untrusted import refuse_many

Found: TypeAlias = "list[tuple[int, Mistake]]"  # with the line of each
Value: TypeAlias = "dict[str, Entry] | list[Entry] | float | int | str | bool | None"

_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")  # as in YAML 1.2
_SYNTAX = "YAML has key: value, [lists] in brackets or with dashes, and blanks to indent."


@dataclass(frozen=True)
class Entry:
    """A value and where it stands.

    Attributes:
        value: Tables and lists hold entries.
        line: In the file, from 1.
        path: Of keys and indices from the top, such as ``robots[0].start``.
    """

    value: Value
    line: int
    path: str


def yaml_tree(text: str, label: str, mistakes: Found) -> Entry:
    """Read YAML and add keys that stand twice to a list of mistakes.

    Args:
        label: What mistakes call the file.
        mistakes: Where to add to.

    Raises:
        InputError: If it is not YAML, or has what no environment needs: aliases, several documents.
    """
    refuse_many(sum(map(text.count, ",:\n")), "values in yaml", label)
    try:
        root = yaml.compose(text, Loader=_Composer)
        if root is None:
            raise InputError([Mistake(label, "the file is empty.")])
        return _entry(root, "", label, mistakes)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{label} line {mark.line + 1}" if mark else label
        raise InputError([Mistake(where, f"this is not YAML: {error.problem}.", _SYNTAX)]) from None
    except (yaml.YAMLError, ValueError) as error:
        raise InputError([Mistake(label, f"this is not YAML: {error}.", _SYNTAX)]) from None
    except RecursionError:
        raise InputError([Mistake(label, "its lists or tables are nested too deep.")]) from None


class _Composer(yaml.SafeLoader):  # type: ignore[misc]
    """Composes trees without aliases, in which a small file may unfold to a huge one."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Refuse an alias."""
        if self.check_event(yaml.AliasEvent):
            mark = self.peek_event().start_mark
            raise yaml.composer.ComposerError(None, None, "an alias (*name) is not read", mark)
        return super().compose_node(parent, index)


def _entry(node: yaml.Node, path: str, label: str, mistakes: Found) -> Entry:
    line = node.start_mark.line + 1
    if isinstance(node, yaml.SequenceNode):
        items = [_entry(n, f"{path}[{i}]", label, mistakes) for i, n in enumerate(node.value)]
        return Entry(items, line, path)
    if isinstance(node, yaml.MappingNode):
        return Entry(_table(node, path, label, mistakes), line, path)
    return Entry(_scalar(node), line, path)


def _table(node: yaml.MappingNode, path: str, label: str, mistakes: Found) -> dict[str, Entry]:
    table: dict[str, Entry] = {}
    for key, value in node.value:
        name, line = str(key.value)[:60], key.start_mark.line + 1
        below = f"{path}.{name}" if path else name
        if not isinstance(key, yaml.ScalarNode):
            wrong = Mistake(f"{label} line {line}", "a key is a list or a table.")
            mistakes.append((line, wrong))
        elif name in table:
            what = f"{name} stands in line {table[name].line} already."
            wrong = Mistake(f"{label} line {line} {below}", what, "Keep one of them.")
            mistakes.append((line, wrong))
        else:
            table[name] = _entry(value, below, label, mistakes)
    return table


def _scalar(node: yaml.ScalarNode) -> float | int | str | bool | None:
    """Return what a scalar means; 1e-4, which YAML 1.1 takes for text, is a number."""
    kind, text = node.tag.rpartition(":")[2], str(node.value)
    if kind == "null":
        return None
    if kind == "bool":
        return text.lower() in ("yes", "true", "on")
    if node.style is None and _NUMBER.fullmatch(text):
        return float(text)
    if kind == "float" and text.lower().lstrip("+-") in (".inf", ".nan"):
        return math.inf if "inf" in text.lower() else math.nan
    return text

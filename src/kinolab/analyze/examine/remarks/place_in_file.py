"""The line of a machine's file in which a part is made: read from its text, nothing is run."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path

from kinolab.errors import KinolabError
from kinolab.files import read_ordinary


def place_in(file: Path | None, part: tuple[str, str]) -> str:
    """Return where a part of a machine is made, ``ball_beam.py, line 22``; empty if unknown.

    Args:
        file: The machine's file, in Python.
        part: The word that makes it and its name, such as ``("Body", "ball")``.
    """
    if file is None or file.suffix != ".py":
        return ""
    calls = [node for node in _nodes(file) if isinstance(node, ast.Call)]
    line = _line_of(calls, *part)
    return f"{file.name}, line {line}" if line else ""


def declared_with(file: Path | None, system: str) -> Iterator[tuple[str, str]]:
    """Yield the parameters that the function of a system declares, each with its unit.

    Args:
        file: The machine's file; nothing is yielded of one that is not Python.
        system: The system's name, which stands in its call.
    """
    if file is None or file.suffix != ".py":
        return
    makers = [node for node in _nodes(file) if isinstance(node, ast.FunctionDef)]
    makers = [node for node in makers if _makes(node, system)]
    for call in ast.walk(makers[0]) if len(makers) == 1 else ():
        if isinstance(call, ast.Call) and _called(call) == "parameter":
            texts = [a.value for a in call.args if isinstance(a, ast.Constant)]
            words = [text for text in texts if isinstance(text, str)]
            if call.args and words[:1] == [getattr(call.args[0], "value", None)]:
                yield words[0], words[-1] if len(words) > 1 else ""


def _makes(function: ast.FunctionDef, system: str) -> bool:
    calls = (node for node in ast.walk(function) if isinstance(node, ast.Call))
    return any(_called(call) == "System" and any(_says(a, system) for a in _texts(call)[:1])
               for call in calls)  # fmt: skip


@lru_cache(maxsize=8)
def _nodes(file: Path) -> tuple[ast.AST, ...]:
    try:
        # 1_000_000 [bytes] of a file that is looked at
        return tuple(ast.walk(ast.parse(read_ordinary(file, 1_000_000))))
    except (OSError, SyntaxError, ValueError, KinolabError):
        return ()


def _line_of(calls: Sequence[ast.Call], word: str, name: str) -> int:
    """Return the line of the call that fits best: by its name, as far as that can be read."""
    own = [call for call in calls if _called(call) == word]
    named = [call for call in own if any(_says(entry, name) for entry in _texts(call))]
    unread = [call for call in own if any(isinstance(a, ast.Name) for a in _texts(call)[:1])]
    system = [call for call in calls if _called(call) == "System"]
    found = (named or (own if not name else ()) or unread or system)[:1]
    return found[0].lineno if found else 0


def _called(call: ast.Call) -> str:
    function = call.func
    return getattr(function, "id", "") or getattr(function, "attr", "")


def _texts(call: ast.Call) -> list[ast.expr]:
    return [*call.args, *(keyword.value for keyword in call.keywords if keyword.arg == "name")]


def _says(entry: ast.expr, name: str) -> bool:
    """Whether an argument is a name, or an f-string that may become it."""
    if isinstance(entry, ast.Constant):
        return bool(name) and entry.value == name
    if isinstance(entry, ast.JoinedStr):
        parts = [
            re.escape(str(p.value)) if isinstance(p, ast.Constant) else ".*" for p in entry.values
        ]
        return re.fullmatch("".join(parts), name) is not None
    return False

"""Docstrings and signatures as Markdown."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any

import kinolab.dynamics

SECTIONS = ("Args", "Attributes", "Returns", "Yields", "Raises", "Source", "Note", "Example")


def first_line(thing: Any) -> str:
    """Return what a docstring says first."""
    return (inspect.getdoc(thing) or "").partition("\n")[0].replace("``", "`")


def methods(kind: type) -> dict[str, Any]:
    """Return the methods and properties of a class, inherited ones of kinolab included."""
    return {
        name: thing
        for base in reversed(kind.__mro__)
        if base.__module__.startswith("kinolab")
        for name, thing in vars(base).items()
        if isinstance(thing, property | classmethod | staticmethod)
        or inspect.isfunction(thing)
        or hasattr(thing, "func")
    }


def members_of(kind: type) -> list[str]:
    """Return a line about each public method and property of a class, but what it extends has."""
    public = [base for base in kind.__mro__[1:] if base.__name__ in kinolab.dynamics.__all__]
    known = {name for base in public for name in vars(base)}
    return [
        f"- `{shown(member, thing)}`: {first_line(thing)}"
        for member, thing in sorted(methods(kind).items())
        if not member.startswith("_") and member not in known and first_line(thing)
    ]


def shown(name: str, thing: Any) -> str:
    """Return a member as one writes it."""
    function = getattr(thing, "__func__", thing)
    return signature(name, function, inside=True) if inspect.isfunction(function) else name


class Bare(str):
    """A text that is shown without quotes."""

    __slots__ = ()
    __repr__ = str.__str__


def signature(name: str, thing: Callable[..., Any], *, inside: bool = False) -> str:
    """Return a call with its arguments; types are left to the docstring inside of a class."""
    empty = inspect.Parameter.empty
    parameters = [
        p.replace(
            annotation=empty if inside or p.annotation is empty else Bare(p.annotation),
            default=empty if p.default is empty else Bare(readable(p.default)),
        )
        for p in inspect.signature(thing).parameters.values()
    ]
    result = inspect.signature(thing).return_annotation
    back = "" if inside or result is empty or inspect.isclass(thing) else f" -> {result}"
    if inside and parameters and parameters[0].name in ("self", "cls"):
        del parameters[0]
    found = inspect.Signature(parameters)
    text = f"{name}{found}{back}"
    return text if inside or len(text) <= 100 else folded(name, found, back)


def readable(default: object) -> str:
    """Return the default of an argument without addresses in memory."""
    if callable(default):
        return getattr(default, "__name__", "...")
    return re.sub(r"<(?:class )?'?([\w.]+)[^>]*>", r"\1", repr(default))


def folded(name: str, found: inspect.Signature, back: str) -> str:
    """Return a long signature with one argument in a line."""
    lines, keyword_only = [], False
    for parameter in found.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and not keyword_only:
            keyword_only = True
            lines.append("    *,")
        keyword_only |= parameter.kind is parameter.VAR_POSITIONAL
        lines.append(f"    {parameter},")
    return "\n".join([f"{name}(", *lines, f"){back}"])


def markdown(text: str) -> str:
    """Return a docstring as Markdown: its sections as lists, its literals as code."""
    lines: list[str] = []
    inside = False
    for line in text.replace("``", "`").splitlines():
        head = re.fullmatch(rf"({'|'.join(SECTIONS)}):\s*(.*)", line)
        if head:
            inside = not head[2]
            lines += ["", f"**{head[1]}**" + (f": {head[2]}" if head[2] else ""), *[""] * inside]
        elif inside and re.match(r"    \S", line):
            entry = re.match(r"    (\*{0,2}[\w, .()]+): (.*)", line)
            lines.append(f"- `{entry[1]}`: {entry[2]}" if entry else f"- {line.strip()}")
        elif inside and line.startswith("     "):
            lines.append(f"  {line.strip()}")
        else:
            inside = inside and not line
            lines.append(line)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).strip()

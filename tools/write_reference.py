"""Write docs/reference.md, every public name with its signature and its docstring.

    python tools/write_reference.py [--check]

With --check nothing is written: it shows how the page differs and returns 1 if it does. A name is
public if a module of ``MODULES`` has it in ``__all__``.
"""

from __future__ import annotations

import argparse
import difflib
import inspect
import re
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference.md"
MODULES = (
    "kinolab",
    "kinolab.dynamics",
    "kinolab.systems",
    "kinolab.world",
    "kinolab.trajectory",
    "kinolab.search",
    "kinolab.simulation",
    "kinolab.trajopt",
    "kinolab.verification",
    "kinolab.dynamics.javascript",
    "kinolab.testing",
)
HEAD = """\
# Reference

Every public name, from the docstrings; `python tools/write_reference.py` writes this page. How the
parts work together is told in [the tutorial of the README](../README.md), and where they stand in
the code in [the architecture](architecture.md). Arrays are float64 unless something else is said;
`nx`, `nq`, `nt` and `nu` are the numbers of states, coordinates, independent directions and inputs.
"""
SECTIONS = ("Args", "Attributes", "Returns", "Yields", "Raises", "Source", "Note", "Example")


def page() -> str:
    """Return the text of the page."""
    modules = [import_module(name) for name in MODULES]
    contents = "\n".join(
        f"- [`{module.__name__}`](#{anchor(module.__name__)}): {first_line(module)}"
        for module in modules
    )
    parts = [part for module in modules for part in described(module)]
    return "\n\n".join([HEAD.rstrip(), contents, *parts]) + "\n"


def anchor(heading: str) -> str:
    """Return the link to a heading."""
    return heading.replace(".", "")


def first_line(thing: Any) -> str:
    """Return what a docstring says first."""
    return (inspect.getdoc(thing) or "").partition("\n")[0].replace("``", "`")


def public_names(module: ModuleType) -> list[str]:
    """Return what a module says is public; of one without ``__all__`` what is defined in it."""
    if hasattr(module, "__all__"):
        return sorted(module.__all__, key=str.lower)
    own = vars(module).items()
    return sorted(
        name
        for name, thing in own
        if not name.startswith("_") and getattr(thing, "__module__", "") == module.__name__
    )


def described(module: ModuleType) -> Iterator[str]:
    """Yield what the page says about a module."""
    yield f"## {module.__name__}"
    yield markdown(inspect.getdoc(module) or "")
    for name in public_names(module):
        thing = getattr(module, name)
        if inspect.ismodule(thing):
            yield f"### `{name}`"
            yield f"{first_line(thing)} See [`{thing.__name__}`](#{anchor(thing.__name__)})."
        elif inspect.isclass(thing):
            yield from described_class(name, thing)
        elif inspect.isfunction(thing):
            yield f"### `{name}`"
            yield f"```python\n{signature(name, thing)}\n```"
            yield markdown(inspect.getdoc(thing) or "")
        else:
            yield f"### `{name}`"
            yield f"`{readable(thing)}`"


def described_class(name: str, kind: type) -> Iterator[str]:
    """Yield what the page says about a class, its methods and properties."""
    yield f"### `{name}`"
    yield f"```python\n{signature('class ' + name, kind)}\n```"
    yield markdown(inspect.getdoc(kind) or "")
    members = [
        f"- `{shown(member, thing)}`: {first_line(thing)}"
        for member, thing in sorted(methods(kind).items())
        if not member.startswith("_") and first_line(thing)
    ]
    if members:
        yield "\n".join(members)


def methods(kind: type) -> dict[str, Any]:
    """Return the methods and properties of a class, inherited ones of kinolab included."""
    found: dict[str, Any] = {}
    for base in reversed(kind.__mro__):
        if base.__module__.startswith("kinolab"):
            found |= {
                name: thing
                for name, thing in vars(base).items()
                if isinstance(thing, property | classmethod | staticmethod)
                or inspect.isfunction(thing)
                or hasattr(thing, "func")
            }
    return found


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


def main() -> int:
    """Write the page, or check it."""
    parser = argparse.ArgumentParser(description="Write docs/reference.md.")
    parser.add_argument("--check", action="store_true", help="write nothing, show what differs")
    options = parser.parse_args()
    text = page()
    if not options.check:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    written = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    before, after = written.splitlines(keepends=True), text.splitlines(keepends=True)
    sys.stdout.writelines(difflib.unified_diff(before, after, PAGE.name, "as it should be"))
    return 0 if text == written else 1


if __name__ == "__main__":
    sys.exit(main())

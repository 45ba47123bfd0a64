"""Write docs/reference.md, every public name with its signature and its docstring.

    python tools/write_reference.py [--check]

With --check nothing is written: it shows how the page differs and returns 1 if it does. A name is
public if a module of ``MODULES`` has it in ``__all__``.
"""

from __future__ import annotations

import argparse
import difflib
import inspect
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType

from kinolab.cli.manual.docstrings import first_line, markdown, members_of, readable, signature

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
    "kinolab.dynamics.translation",
    "kinolab.robots",
    "kinolab.interchange",
    "kinolab.show.viewers",
    "kinolab.gym",
    "kinolab.testing",
)
HEAD = """\
# Reference

Every public name, from the docstrings; `python tools/write_reference.py` writes this page. How the
parts work together is told in [From Python](python.md), and where they stand in
the code in [the architecture](architecture.md). Arrays are float64 unless something else is said;
`nx`, `nq`, `nt` and `nu` are the numbers of states, coordinates, independent directions and inputs.
"""


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
    if members := members_of(kind):
        yield "\n".join(members)


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

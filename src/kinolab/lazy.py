"""Imports that come late: a package's names when first asked for, and libraries of extras."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from kinolab.errors import InputError, Mistake


def lazy_package(
    package: str, file: str, *further: str
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """Return a package's ``__all__``, ``__getattr__`` and ``__dir__``.

    Its names are those that it imports as themselves for type checkers, ``from a import b as b``;
    tab completion has all of them, imported or not.

    Args:
        package: Its ``__name__``.
        file: Its ``__file__``.
        further: Names besides those, for tab completion.
    """
    home_of: dict[str, str] = {}
    for node in ast.walk(ast.parse(Path(file).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            own = (alias.name for alias in node.names if alias.asname == alias.name)
            home_of |= dict.fromkeys(own, str(node.module))

    def imported(name: str) -> Any:
        if name not in home_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(home_of[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    def listed() -> list[str]:
        special = (name for name in vars(sys.modules[package]) if name.startswith("__"))
        return sorted({*special, *home_of, *further})

    names = sorted(home_of, key=lambda name: (not name.isupper(), name[0].islower(), name))
    return names, imported, listed


def library_of(extra: str, module: str, need: str) -> Any:
    """Import a library that only an extra of the installation brings.

    Args:
        extra: Its name, as in ``pip install 'kinolab[hdf5]'``.
        need: What needs which library, such as "films need PyAV".

    Raises:
        InputError: If it is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        what = f"{need}, which is not installed."
        raise InputError([Mistake(extra, what, f"pip install 'kinolab[{extra}]'")]) from error


@cache
def versions_of(*packages: str) -> dict[str, str | None]:
    """Return the installed versions of packages by name; None of those that are absent."""
    from importlib.metadata import PackageNotFoundError, version

    found: dict[str, str | None] = dict.fromkeys(packages)
    for package in packages:
        with suppress(PackageNotFoundError):
            found[package] = version(package)
    return found

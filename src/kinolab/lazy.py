"""Imports that come late: a package's names when first asked for, and libraries of extras."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from kinolab.errors import InputError, Mistake


def lazy_names(package: str, homes: Mapping[str, Iterable[str]]) -> Callable[[str], Any]:
    """Return a package's ``__getattr__``.

    Args:
        package: Its ``__name__``.
        homes: Names by the module that each is defined in.
    """
    home_of = {name: module for module, names in homes.items() for name in names}

    def imported(name: str) -> Any:
        if name not in home_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(home_of[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    return imported


def lazy_package(
    package: str, file: str, *further: str
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """Return a package's ``__all__``, ``__getattr__`` and ``__dir__``.

    Its names are those that it imports as themselves for type checkers, ``from a import b as b``.

    Args:
        package: Its ``__name__``.
        file: Its ``__file__``.
        further: Names besides those, for tab completion.
    """
    homes: dict[str, list[str]] = {}
    for node in ast.walk(ast.parse(Path(file).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            own = (alias.name for alias in node.names if alias.asname == alias.name)
            homes.setdefault(str(node.module), []).extend(own)
    names = [name for own in homes.values() for name in own]
    names.sort(key=lambda name: (not name.isupper(), name[0].islower(), name))
    return names, lazy_names(package, homes), public_names(package, *further)


def public_names(package: str, *further: str) -> Callable[[], list[str]]:
    """Return a package's ``__dir__``: its public names, imported or not, for tab completion.

    Args:
        package: Its ``__name__``.
        further: Names besides those in ``__all__``.
    """

    def names() -> list[str]:
        own = vars(sys.modules[package])
        special = (name for name in own if name.startswith("__"))
        return sorted({*special, *own["__all__"], *further})

    return names


def library_of(extra: str, module: str, need: str) -> Any:
    """Import a library that only an extra of the installation brings.

    Args:
        extra: Its name, as in ``pip install 'kinolab[hdf5]'``.
        module: The library's module.
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

    found: dict[str, str | None] = {}
    for package in packages:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = None
    return found

"""Planners in user files, referenced as ``file.py:Class``."""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path

from kinolab.errors import UnknownNameError
from kinolab.scenario.user_code import python_reference, run_file
from kinolab.search.planner import AbstractPlanner
from kinolab.search.plugins.planner_class import planner_class


def full_reference(name: str, folder: Path) -> str:
    """Return a planner's reference with an absolute path.

    Args:
        name: A registered name, returned unchanged, or ``file.py:Class``.
        folder: Folder that the file's path is relative to.
    """
    reference = python_reference(name)
    if reference is None:
        return name
    return f"{(folder / reference[0]).resolve()}:{reference[1]}"


def seen_from(folder: Path, name: str) -> str:
    """Return a planner's reference, its path relative to a folder instead of the working one."""
    reference = python_reference(name)
    if reference is None:
        return name
    path = os.path.relpath(os.path.realpath(reference[0]), os.path.realpath(folder))
    return f"{Path(path).as_posix()}:{reference[1]}"


def class_in(
    reference: tuple[str, str], where: str, taken: Collection[str]
) -> type[AbstractPlanner]:
    """Run a user's file and return the planner in it.

    Args:
        reference: The file and the name of the class.
        where: Location for error messages.

    Raises:
        InputError: If the file fails, or the class is missing or is no planner.
    """
    path, name = Path(reference[0]), reference[1]
    module = run_file(path, where)
    if name not in vars(module):
        raise UnknownNameError(f"class of {path.name}", name, known=_planners(module), where=where)
    return planner_class(vars(module)[name], f"{name} of {path.name}", where, taken)


def _planners(module: object) -> list[str]:
    """Return the names of the planners that a module defines, excluding imported ones."""
    return [
        name
        for name, value in vars(module).items()
        if isinstance(value, type)
        and issubclass(value, AbstractPlanner)
        and value.__module__ == getattr(module, "__name__", None)
    ]

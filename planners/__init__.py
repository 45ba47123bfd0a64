"""Planner registry: one file per built-in planner, and third-party planners.

A planner's name is that of its file in this folder, the one under which an installed package
registers it, or ``file.py:Class``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module, resources
from typing import Any

from kinolab.errors import InputError, MissingPlannerError, Mistake, UnknownNameError
from kinolab.scenario.user_code import python_reference
from kinolab.search import AbstractPlanner, plugins

if __name__ != "kinolab.planners":
    raise ImportError("Import this package as kinolab.planners; install the project first.")

WHERE = "[planner] name"


@cache
def built_in() -> tuple[str, ...]:
    """Return the names of all built-in planners; a file in this folder registers itself."""
    files = (entry.name for entry in resources.files(__name__).iterdir())
    stems = (name.removesuffix(".py") for name in files if name.endswith(".py"))
    return tuple(sorted(stem for stem in stems if not stem.startswith("_")))


def names() -> tuple[str, ...]:
    """Return the names of all planners, including those of installed packages."""
    return tuple(sorted({*built_in(), *plugins.registered()}))


def get(name: str, *, where: str = WHERE) -> type[AbstractPlanner]:
    """Return a planner's class.

    Args:
        name: A planner's name, or ``file.py:Class`` with a path from the working folder; the file
            is run.
        where: Location for error messages.

    Raises:
        UnknownNameError: If there is no such planner.
        MissingPlannerError: If a package it needs has no release for this platform.
        InputError: If its file or package fails or has no such planner.
    """
    if name in built_in():
        try:
            module = import_module(f"{__name__}.{name}")
        except ModuleNotFoundError as error:
            what = f"the planner {name!r} needs the package {error.name!r}, which is not installed."
            raise MissingPlannerError(what) from error
        return next(
            value
            for value in vars(module).values()
            if isinstance(value, type)
            and issubclass(value, AbstractPlanner)
            and getattr(value, "name", None) == name
        )
    reference = python_reference(name)
    if reference is not None:
        return plugins.class_in(reference, where, built_in())
    if name.endswith(".py"):
        remedy = 'Write "my_planner.py:Class".'
        raise InputError([Mistake(where, f"{name!r} does not name a class in a file.", remedy)])
    registered = plugins.registered()
    if name not in registered:
        raise UnknownNameError("planner", name, known=names(), where=where)
    return plugins.class_of(registered[name], where, built_in())


def misfits(planner: type[AbstractPlanner], settings: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """List (key, what is wrong, remedy) of invalid settings of a planner.

    Raises:
        InputError: If the code of a third-party planner fails.
    """
    with plugins.answerable(planner):
        return list(planner.misfits(settings))


def make(name: str, settings: Mapping[str, Any]) -> AbstractPlanner:
    """Return a planner with its settings.

    Raises:
        InputError: If there is no such planner or a setting is invalid; and as ``get``.
    """
    planner = get(name)
    with plugins.answerable(planner):
        return planner.from_settings(settings)

"""The planners: one file each, named like the planner in it; and those of other authors.

A planner is named by its file in this folder, by the name under which an installed package
registers it, or as ``file.py:Class``.
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
    """Return the name of every planner of kinolab's; a file in this folder registers itself."""
    files = (entry.name for entry in resources.files(__name__).iterdir())
    stems = (name.removesuffix(".py") for name in files if name.endswith(".py"))
    return tuple(sorted(stem for stem in stems if not stem.startswith("_")))


def names() -> tuple[str, ...]:
    """Return the name of every planner, those of installed packages included."""
    return tuple(sorted({*built_in(), *plugins.registered()}))


def get(name: str, *, where: str = WHERE) -> type[AbstractPlanner]:
    """Return a planner's class.

    Args:
        name: A planner's name, or ``file.py:Class`` with a path from the working folder; the file
            is run.
        where: What mistakes are reported for.

    Raises:
        UnknownNameError: If there is no such planner.
        MissingPlannerError: If a package it needs has no release for this platform.
        InputError: If the file or the package that it comes from fails, or has no such planner.
    """
    if name in built_in():
        return _built_in(name)
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


def _built_in(name: str) -> type[AbstractPlanner]:
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


def misfits(planner: type[AbstractPlanner], settings: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """List (key, what is wrong, what would work) of settings that do not fit a planner.

    Raises:
        InputError: If code of a planner that is not kinolab's fails.
    """
    with plugins.answerable(planner):
        return list(planner.misfits(settings))


def make(name: str, settings: Mapping[str, Any]) -> AbstractPlanner:
    """Return a planner with its settings.

    Raises:
        InputError: If there is no such planner, or a setting does not fit; and as ``get`` does.
    """
    planner = get(name)
    with plugins.answerable(planner):
        return planner.from_settings(settings)

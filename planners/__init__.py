"""The planners: one file each, named like the planner in it."""

from __future__ import annotations

from functools import cache
from importlib import import_module, resources

from kinolab.errors import MissingPlannerError, UnknownNameError
from kinolab.search import AbstractPlanner

if __name__ != "kinolab.planners":
    raise ImportError("Import this package as kinolab.planners; install the project first.")


@cache
def names() -> tuple[str, ...]:
    """Return the name of every planner; a file in this folder registers itself."""
    files = (entry.name for entry in resources.files(__name__).iterdir())
    stems = (name.removesuffix(".py") for name in files if name.endswith(".py"))
    return tuple(sorted(stem for stem in stems if not stem.startswith("_")))


def get(name: str) -> type[AbstractPlanner]:
    """Return a planner's class by its name.

    Raises:
        UnknownNameError: If there is no such planner.
        MissingPlannerError: If a package it needs has no release for this platform.
    """
    if name not in names():
        raise UnknownNameError("planner", name, known=names(), where="[planner] name")
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


def summary(name: str) -> str:
    """Return the first line of a planner's description."""
    return (get(name).__doc__ or "").strip().partition("\n")[0]

"""Validate that a class implements the planner interface."""

from __future__ import annotations

import inspect
from collections.abc import Collection, Iterator
from dataclasses import MISSING

from kinolab.errors import InputError, Mistake
from kinolab.scenario import PLANNER_KEYS
from kinolab.search.planner import AbstractPlanner
from kinolab.settings import KINDS, settings_of


def planner_class(
    candidate: object, label: str, where: str, taken: Collection[str]
) -> type[AbstractPlanner]:
    """Return a validated planner class.

    Args:
        candidate: The object that the user named.
        where: Location for error messages.

    Raises:
        InputError: With everything that is wrong with it.
    """
    if not (isinstance(candidate, type) and issubclass(candidate, AbstractPlanner)):
        kind = "a class" if isinstance(candidate, type) else _with_article(candidate)
        remedy = "Derive a class from kinolab.search.planner.AbstractPlanner."
        raise InputError([Mistake(where, f"{label} is {kind}, not a planner.", remedy)])
    faults = [*_naming(candidate, taken), *_methods(candidate), *_settings(candidate)]
    if faults:
        raise InputError(Mistake(where, f"{label} {what}", remedy) for what, remedy in faults)
    return candidate


def _with_article(thing: object) -> str:
    kind = type(thing).__name__
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def _naming(planner: type[AbstractPlanner], taken: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield (what is wrong, remedy) of a planner's name."""
    name = getattr(planner, "name", None)
    if not isinstance(name, str) or not name:
        yield "has no name.", f'Write name: ClassVar[str] = "{planner.__name__.lower()}" in it.'
    elif name in taken:
        yield f"calls itself {name!r}, as a planner of kinolab does.", "Choose another name."


def _methods(planner: type[AbstractPlanner]) -> Iterator[tuple[str, str]]:
    if not inspect.isabstract(planner):
        return
    missing = sorted(planner.__abstractmethods__)
    remedy = "Write def solve(self, problem, seed, budget)." if "solve" in missing else ""
    yield f"does not define {' and '.join(f'{method}()' for method in missing)}.", remedy


def _settings(planner: type[AbstractPlanner]) -> Iterator[tuple[str, str]]:
    """Yield (what is wrong, remedy) of the settings that a class declares."""
    if "__dataclass_fields__" not in vars(planner):
        yield "is not a dataclass.", "Write @dataclass(frozen=True, kw_only=True) above it."
        return
    for entry in settings_of(planner):
        if entry.name in PLANNER_KEYS:
            remedy = "Write name: ClassVar[str]." if entry.name == "name" else "Call it otherwise."
            yield f"has a setting {entry.name!r}, a key that all planners share.", remedy
        elif entry.default is MISSING:
            remedy = f"Write {entry.name}: … = setting(DEFAULT)."
            yield f"has a setting {entry.name!r} without a default.", remedy
        elif type(entry.default) not in KINDS:
            what = f"has a setting {entry.name!r} whose default is {entry.default!r}."
            yield what, f"A scenario can say: {', '.join(KINDS.values())}."
        elif misfit := entry.misfit(entry.default):
            yield f"has a setting {entry.name!r} whose default {misfit[0]}", misfit[1]

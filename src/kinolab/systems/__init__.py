"""Built-in machines: a file each, or for a family of them, whose functions have their names."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from importlib import import_module, resources
from typing import TYPE_CHECKING

from kinolab.errors import UnknownNameError

if TYPE_CHECKING:
    from kinolab.dynamics import System

_MACHINE = re.compile(r"^def ([a-z]\w*)\(\) -> System:", re.MULTILINE)


@cache
def _homes() -> dict[str, str]:
    """Return the module of every registered system: one with ``def name() -> System``."""
    files = (entry for entry in resources.files(__name__).iterdir() if entry.name.endswith(".py"))
    return {
        name: entry.name.removesuffix(".py")
        for entry in files
        for name in _MACHINE.findall(entry.read_text(encoding="utf-8"))
    }


@cache
def names() -> tuple[str, ...]:
    """Return the name of every registered system; a file in this folder registers its own."""
    return tuple(sorted(_homes()))


def get(name: str, **parameters: float) -> System:
    """Return a system by name, with parameter values by keyword: ``get("rolling_disk", R=0.3)``.

    Raises:
        UnknownNameError: If there is no such system.
        InputError: If there is no such parameter, or a value is not a number.
    """
    if name not in names():
        raise UnknownNameError("system", str(name), known=names())
    system = _described(name)
    return system.with_parameters(**parameters) if parameters else system


@cache
def _described(name: str) -> System:
    """Describe a system once: the panda's meshes take a second and a half."""
    return maker(name)()


def maker(name: str) -> Callable[[], System]:
    """Return the function that describes a system."""
    made: Callable[[], System] = getattr(import_module(f"{__name__}.{_homes()[name]}"), name)
    return made


def summary(name: str) -> str:
    """Return the first line of a system's docstring."""
    return (maker(name).__doc__ or "").strip().partition("\n")[0]

"""Built-in machines: one file each, named like its function."""

from __future__ import annotations

from functools import cache
from importlib import import_module, resources
from typing import TYPE_CHECKING

from kinolab.errors import UnknownNameError

if TYPE_CHECKING:
    from kinolab.dynamics import System


@cache
def names() -> tuple[str, ...]:
    """Return the name of every registered system; a file in this folder registers itself."""
    files = (entry.name for entry in resources.files(__name__).iterdir())
    stems = (name.removesuffix(".py") for name in files if name.endswith(".py"))
    return tuple(sorted(stem for stem in stems if not stem.startswith("_")))


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
    system: System = getattr(import_module(f"{__name__}.{name}"), name)()
    return system


def summary(name: str) -> str:
    """Return the first line of a system's docstring."""
    factory = getattr(import_module(f"{__name__}.{name}"), name)
    return (factory.__doc__ or "").strip().partition("\n")[0]

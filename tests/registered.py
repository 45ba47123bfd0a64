"""Registered machines as the laws of mechanics speak of them: one with modes, mode by mode."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from kinolab import systems
from kinolab.dynamics import System, in_mode


def mode_of(name: str, mode: str) -> System:
    """Return a registered machine as it is in one of its modes."""
    return System.of(in_mode(systems.get(name), mode))


JUDGED_BY_PINOCCHIO = {"panda"}  # tests/systems/test_panda.py: its law has a million terms
MAKERS: dict[str, Callable[[], System]] = {}
for _name in sorted(set(systems.names()) - JUDGED_BY_PINOCCHIO):
    if _modes := systems.get(_name).modes:
        MAKERS |= {f"{_name}, {mode.name}": partial(mode_of, _name, mode.name) for mode in _modes}
    else:
        MAKERS[_name] = partial(systems.get, _name)
NAMES = tuple(MAKERS)

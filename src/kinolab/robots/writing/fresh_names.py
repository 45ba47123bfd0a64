"""Names that nothing else has."""

from __future__ import annotations


def fresh_name(name: str, taken: set[str], between: str = " ") -> str:
    """Return a name that is not taken, with a number where it must have one, and take it."""
    found, k = name, 2
    while found in taken:
        found, k = f"{name}{between}{k}", k + 1
    taken.add(found)
    return found

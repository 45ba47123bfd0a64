"""Configuration spaces as products of lines, circles and others."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.dynamics import System
from kinolab.dynamics.language.mechanism_parts import AnyCoordinate, atoms_of, state_parts


def space_of(system: System) -> str:
    """Return the configuration space: ``R^2 x S^1 x S^1``.

    An angle with limits is an interval of the line; more than three circles are a torus ``T^n``.
    """
    kinds = [part.symbol for part in state_parts(system)]
    lines = kinds.count("R")
    factors = [f"R^{lines}" if lines > 1 else "R"] if lines else []
    circles = kinds.count("S^1")
    factors += [f"T^{circles}"] if circles > 3 else ["S^1"] * circles
    return " x ".join([*factors, *(kind for kind in kinds if kind not in {"R", "S^1"})])


def dimension_of(system: System) -> int:
    """Return the dimension of the configuration space; an attitude counts as three."""
    return sum(len(c.rates) for c in system.coordinates)


def mechanisms(system: System) -> list[tuple[str, ...]]:
    """Return the coordinate names of each mechanically independent mechanism.

    Coordinates belong together if a body depends on both, or a constraint, force or input involves
    both.
    """
    groups: list[set[str]] = []
    for part in (*system.bodies, *system.constraints, *system.efforts, *system.inputs):
        names = set(_coordinates_in(part))
        joined = [group for group in groups if group & names]
        groups = [group for group in groups if not group & names]
        if names:
            groups.append(names.union(*joined))
    order = [coordinate.name for coordinate in system.coordinates]
    rows = [tuple(sorted(group, key=order.index)) for group in groups]
    return sorted(rows, key=lambda row: order.index(row[0]))


def _coordinates_in(part: object) -> Iterator[str]:
    """Yield the names of the coordinates, or of their rates' coordinates, in a part."""
    for atom in atoms_of(part):
        for owner in (atom, getattr(atom, "coordinate", None), getattr(atom, "attitude", None)):
            if isinstance(owner, AnyCoordinate):
                yield owner.name

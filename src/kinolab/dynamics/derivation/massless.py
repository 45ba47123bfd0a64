"""What to do about a coordinate that nothing with mass resists."""

from __future__ import annotations

from collections.abc import Sequence

from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import atoms_of, coordinate_of


def remedy_for(system: Mechanism, coordinates: Sequence[str]) -> str:
    """Say what gives coordinates inertia: a missing body, or mass of those that move with them."""
    moved = []
    for body in system.bodies:
        own = {coordinate_of(atom) for atom in atoms_of(body.frame)}
        if any(c is not None and c.name in coordinates for c in own):
            moved.append(body.name)
    if not moved:
        named = " or ".join(coordinates)
        return f"No body moves with {named}: add the one that does to bodies."
    if len(moved) == 1:
        return f"Give {moved[0]!r} a mass or an inertia."
    return f"Give one of {', '.join(map(repr, moved))} a mass or an inertia."

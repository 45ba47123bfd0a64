"""What looks wrong about a machine's bodies: units of inertias, and pairs that are not named."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from kinolab.analyze.examine.law_check import LawCheck
from kinolab.dynamics import Body, Model
from kinolab.dynamics.language.mechanism_parts import MechanismParts
from kinolab.world import BodyGeometry, CollisionChecker, World
from kinolab.world.geometry import triangles

# A body's moments of inertia relative to m r^2, where r is the reach of its shape. No body that
# lies within its shape has more than 1; shapes may leave parts out. A wrong unit is a factor of 1e4
# (kg cm^2) at least.
LARGEST_INERTIA = 100.0
SMALLEST_INERTIA = 1e-3  # a sphere of a third of the radius has 0.04


def mistakes_in(model: Model, states: NDArray[np.float64]) -> Iterator[LawCheck]:
    """Yield what looks wrong about a machine's bodies.

    Args:
        model: The machine.
        states: Where bodies are looked at, shape (m, nx).
    """
    system = model.system
    for body in system.bodies:
        yield from _inertia(system, body)
    yield from _pairs(model, states)


def _inertia(system: MechanismParts, body: Body) -> Iterator[LawCheck]:
    """Compare the largest principal moment with mass and shape."""
    mass = system.number(body.mass)
    moments = np.array([system.number(entry) for entry in body.inertia_matrix]).reshape(3, 3)
    largest = float(np.linalg.eigvalsh(moments)[-1])
    corners = [triangles(shape)[0] for shape in system.resolved_shapes(body)]
    reach = max((float(np.linalg.norm(points, axis=1).max()) for points in corners), default=0.0)
    if not (mass > 0 and largest > 0 and reach > 0):
        return  # a point mass, or a wheel whose mass counts elsewhere
    law, share = f"the inertia of {body.name} fits its mass and shape", largest / (mass * reach**2)
    units = "is it in kg m^2? 1 kg m^2 = 10^7 g cm^2"
    told = f"{largest:.3g} kg m^2, where {mass:.3g} kg within {reach:.3g} m have at most "
    told += f"{mass * reach**2:.3g} kg m^2"
    if share > 1:
        yield LawCheck(law, share, LARGEST_INERTIA, f"{told}; {units}")
    elif share < SMALLEST_INERTIA:
        yield LawCheck(law, 1 / share, 1 / SMALLEST_INERTIA, f"{told}; {units}")


def _pairs(model: Model, states: NDArray[np.float64]) -> Iterator[LawCheck]:
    """Say which bodies pass through each other because no pair of them is named."""
    system = model.system
    solid = [body for body in system.bodies if body.shapes]
    geometry = [body for body in model.machine.bodies if body.shapes]
    watched = {frozenset(pair) for pair in (*system.collisions, *system.unwatched)}
    pairs = [(a.name, b.name) for a, b in combinations(solid, 2)]
    pairs = [pair for pair in pairs if frozenset(pair) not in watched]
    kept = [k for k, body in enumerate(system.bodies) if body.shapes]
    frames = model.frames(np.vstack([model.rest(), states]))[:, kept]
    through = [pair for pair in pairs if _meets_sometimes(geometry, pair, frames)]
    if through:
        named = "; ".join(f"{a} and {b}" for a, b in through)
        note = f"but these may pass through each other: {named}. A machine in Python names "
        note += f"the pairs that must not touch: collisions=[{through[0]!r}]"
        yield LawCheck("pairs of bodies that are named keep apart", 0.0, 0.0, note)


def _meets_sometimes(
    geometry: list[BodyGeometry], pair: tuple[str, str], frames: NDArray[np.float64]
) -> bool:
    """Say whether two bodies touch at some of several poses, but not at all: not by a joint."""
    own = [k for k, body in enumerate(geometry) if body.name in pair]
    checker = CollisionChecker([geometry[k] for k in own], World(), self_pairs=[pair])
    found = [checker.collides(poses[own]) for poses in frames]
    return any(found) and not all(found)

"""Squares of the plane that a body's origin cannot enter, and the shortest way round them.

A square counts as blocked only if that is sure, however the machine is turned; so no way is longer
than the shortest one that there is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.mode_formulas import ModeFormulas
from kinolab.dynamics.language.shapes import Cylinder, Shape, Sphere
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.lower_bound.shortest_path import shortest_path
from kinolab.world import BodyGeometry, CollisionChecker, World
from kinolab.world.shapes.geometry import placement

Solid: TypeAlias = tuple[float, Callable[[float], Shape]]  # its radius, and it with another one
CORNERS = 64  # of the polygon that stands for a disc
FLAT = 1e-3  # times the radius: its thickness


def free_way(
    problem: PlanningTask, mode: ModeFormulas, body: int, start: Array, low: Array, high: Array
) -> float:
    """Return how far a body's origin has to go at least in the plane, in [m]; 0: nothing is known.

    Args:
        problem: Provides bodies, obstacles and limits of the world.
        mode: Formulas of bodies' places.
        body: Which; its origin must stay at one height.
        start: Where its origin is, shape (3,) in [m].
        low: Lower corner of a box where it may end, shape (3,) in [m].
        high: Upper corner.
    """
    parameters = zip(mode.parameters, problem.model.plant.parameter_vector(), strict=True)
    values = {name: np.asarray(value) for name, value in parameters}
    bodies = len(problem.bodies)
    seats = np.reshape([float(seat) for seat in mode.seats(values)], (bodies, bodies, 3))[body]
    level = not mode.frames.part([12 * body + 11]).variables - set(mode.parameters)
    solids = inner_solids(problem, mode, seats) if level else []
    if not (solids and problem.world.obstacles and np.isfinite([low, high]).all()):
        return 0.0
    ends = np.array([start[:2], low[:2], high[:2]])
    blocked, first, edge = blocked_squares(problem, solids, float(start[2]), ends)
    last = np.array(blocked.shape) - 1  # a goal may reach beyond the world
    own, below, above = np.clip(np.floor((ends - first) / edge).astype(int), 0, last)
    blocked[own[0], own[1]] = False
    blocked[below[0] : above[0] + 1, below[1] : above[1] + 1] = False  # the way to the middle
    middle = 0.5 * (ends[1] + ends[2])
    found = shortest_path(blocked, (ends[0] - first) / edge, (middle - first) / edge) * edge
    return float(found - np.linalg.norm(ends[2] - middle)) if np.isfinite(found) else 0.0


def inner_solids(problem: PlanningTask, mode: ModeFormulas, seats: Array) -> list[Solid]:
    """Return solids about a point that bodies hold whatever the heading, in the world's axes.

    They are discs in bodies that only turn about the vertical, and balls in others.

    Args:
        seats: Where the point is in each body's axes, (bodies, 3) in [m]; NaN where that changes.
    """
    operations, ends = mode.frames.operations, mode.frames.ends
    found: list[Solid] = []
    for k, body in enumerate(problem.bodies):
        if np.isnan(seats[k]).any():
            continue
        up = operations[ends[12 * k + 10]]
        upright = up.name == "const" and up.value == 1.0
        for shape in body.shapes:
            own = placement(shape)
            if upright:
                height = float(own[2, 3])
                middle = np.array([seats[k, 0], seats[k, 1], height])
                radius = _disc(shape, own, middle)
                at = (0.0, 0.0, height - float(seats[k, 2]))
                found.append((radius, partial(Cylinder, length=FLAT * radius, at=at)))
            else:
                radius = float(shape.depths(own[:, :3].T @ (seats[k] - own[:, 3])))
                found.append((radius, Sphere))
    return [solid for solid in found if solid[0] > 0.0]


def _disc(shape: Shape, own: Array, middle: Array) -> float:
    """Return the radius of a horizontal disc about a point in a shape, some of its height in it."""
    turns = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
    rim = np.stack([np.cos(turns), np.sin(turns), np.zeros(CORNERS)], axis=1)
    low, high = 0.0, float(2.0 * np.linalg.norm(shape.lowered()[1][:3]))
    while high - low > 1e-3 * high:
        radius = 0.5 * (low + high)
        sides = FLAT * radius * np.array([[[0, 0, 1]], [[0, 0, -1]]])
        corners = (middle + radius * rim + sides - own[:, 3]) @ own[:, :3]
        low, high = (radius, high) if (shape.depths(corners) >= 0.0).all() else (low, radius)
    return low * float(np.cos(np.pi / CORNERS))


def blocked_squares(
    problem: PlanningTask, solids: Sequence[Solid], height: float, points: Array
) -> tuple[NDArray[np.bool_], Array, float]:
    """Return the squares of the plane of which a point can be in none, for sure.

    A square is blocked if a solid about its middle, slimmer by half its diagonal, hits anything:
    about every other point of it, the solid holds the slimmer one.

    Args:
        problem: Provides obstacles, and limits of the world.
        solids: About the point, in the world's axes.
        height: Of the point in [m].
        points: Places (n, 2) in [m] that belong to the plane in any case.

    Returns:
        Which squares are blocked, the corner of the first (2,) and their edge in [m].
    """
    world, radii = problem.world, [radius for radius, _ in solids]
    spread = [o.vertices[:, :2] for o in world.obstacles]
    low, high = (side(np.vstack([points, *spread]), axis=0) for side in (np.min, np.max))
    limits = [world.bounds.get(axis, (-np.inf, np.inf)) for axis in "xy"]
    low, high = np.maximum(low, [a for a, _ in limits]), np.minimum(high, [b for _, b in limits])
    edge = max(float((high - low).max()) / 512, 0.25 * max(radii))
    shape = np.ceil((high - low) / edge).astype(int) + 2
    first, half = low - edge, edge / np.sqrt(2.0)
    # [m], below which a solid is no help
    slim = [made(radius - half) for radius, made in solids if radius - half > 1e-6]
    blocked = np.zeros(shape, dtype=bool)
    for axis, (below, above) in enumerate(limits):
        middles = first[axis] + edge * np.arange(shape[axis] + 1)
        beyond = (middles[1:] <= below) | (middles[:-1] >= above)
        blocked |= beyond[:, None] if axis == 0 else beyond
    if not slim:
        return blocked, first, edge
    checker = CollisionChecker(
        [BodyGeometry("inside", tuple(slim), touches_ground=True)],
        World(world.obstacles, clearance=world.clearance),
    )
    size = 1 << int(np.ceil(np.log2(shape.max())))
    cells = np.zeros((1, 2), dtype=int)
    while True:
        middle = first + edge * (cells + 0.5 * size)
        poses = np.zeros((len(cells), 1, 12))
        poses[:, 0, [0, 5, 10]] = 1.0
        poses[:, 0, [3, 7]], poses[:, 0, 11] = middle, height
        reach = 0.5 * size * edge * np.sqrt(2.0)
        free = checker.clearances(poses, most=2.0 * reach)
        if size == 1:
            hit = cells[free <= 0.0]
            blocked[hit[:, 0], hit[:, 1]] = True
            return blocked, first, edge
        cells = cells[free < reach]
        size //= 2
        quarters = np.array([[0, 0], [0, 1], [1, 0], [1, 1]]) * size
        cells = (cells[:, None] + quarters).reshape(-1, 2)
        cells = cells[(cells < shape).all(axis=1)]

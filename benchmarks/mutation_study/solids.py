"""Where bodies are, and how deep a point lies in one: closed forms, and NumPy on SymPy's frames.

A place in a body is found by projection on its convex shape, the nearest place of a mesh by
projection on every triangle (trimesh); the two in turn lead to a pair of nearest points. No tree,
no bound and no library for collisions is asked.

Source: Cheney, Goldstein, Proximity maps for convex sets, Proc. AMS 10(3), 1959 (projections in
turn converge to the nearest points of two convex sets).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import sympy
import trimesh
from numpy.typing import NDArray

from kinolab.dynamics import Box, Capsule, Cylinder, Disk, Sphere
from kinolab.dynamics.language.frames import homogeneous
from kinolab.problem import PlanningTask
from kinolab.world.obstacles.obstacle import Obstacle

Array: TypeAlias = NDArray[np.float64]

TURNS = 40  # projections in turn
# Columns: the axes of a frame whose z axis is the shape's, in the body's frame.
UPRIGHT = {
    "x": np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "y": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
    "z": np.eye(3),
}


@dataclass(frozen=True)
class Solid:
    """A convex shape somewhere: axes (3, 3) as columns and centre (3,) in the world, in [m]."""

    shape: Any
    turn: Array
    centre: Array

    def local(self, point: Array) -> Array:
        """Return a point of the world in the shape's frame."""
        return np.asarray(self.turn.T @ (point - self.centre))

    def depth(self, point: Array) -> float:
        """Return how deep a point lies in the shape in [m]; negative outside."""
        p, shape = self.local(point), self.shape
        rho = float(np.hypot(p[0], p[1]))
        match shape:
            case Box():
                return float(np.min(np.array([shape.x, shape.y, shape.z]) / 2 - np.abs(p)))
            case Sphere():
                return float(shape.radius - np.linalg.norm(p))
            case Capsule():
                along = np.clip(p[2], -shape.length / 2, shape.length / 2)
                return float(shape.radius - np.hypot(rho, p[2] - along))
            case Cylinder():
                return float(min(shape.radius - rho, shape.length / 2 - abs(p[2])))
            case Disk():
                return float(min(shape.radius - rho, shape.thickness / 2 - abs(p[2])))
        raise TypeError(f"not a shape: {shape!r}")

    def nearest(self, point: Array) -> Array:
        """Return the place of the shape that is nearest to a point of the world."""
        p, shape = self.local(point), self.shape
        match shape:
            case Box():
                half = np.array([shape.x, shape.y, shape.z], dtype=float) / 2
                near = np.clip(p, -half, half)
            case Sphere():
                near = p * min(1.0, shape.radius / max(float(np.linalg.norm(p)), 1e-300))
            case Capsule():
                axis = np.array([0.0, 0.0, np.clip(p[2], -shape.length / 2, shape.length / 2)])
                out = p - axis
                near = axis + out * min(1.0, shape.radius / max(float(np.linalg.norm(out)), 1e-300))
            case _:
                end = (shape.length if isinstance(shape, Cylinder) else shape.thickness) / 2
                rho = max(float(np.hypot(p[0], p[1])), 1e-300)
                near = np.array([*(p[:2] * min(1.0, shape.radius / rho)), np.clip(p[2], -end, end)])
        return np.asarray(self.turn @ near + self.centre)

    def inner(self, generator: np.random.Generator) -> Array:
        """Return a random place within the shape."""
        shape = self.shape
        match shape:
            case Box():
                half = np.array([shape.x, shape.y, shape.z], dtype=float) / 2
            case Sphere():
                half = np.full(3, float(shape.radius))
            case Capsule():
                half = np.array([shape.radius, shape.radius, shape.length / 2 + shape.radius])
            case Cylinder():
                half = np.array([shape.radius, shape.radius, shape.length / 2])
            case _:
                half = np.array([shape.radius, shape.radius, shape.thickness / 2])
        while True:
            place = np.asarray(
                self.turn @ (generator.uniform(-1, 1, 3) * half.astype(float)) + self.centre
            )
            if self.depth(place) > 0:
                return place


class Bodies:
    """The bodies of a problem's machine: a frame for each, as a function of the configuration."""

    def __init__(self, problem: PlanningTask) -> None:
        self.problem = problem
        self.nq = problem.model.nq
        self.names = tuple(body.name for body in problem.system.bodies)
        self.shapes = [tuple(body.shapes) for body in problem.machine.bodies]
        self.cables = [cable.radius for cable in problem.machine.cables if cable.collides]

    @cached_property
    def _frames(self) -> Any:
        return self._compiled([body.frame for body in self.problem.system.bodies])

    @cached_property
    def _ends(self) -> Any:
        colliding = [cable for cable in self.problem.system.cables if cable.collides]
        return self._compiled([end for cable in colliding for end in cable.between])

    def _compiled(self, many: list[Any]) -> Any:
        """Return all of some frames as a function of the configuration."""
        system = self.problem.system
        names = list(self.problem.model.state_names[: self.nq])
        plain = [sympy.Symbol(f"s{i}") for i in range(self.nq)]
        values = {p: sympy.Float(system.parameter_values[p.name], 17) for p in system.parameters}
        frames = [homogeneous(frame) for frame in many]
        swap = dict(values)
        for symbol in set().union(*(frame.free_symbols for frame in frames)) - set(values):
            swap[symbol] = plain[names.index(symbol.name)]
        return sympy.lambdify([plain], [frame.xreplace(swap) for frame in frames], cse=True)

    def poses(self, x: Array) -> list[Array]:
        """Return the frames of all bodies at a state, each (4, 4)."""
        return [np.asarray(pose, dtype=float) for pose in self._frames(x[: self.nq].tolist())]

    def solids(self, x: Array) -> list[Solid]:
        """Return all shapes of all bodies at a state, and the cables that collide."""
        return self._of_bodies(x) + self._of_cables(x)

    def _of_cables(self, x: Array) -> list[Solid]:
        if not self.cables:
            return []
        ends = [np.asarray(pose, dtype=float)[:3, 3] for pose in self._ends(x[: self.nq].tolist())]
        found = []
        for k, radius in enumerate(self.cables):
            one, other = ends[2 * k : 2 * k + 2]
            length = float(np.linalg.norm(other - one))
            along = (other - one) / length
            across = np.linalg.svd(along[None])[2][1:]
            turn = np.column_stack([across[0], np.cross(along, across[0]), along])
            found.append(Solid(Capsule(float(radius), length), turn, (one + other) / 2))
        return found

    def _of_bodies(self, x: Array) -> list[Solid]:
        return [
            Solid(
                shape,
                pose[:3, :3] @ UPRIGHT[getattr(shape, "axis", "z")],
                pose[:3, :3] @ np.array(shape.at, dtype=float) + pose[:3, 3],
            )
            for pose, shapes in zip(self.poses(x), self.shapes, strict=True)
            for shape in shapes
        ]


class Still:
    """An obstacle, to be projected on."""

    def __init__(self, obstacle: Obstacle) -> None:
        self.obstacle = obstacle
        self.solid: Solid | None = None
        if obstacle.primitive is not None:
            shape, pose = obstacle.primitive
            turn = pose[:, :3] @ UPRIGHT[getattr(shape, "axis", "z")]
            centre = pose[:, :3] @ np.array(shape.at, dtype=float) + pose[:, 3]
            self.solid = Solid(shape, turn, centre)
        else:
            self.triangles = obstacle.vertices[obstacle.faces]
            self._middles = self.triangles.mean(axis=1)
            reaches = np.linalg.norm(self.triangles - self._middles[:, None], axis=2)
            self._reach = reaches.max(axis=1)

    def nearest(self, point: Array) -> Array:
        """Return the place of the obstacle that is nearest to a point outside of it."""
        if self.solid is not None:
            return self.solid.nearest(point)
        far = np.linalg.norm(self._middles - point, axis=1)
        near = self.triangles[far - self._reach <= (far + self._reach).min()]
        places = trimesh.triangles.closest_point(near, np.broadcast_to(point, (len(near), 3)))
        return np.asarray(places[np.argmin(((places - point) ** 2).sum(axis=1))])


def nearest_pair(still: Still, solid: Solid, rounds: int = TURNS) -> tuple[Array, Array]:
    """Return places of an obstacle and of a shape that are nearest to each other, at least nearby.

    Of a mesh they are a local minimum. Both places are exact: one lies on each.
    """
    there = still.nearest(solid.centre)
    here = solid.nearest(there)
    for _ in range(rounds):
        before = there
        there = still.nearest(here)
        here = solid.nearest(there)
        if float(np.abs(there - before).max()) < 1e-9:
            break
    return there, here

"""Inputs as motors of joints and as thrusters of bodies.

Whether an input acts on one joint alone, in whatever way it is written, is found from the forces
that it gives in several positions of the machine.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import sympy

from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.forces import Load
from kinolab.dynamics.language.frames import AXES, Axis, Frame, relative_pose
from kinolab.dynamics.language.inputs import Input, bounds_of
from kinolab.dynamics.language.lowered import loads, prescribes
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import AnyCoordinate
from kinolab.dynamics.language.quantities import Change, PointSpeed, SquaredDistance, TurnSpeed
from kinolab.dynamics.language.symbols import Coordinate
from kinolab.errors import Mistake
from kinolab.numerics.arrays import Array
from kinolab.numerics.quaternions import random_attitude, to_matrices
from kinolab.robots.kinematic_tree import Motor, Thruster, pose_of
from kinolab.robots.writing.file_numbers import rounded
from kinolab.robots.writing.frame_chains import FrameChains, joints_along

POSITIONS = 6  # of the machine, in which forces are compared
RANGE = 2.0  # [m] or [rad] on either side of zero, or on the near side of a limit
SAME = 1e-11  # relative: what differs less, differs by rounding

Position: TypeAlias = Mapping[AnyCoordinate, float | Array]


class _Push(NamedTuple):
    """A force and a torque (3,) at a point, in world axes, on what moves with a frame."""

    frame: Frame
    force: Array
    torque: Array
    point: Array


class InputPushes:
    """What the inputs of a machine push.

    Args:
        system: The machine.
        chains: Of its frames.
        factors: Positions of joints, relative to their coordinates.
    """

    def __init__(
        self, system: Mechanism, chains: FrameChains, factors: Mapping[AnyCoordinate, float]
    ) -> None:
        self._system, self._chains = system, chains
        self._factors = dict.fromkeys(system.coordinates, 1.0) | dict(factors)
        self._positions = _positions(system.coordinates)
        self._bodies = {body.frame: body for body in reversed(system.bodies)}

    def of(self, entry: Input) -> Motor | Thruster | Mistake | None:
        """Return an input as what a tree has; None where a frame of it is among the mistakes."""
        where = f"input {entry.name!r}"
        if prescribes(entry):
            what = f"it is a {type(entry).__name__}, which prescribes a motion."
            return Mistake(
                where, what, "Only what pushes is written: Torque, Force, Pull, Control."
            )
        acting = [e for _, e in loads(self._system) if entry.symbol in exact(e.magnitude).atoms()]
        if any(self._chains.of(frame, where) is None for e in acting for frame in _frames(e)):
            return None
        factors = [self._per_unit(load, entry) for load in acting]
        known = [pair for pair in zip(acting, factors, strict=True) if pair[1] is not None]
        if len(known) < len(acting):
            what = "its force is not constant times the input."
            return Mistake(where, what, "Let the wrench be linear in it, with constant factors.")
        pushes = [[*self._pushes(known, at)] for at in self._positions]
        found = self._motor(entry, pushes) or self._thruster(entry, pushes, self._place_of(acting))
        if found is None:
            what = "it acts neither on one joint nor on one body alone by a constant force."
            remedy = "Let its torque act about a joint's axis and react on the joint's other side."
            return Mistake(where, what, remedy)
        return found

    def _motor(self, entry: Input, pushes: Sequence[Sequence[_Push]]) -> Motor | None:
        """Return the motor of a joint, if an input acts on one with a constant factor."""
        forces = [
            self._on_coordinates(each, at) for each, at in zip(pushes, self._positions, strict=True)
        ]
        table = np.array([np.concatenate([*row.values()]) for row in forces])
        owners = [c for c, parts in forces[0].items() for _ in parts]
        size = np.abs(table).max()
        (moved,) = np.nonzero(np.abs(table).max(axis=0) > SAME * size)
        if len(moved) != 1:
            return None
        c, column = owners[moved[0]], table[:, moved[0]]
        if not isinstance(c, Coordinate) or np.ptp(column) > SAME * size:
            return None
        gear = rounded(float(np.median(column)) / self._factors[c])
        return Motor(entry.name, c.name, *bounds_of(entry), gear)

    def _thruster(
        self, entry: Input, pushes: Sequence[Sequence[_Push]], place: Array
    ) -> Thruster | None:
        """Return what pushes one body alone, alike in the body's axes, about a point (3,) of it."""
        bodies = {self._bodies.get(push.frame) for each in pushes for push in each}
        (body,) = bodies if len(bodies) == 1 else (None,)
        if body is None:
            return None
        found = []
        for each, at in zip(pushes, self._positions, strict=True):
            pose = self._pose(body.frame, at)
            turn, origin = pose[:3, :3], pose[:3, :3] @ place + pose[:3, 3]
            force, torque = np.zeros(3), np.zeros(3)
            for push in each:
                force += push.force
                torque += push.torque + np.cross(push.point - origin, push.force)
            found.append([*(turn.T @ force), *(turn.T @ torque)])
        wrenches, size = np.array(found), np.abs(found).max()
        if not size or np.ptp(wrenches, axis=0).max() > SAME * size:
            return None
        exact = np.where(np.abs(wrenches[0]) > SAME * size, wrenches[0], 0.0)
        wrench = np.array([rounded(float(part)) for part in exact])
        lower, upper = bounds_of(entry)
        pose = pose_of(place, np.eye(3))
        return Thruster(entry.name, body.name, pose, wrench[:3], wrench[3:], lower, upper)

    def _place_of(self, acting: Sequence[Load]) -> Array:
        """Return the point (3,) of its body at which an input acts; the origin, if at several."""
        speeds = [load.velocity for load in acting if isinstance(load.velocity, PointSpeed)]
        places = {tuple(relative_pose(speed.at, speed.on)[1]) for speed in speeds}
        at = (
            [self._chains.numbers(exact(part)) for part in places.pop()] if len(places) == 1 else []
        )
        plain = at and not any(part.free_symbols for part in at)
        return np.array(at if plain else (0, 0, 0), dtype=float)

    def _per_unit(self, load: Load, entry: Input) -> float | None:
        """Return a load's magnitude for each unit of an input; None if it is not constant."""
        slope = sympy.simplify(sympy.diff(self._chains.numbers(load.magnitude), entry.symbol))
        return None if slope.free_symbols else float(slope)

    def _pushes(self, acting: Sequence[tuple[Load, float]], at: Position) -> Iterator[_Push]:
        """Yield what loads with some magnitudes do in a position of the machine."""
        still = np.zeros(3)
        for load, magnitude in acting:
            speed = load.velocity
            if isinstance(speed, PointSpeed):
                force = magnitude * self._axis(speed.along, at)
                yield _Push(speed.on, force, still, self._pose(speed.at, at)[:3, 3])
            elif isinstance(speed, TurnSpeed):
                yield _Push(speed.on, still, magnitude * self._axis(speed.about, at), still)
            for ends in _distances(load):
                one, other = (self._pose(frame, at)[:3, 3] for frame in ends.between)
                square = float((other - one) @ (other - one))
                slope = sympy.diff(speed.position, ends).subs(ends, square) if square else 0
                along = 2 * magnitude * float(slope) * (other - one)
                for frame, force, point in zip(
                    ends.between, (-along, along), (one, other), strict=True
                ):
                    yield _Push(frame, force, still, point)

    def _pose(self, frame: Frame, at: Position) -> Array:
        return joints_along(self._chains.known(frame), at)[0]

    def _axis(self, axis: Axis, at: Position) -> Array:
        column: Array = self._pose(axis.frame, at)[:3, AXES[axis.name]]
        return column

    def _on_coordinates(self, pushes: Sequence[_Push], at: Position) -> dict[AnyCoordinate, Array]:
        """Return the generalised forces of pushes: three for an attitude, in its own axes."""
        total = {
            c: np.zeros(1 if isinstance(c, Coordinate) else 3) for c in self._system.coordinates
        }
        for push in pushes:
            for move, pose in joints_along(self._chains.known(push.frame), at)[1]:
                turning = push.torque + np.cross(push.point - pose[:3, 3], push.force)
                if move.kind == "ball":
                    own = pose[:3, :3] @ np.asarray(at[move.coordinate])
                    total[move.coordinate] += own.T @ turning
                    continue
                felt = push.force if move.kind == "prismatic" else turning
                total[move.coordinate] += move.factor * (pose[:3, :3] @ move.axis @ felt)
        return total


def _frames(load: Load) -> Iterator[Frame]:
    """Yield the frames that a load acts on, or along."""
    speed = load.velocity
    if isinstance(speed, PointSpeed):
        yield from (speed.on, speed.along.frame, speed.at)
    elif isinstance(speed, TurnSpeed):
        yield from (speed.on, speed.about.frame)
    for ends in _distances(load):
        yield from ends.between


def _distances(load: Load) -> list[SquaredDistance]:
    """Return the distances along which a load acts."""
    along = load.velocity.position if isinstance(load.velocity, Change) else sympy.Integer(0)
    return sorted(along.atoms(SquaredDistance), key=str)


def _positions(coordinates: Sequence[AnyCoordinate]) -> list[Position]:
    """Return positions of a machine at random, within its limits."""
    generator = np.random.default_rng(0)

    def drawn(c: AnyCoordinate) -> float | Array:
        if not isinstance(c, Coordinate):
            return to_matrices(random_attitude(generator))
        low = c.lower if np.isfinite(c.lower) else min(-RANGE, c.upper - RANGE)
        high = c.upper if np.isfinite(c.upper) else max(RANGE, c.lower + RANGE)
        return float(generator.uniform(low, high))

    return [{c: drawn(c) for c in coordinates} for _ in range(POSITIONS)]

"""Inputs as motors of joints and as thrusters of bodies.

Whether an input acts on one joint alone, in whatever way it is written, is found from the forces
that it gives in several positions of the machine.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import sympy

from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.forces import Wrench
from kinolab.dynamics.language.frames import AXES, Axis, Frame
from kinolab.dynamics.language.inputs import Control, Force, Input, Pull, Torque, bounds_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import AnyCoordinate
from kinolab.dynamics.language.shapes import ORIGIN
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
    """A force and a torque (3,) at a point, in world axes, on what moves with a frame.

    ``body`` is the one that they act on; none where a rope ends at a frame.
    """

    frame: Frame
    body: Body | None
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

    def of(self, entry: Input) -> Motor | Thruster | Mistake | None:
        """Return an input as what a tree has; None where a frame of it is among the mistakes."""
        where = f"input {entry.name!r}"
        if not isinstance(entry, Torque | Force | Pull | Control):
            what = f"it is a {type(entry).__name__}, which prescribes a motion."
            return Mistake(
                where, what, "Only what pushes is written: Torque, Force, Pull, Control."
            )
        if any(self._chains.of(frame, where) is None for frame in self._frames(entry)):
            return None
        wrenches = [(effort, self._wrench_per_unit(effort, entry)) for effort in self._with(entry)]
        known = [(effort, wrench) for effort, wrench in wrenches if wrench is not None]
        if len(known) < len(wrenches):
            what = "its force is not constant times the input."
            return Mistake(where, what, "Let the wrench be linear in it, with constant factors.")
        pushes = [[*self._pushes(entry, known, at)] for at in self._positions]
        found = self._motor(entry, pushes) or self._thruster(entry, pushes)
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

    def _thruster(self, entry: Input, pushes: Sequence[Sequence[_Push]]) -> Thruster | None:
        """Return what pushes one body alone, alike in the body's axes."""
        bodies = {push.body for each in pushes for push in each}
        (body,) = bodies if len(bodies) == 1 else (None,)
        if body is None:
            return None
        place, found = self._place_of(entry), []
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

    def _place_of(self, entry: Input) -> Array:
        """Return the point (3,) of its body at which an input acts; the origin, if at several."""
        places = [effort.at for effort in self._with(entry)]
        places += [ORIGIN] if isinstance(entry, Torque | Force) else []
        at = {tuple(self._system.number(part) for part in place) for place in places}
        return np.array(at.pop() if len(at) == 1 else ORIGIN, dtype=float)

    def _frames(self, entry: Input) -> Iterator[Frame]:
        """Yield the frames that an input needs."""
        match entry:
            case Torque():
                yield entry.about.frame
            case Force():
                yield entry.along.frame
            case Pull():
                yield from entry.between
        acting = (entry,) if isinstance(entry, Torque | Force) else ()
        for push in (*acting, *self._with(entry)):
            yield from (body.frame for body in (push.on, push.reacts_on) if body is not None)

    def _with(self, entry: Input) -> Iterator[Wrench]:
        """Yield the wrenches that depend on an input."""
        for effort in self._system.efforts:
            if isinstance(effort, Wrench) and any(
                entry.symbol in part.free_symbols for part in wrench_parts(effort)
            ):
                yield effort

    def _wrench_per_unit(self, effort: Wrench, entry: Input) -> Array | None:
        """Return force and torque (6,) for each unit of an input; None if they are not constant."""
        parts = [self._chains.numbers(part) for part in wrench_parts(effort)]
        slopes = [sympy.simplify(sympy.diff(part, entry.symbol)) for part in parts]
        if any(slope.free_symbols for slope in slopes):
            return None
        return np.array([float(slope) for slope in slopes])

    def _pushes(
        self, entry: Input, wrenches: Sequence[tuple[Wrench, Array]], at: Position
    ) -> Iterator[_Push]:
        """Yield what an input does for each unit of it, in a position of the machine."""
        still = np.zeros(3)
        match entry:
            case Torque():
                point = self._pose(entry.on.frame, at)[:3, 3]
                yield from _both(entry, still, self._axis(entry.about, at), point)
            case Force():
                point = self._pose(entry.on.frame, at)[:3, 3]
                yield from _both(entry, self._axis(entry.along, at), still, point)
            case Pull():
                one, other = (self._pose(frame, at)[:3, 3] for frame in entry.between)
                apart = float(np.linalg.norm(other - one))
                along = (other - one) / apart if apart else still
                yield _Push(entry.between[0], None, along, still, one)
                yield _Push(entry.between[1], None, -along, still, other)
        for effort, wrench in wrenches:
            pose = self._pose(effort.on.frame, at)
            place = np.array([self._system.number(part) for part in effort.at])
            force, torque = pose[:3, :3] @ wrench[:3], pose[:3, :3] @ wrench[3:]
            yield from _both(effort, force, torque, pose[:3, :3] @ place + pose[:3, 3])

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


def wrench_parts(effort: Wrench) -> tuple[sympy.Expr, ...]:
    """Return the components of a wrench's force and torque."""
    return tuple(map(sympy.sympify, (*effort.force, *effort.torque)))


def _both(
    acts: Torque | Force | Wrench, force: Array, torque: Array, point: Array
) -> Iterator[_Push]:
    """Yield an action and its reaction."""
    yield _Push(acts.on.frame, acts.on, force, torque, point)
    if acts.reacts_on is not None:
        yield _Push(acts.reacts_on.frame, acts.reacts_on, -force, -torque, point)


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

"""Inputs as motors of joints and as thrusters of bodies.

Whether an input acts on one joint alone, in whatever way it is written, is found from the forces
that it gives in several positions of the machine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np
import sympy

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.kinematics import Kinematics
from kinolab.dynamics.derivation.projected_forces import ProjectedForces
from kinolab.dynamics.derivation.sampled_states import sampled_values
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.velocity_coordinates import unconstrained_coordinates
from kinolab.dynamics.language.forces import Load
from kinolab.dynamics.language.frames import relative_pose
from kinolab.dynamics.language.inputs import Input, bounds_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import AnyCoordinate, loads, prescribes
from kinolab.dynamics.language.quantities import FrameSpeed, frames_in
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import Coordinate
from kinolab.errors import Mistake
from kinolab.numerics.arrays import Array
from kinolab.robots.actuation.actuators import Motor, Thruster
from kinolab.robots.tree.kinematic_tree import pose_of
from kinolab.robots.writing.file_numbers import rounded
from kinolab.robots.writing.frame_chains import FrameChains

SAME = 1e-11  # relative: what differs less, differs by rounding


class InputPushes:
    """What the inputs of a machine push.

    Args:
        chains: Of its frames.
        factors: Positions of joints, relative to their coordinates.
    """

    def __init__(
        self, system: Mechanism, chains: FrameChains, factors: Mapping[AnyCoordinate, float]
    ) -> None:
        self._system, self._chains = system, chains
        self._factors = dict.fromkeys(system.coordinates, 1.0) | dict(factors)
        self._bodies = {body.frame: body for body in reversed(system.bodies)}
        self._binding = SymbolTable.of(system)
        whole = unconstrained_coordinates(self._binding)
        self._forces = ProjectedForces(Kinematics(self._binding, whole))
        self._owners = [
            c for c in system.coordinates for _ in range(1 if isinstance(c, Coordinate) else 3)
        ]

    def of(self, entry: Input) -> Motor | Thruster | Mistake | None:
        """Return an input as what a tree has; None where a frame of it is among the mistakes."""
        where = str(entry)
        if prescribes(entry):
            what = f"it is a {type(entry).__name__}, which prescribes a motion."
            return Mistake(
                where, what, "Only what pushes is written: Torque, Force, Pull, Control."
            )
        acting = [e for _, e in loads(self._system) if entry.symbol in exact(e.magnitude).atoms()]
        frames = [frame for load in acting for frame in frames_in(load.velocity)]
        if any(self._chains.of(frame, where) is None for frame in frames):
            return None
        known = [unit for load in acting if (unit := self._per_unit(load, entry)) is not None]
        if len(known) < len(acting):
            what = "its force is not constant times the input."
            return Mistake(where, what, "Let the wrench be linear in it, with constant factors.")
        found = self._motor(entry, known) or self._thruster(entry, known)
        if found is None:
            what = "it acts neither on one joint nor on one body alone by a constant force."
            remedy = "Let its torque act about a joint's axis and react on the joint's other side."
            return Mistake(where, what, remedy)
        return found

    def _per_unit(self, load: Load, entry: Input) -> Load | None:
        """Return a load for each unit of an input; None if it is not constant."""
        slope = sympy.simplify(sympy.diff(self._chains.numbers(load.magnitude), entry.symbol))
        return None if slope.free_symbols else replace(load, magnitude=slope)

    def _motor(self, entry: Input, acting: Sequence[Load]) -> Motor | None:
        """Return the motor of a joint, if loads act on one with a constant factor."""
        total = [self._binding.tape.zero] * len(self._owners)
        for load in acting:
            self._forces.push(total, load, lambda: str(entry))
        table = self._in_positions(total)
        size = np.abs(table).max()
        (moved,) = np.nonzero(np.abs(table).max(axis=0) > SAME * size)
        if len(moved) != 1:
            return None
        c, column = self._owners[moved[0]], table[:, moved[0]]
        if not isinstance(c, Coordinate) or np.ptp(column) > SAME * size:
            return None
        gear = rounded(float(np.median(column)) / self._factors[c])
        return Motor(entry.name, c.name, *bounds_of(entry), gear)

    def _thruster(self, entry: Input, acting: Sequence[Load]) -> Thruster | None:
        """Return what pushes one body alone, alike in the body's axes."""
        speeds = [load.velocity for load in acting if isinstance(load.velocity, FrameSpeed)]
        body = self._bodies.get(speeds[0].on) if speeds else None
        if body is None or len(speeds) < len(acting) or {s.on for s in speeds} != {body.frame}:
            return None
        wrenches = [self._forces.wrench(speed) for speed in speeds]
        nodes = [node for wrench in wrenches for node in (*wrench.linear, *wrench.angular)]
        units = np.array([float(load.magnitude) for load in acting])
        found = self._in_positions(nodes).reshape(-1, len(acting), 6)
        found, place = np.einsum("i,kij->kj", units, found), self._place_of(speeds)
        found[:, 3:] -= np.cross(place, found[:, :3])
        size = np.abs(found).max()
        if not size or np.ptp(found, axis=0).max() > SAME * size:
            return None
        shown = np.where(np.abs(found[0]) > SAME * size, found[0], 0.0)
        wrench = np.array([rounded(float(part)) for part in shown])
        pose = pose_of(place, np.eye(3))
        return Thruster(entry.name, body.name, pose, wrench[:3], wrench[3:], *bounds_of(entry))

    def _place_of(self, speeds: Sequence[FrameSpeed]) -> Array:
        """Return the point (3,) of a body at which loads act; the origin, if at several."""
        points = {speed.at for speed in speeds if speed.at is not None}
        at = relative_pose(points.pop(), speeds[0].on)[1] if len(points) == 1 else (0, 0, 0)
        numbers = [self._chains.numbers(exact(part)) for part in at]
        still = not any(part.free_symbols for part in numbers)
        return np.array(numbers if still else (0, 0, 0), dtype=float)

    def _in_positions(self, nodes: Sequence[Node]) -> Array:
        """Return values of nodes in some positions of the machine, shape (positions, nodes)."""
        # 6 positions of the machine, in which forces are compared
        values = islice(sampled_values(self._binding, 6 + 1), 1, None)
        return np.array([self._binding.tape.evaluate(nodes, each) for each in values])

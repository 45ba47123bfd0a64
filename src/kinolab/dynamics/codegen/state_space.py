"""The space of a machine's states, the product of its parts: lines, circles and unit spheres.

Two functions are emitted for every machine, beside f and the steps:

    int difference(const double *x, const double *y, const double *turn, double *out, long mode)
    int retract(const double *x, const double *y, const double *turn, double *out, long mode)

Both work in the coordinates that a state is made of, nx numbers. On a line the difference from x to
y is y - x, on a circle the same taken into [-pi, pi), on a sphere the chord from one unit vector to
the other, or to its opposite where that is the same and nearer. ``turn`` has the circumference of
every circle, and 0 for an angle that limits keep on a line. ``retract`` adds a difference y to x
and makes vectors unit; part of a chord so leads to a value between, on the great circle.

Source: Absil, Mahony, Sepulchre, Optimization Algorithms on Matrix Manifolds, 2008, section 4.1
(retractions; this is the projective one on spheres).
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterator, Sequence
from functools import singledispatch
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.dynamics.codegen.llvm import Register, Routine, literal
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.state_parts import Circle, Part, RealLine, UnitSphere, spheres_of

TURN = 2 * math.pi
BETWEEN = [("ptr", "x"), ("ptr", "y"), ("ptr", "turn"), ("ptr", "out"), ("i64", "mode")]


def wrapped(angle: Any) -> Any:
    """Return an angle in [-pi, pi), itself to the last bit where it lies there.

    It takes a number or an array, and numba compiles it as it is.
    """
    return angle - TURN * np.floor((angle + math.pi) / TURN)


def whole_turns(angle: Any) -> Any:
    """Return the multiple of a turn that is nearest to an angle, or to each of an array."""
    return TURN * np.round(angle / TURN)


class StateSpace:
    """Differences of states and steps along them, by the machine's compiled functions.

    A state has nx entries, four of them for each attitude, a unit quaternion x, y, z, w. Angles on
    a circle are the same after whole turns, and q and -q are the same attitude. Differences are
    written in the same nx coordinates: lengths, angles, and the chord between two unit vectors,
    which is 2 sin(a/4) long where one attitude is turned from the other by an angle a.

    Args:
        parts: That follow each other in a state.
        address: Returns that of a compiled function; what it belongs to owns the machine code, and
            lives as long as the space.

    Attributes:
        nx: Number of entries of a state.
        owners: The part of each entry, length nx.
        spheres: The parts that are unit vectors.
        rotations: Those of them that are attitudes.
        circular: Whether each entry is an angle on the circle, shape (nx,).
        turns: Whether each entry is an angle on the circle or of a unit vector, shape (nx,).
    """

    def __init__(self, parts: Sequence[Part], address: Callable[[str], int]) -> None:
        self.parts, self.spheres = tuple(parts), spheres_of(parts)
        self.owners = [part for part in parts for _ in range(part.size)]
        self.rotations = tuple(part for part in self.spheres if part.antipodal)
        self.circular = np.array([isinstance(part, Circle) for part in self.owners], dtype=bool)
        self.nx, self._address = len(self.circular), address
        self.turns = self.circular.copy()
        for part in self.spheres:
            self.turns[part.own] = True
        pointer, number = ctypes.c_void_p, ctypes.c_int64
        kind = ctypes.CFUNCTYPE(number, *(pointer,) * 5, *(number,) * 3)
        self._rows: Callable[..., int] = kind(address("rows_between"))
        self._addresses = {name: address(name) for name in ("difference", "retract")}
        self._turn: Array = np.where(self.circular, TURN, 0.0)

    def limited(self, circular: NDArray[np.bool_]) -> StateSpace:
        """Return the space in which only some angles come round: limits keep others on a line.

        Args:
            circular: Those that do, shape (nx,), circles of this space all of them.
        """
        parts = [
            RealLine(part.name, part.first)
            if isinstance(part, Circle) and not circular[part.first]
            else part
            for part in self.parts
        ]
        return StateSpace(parts, self._address)

    def difference(self, x0: ArrayLike, x1: ArrayLike) -> Array:
        """Return what leads from x0 to x1, the short way round, shape (..., nx).

        Args:
            x0: States, shape (..., nx).
            x1: States, of a shape that fits by NumPy's rules.
        """
        return self._pairs("difference", x0, x1)

    def retract(self, x: ArrayLike, difference: ArrayLike) -> Array:
        """Return the states to which differences lead, unit vectors of length 1, shape (..., nx).

        Angles are not wrapped: they go on from those of x.

        Args:
            x: States, shape (..., nx).
            difference: From them, of a shape that fits by NumPy's rules.
        """
        return self._pairs("retract", x, difference)

    def unit(self, states: ArrayLike) -> Array:
        """Return states, shape (..., nx), with unit vectors of length 1."""
        return self.retract(states, np.zeros(self.nx))

    def interpolate(self, x0: ArrayLike, x1: ArrayLike, fraction: ArrayLike) -> Array:
        """Return states on the straight way from x0 to x1, the short way round.

        Args:
            x0: Where it begins, shape (nx,).
            x1: Where it ends, shape (nx,).
            fraction: Of the way, 0 to 1: a number, or several of shape (m,).

        Returns:
            Shape (nx,) or (m, nx).
        """
        column = np.asarray(fraction, dtype=float)[..., None]
        return self.retract(x0, column * self.difference(x0, x1))

    def nearest(self, x0: ArrayLike, x1: ArrayLike) -> Array:
        """Return x1 as it is written nearest to x0: by whole turns and quaternions' signs.

        Args:
            x0: States, shape (..., nx).
            x1: States, of a shape that fits by NumPy's rules.
        """
        here, there = np.broadcast_arrays(np.asarray(x0, dtype=float), np.asarray(x1, dtype=float))
        near, circles = there.copy(), self.circular
        apart = there[..., circles] - here[..., circles]
        near[..., circles] -= apart - wrapped(apart)
        for part in self.spheres:
            near[..., part.own] = part.nearest(here[..., part.own], there[..., part.own])
        return near

    def continuous(self, states: ArrayLike) -> Array:
        """Return states in a row, shape (n, nx), each written nearest to the one before."""
        rows = np.array(states, dtype=float)
        for k in range(1, len(rows)):
            rows[k] = self.nearest(rows[k - 1], rows[k])
        return rows

    def carried(self, states: ArrayLike, begin: ArrayLike) -> Array:
        """Return a motion, states of shape (n, nx), carried on from another beginning.

        Entries keep the difference of the beginnings, unit vectors their sign: what is the same
        state, or differs where nothing depends on it, goes on to be that.
        """
        there = np.asarray(begin, dtype=float)
        carried = np.array(states, dtype=float)
        shift, near = there - carried[0], self.nearest(there, carried[0])
        for part in self.spheres:
            shift[own := part.own] = 0.0
            carried[:, own] *= np.where(np.all(near[own] == carried[0, own]), 1.0, -1.0)
        carried += shift
        carried[0] = there
        return carried

    def distance(self, x0: ArrayLike, x1: ArrayLike, weights: ArrayLike = 1.0) -> Array:
        """Return the Euclidean norm of weighted differences, shape (...).

        Args:
            x0: States, shape (..., nx).
            x1: States, of a shape that fits by NumPy's rules.
            weights: Factor on each entry of a difference, shape (nx,).
        """
        lengths: Array = np.linalg.norm(self.difference(x0, x1) * np.asarray(weights), axis=-1)
        return lengths

    def _pairs(self, name: str, a: ArrayLike, b: ArrayLike) -> Array:
        """Call a compiled function on pairs of rows of nx numbers."""
        first, second = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        if first.shape != second.shape:
            first, second = np.broadcast_arrays(first, second)
        first, second = np.ascontiguousarray(first), np.ascontiguousarray(second)
        out = np.empty_like(first)
        given = [table.ctypes.data for table in (first, second, self._turn, out)]
        self._rows(self._addresses[name], *given, first.size // max(self.nx, 1), self.nx, 0)
        return out


def emit_space(parts: Sequence[Part]) -> Iterator[str]:
    """Yield the functions of a state space: the product of those of its parts."""
    for name, emit in (("difference", _emit_difference), ("retract", _emit_retract)):
        routine = Routine(name, BETWEEN)
        for part in parts:
            emit(part, routine)
        routine.give("0")
        yield routine.text()


@singledispatch
def _emit_difference(part: Part, routine: Routine) -> None:
    """Write y - x of the entries of a part, on a circle or a sphere the shorter way round."""
    for i in part.entries:
        routine.store("%out", i, routine.sub(routine.load("%y", i), routine.load("%x", i)))


@_emit_difference.register
def _(part: Circle, routine: Routine) -> None:
    """Write the angle, itself where its circle has no circumference."""
    entry = part.first
    angle = routine.sub(routine.load("%y", entry), routine.load("%x", entry))
    turn = routine.load("%turn", entry)
    turns = routine.div(routine.add(angle, routine.mul(turn, literal(0.5))), turn)
    whole = routine.line(f"call double @llvm.floor.f64(double {turns})")
    short = routine.sub(angle, routine.mul(whole, turn))
    circle = routine.line(f"fcmp ogt double {turn}, {literal(0.0)}")
    chosen = routine.line(f"select i1 {circle}, double {short}, double {angle}")
    routine.store("%out", entry, chosen)


@_emit_difference.register
def _(part: UnitSphere, routine: Routine) -> None:
    """Write the chord y - x, or -y - x where that is the same and shorter."""
    here, there = ([routine.load(array, i) for i in part.entries] for array in ("%x", "%y"))
    if part.antipodal:
        along = _dot(routine, here, there)
        opposite = routine.line(f"fcmp olt double {along}, {literal(0.0)}")
        for k, entry in enumerate(there):
            other = routine.line(f"fneg double {entry}")
            there[k] = routine.line(f"select i1 {opposite}, double {other}, double {entry}")
    for i, a, b in zip(part.entries, here, there, strict=True):
        routine.store("%out", i, routine.sub(b, a))


@singledispatch
def _emit_retract(part: Part, routine: Routine) -> None:
    """Write x + y of the entries of a part, on a sphere of length 1."""
    for i in part.entries:
        routine.store("%out", i, routine.add(routine.load("%x", i), routine.load("%y", i)))


@_emit_retract.register
def _(part: UnitSphere, routine: Routine) -> None:
    moved = [routine.add(routine.load("%x", i), routine.load("%y", i)) for i in part.entries]
    length = routine.line(f"call double @llvm.sqrt.f64(double {_dot(routine, moved, moved)})")
    for i, entry in zip(part.entries, moved, strict=True):
        routine.store("%out", i, routine.div(entry, length))


def _dot(routine: Routine, a: Sequence[Register], b: Sequence[Register]) -> Register:
    total = literal(0.0)
    for left, right in zip(a, b, strict=True):
        total = routine.add(total, routine.mul(left, right))
    return total

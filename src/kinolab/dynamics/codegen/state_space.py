"""The space of a machine's states: lines, circles and attitudes, told apart in this file alone.

Two functions are emitted for every machine, beside f and the steps:

    int difference(const double *x, const double *y, const double *turn, double *out, long mode)
    int retract(const double *x, const double *y, const double *turn, double *out, long mode)

Both work in the coordinates that a state is made of, nx numbers. On a line the difference from x to
y is y - x, on a circle the same taken into [-pi, pi), on SO(3) the chord from one quaternion to the
other or to its opposite, whichever is nearer. ``turn`` has the circumference of every circle, and 0
for an angle that limits keep on a line. ``retract`` adds a difference y to x and makes quaternions
unit; part of a chord so leads to an attitude between, on the great circle.

Source: Absil, Mahony, Sepulchre, Optimization Algorithms on Matrix Manifolds, 2008, section 4.1
(retractions; this is the projective one on the sphere of unit quaternions).
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.dynamics.codegen.llvm import Register, Routine, literal
from kinolab.numerics.arrays import Array

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
    written in the same nx coordinates: lengths, angles, and the chord between two quaternions,
    which is 2 sin(a/4) long where one attitude is turned from the other by an angle a.

    Args:
        circular: Whether each entry is an angle on the circle, shape (nx,).
        attitudes: Where quaternions begin in a state.
        rows: Address of the loop of a function over pairs of states.
        difference: Address of ``difference``.
        retract: Address of ``retract``.
        owner: What owns the machine code at these addresses; it lives as long as the space.

    Attributes:
        quaternions: The entries of each attitude, as slices.
        turns: Whether each entry is an angle on the circle or part of an attitude, shape (nx,).
    """

    def __init__(
        self,
        circular: NDArray[np.bool_],
        attitudes: Sequence[int],
        *,
        rows: int,
        difference: int,
        retract: int,
        owner: object,
    ) -> None:
        self.circular = circular
        self._owner = owner
        self.attitudes = tuple(attitudes)
        self.quaternions = tuple(slice(first, first + 4) for first in attitudes)
        self.turns = circular.copy()
        for own in self.quaternions:
            self.turns[own] = True
        pointer, number = ctypes.c_void_p, ctypes.c_int64
        kind = ctypes.CFUNCTYPE(number, *(pointer,) * 5, *(number,) * 3)
        self._rows: Callable[..., int] = kind(rows)
        self._addresses = {"rows": rows, "difference": difference, "retract": retract}
        self._turn: Array = np.where(circular, TURN, 0.0)

    def limited(self, circular: NDArray[np.bool_]) -> StateSpace:
        """Return the space in which only some angles come round: limits keep others on a line.

        Args:
            circular: Those that do, shape (nx,), circles of this space all of them.
        """
        return StateSpace(circular, self.attitudes, **self._addresses, owner=self._owner)

    @property
    def nx(self) -> int:
        """Number of entries of a state."""
        return len(self.circular)

    @property
    def dimension(self) -> int:
        """Of the space as a manifold: an attitude has three."""
        return self.nx - len(self.attitudes)

    def difference(self, x0: ArrayLike, x1: ArrayLike) -> Array:
        """Return what leads from x0 to x1, the short way round, shape (..., nx).

        Args:
            x0: States, shape (..., nx).
            x1: States, of a shape that fits by NumPy's rules.
        """
        return self._pairs("difference", x0, x1)

    def retract(self, x: ArrayLike, difference: ArrayLike) -> Array:
        """Return the states to which differences lead, quaternions of unit length, shape (..., nx).

        Angles are not wrapped: they go on from those of x.

        Args:
            x: States, shape (..., nx).
            difference: From them, of a shape that fits by NumPy's rules.
        """
        return self._pairs("retract", x, difference)

    def unit(self, states: ArrayLike) -> Array:
        """Return states, shape (..., nx), with quaternions of unit length."""
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
        """Return x1 as it is written nearest to x0: by whole turns and the quaternions' signs.

        Args:
            x0: States, shape (..., nx).
            x1: States, of a shape that fits by NumPy's rules.
        """
        here, there = np.broadcast_arrays(np.asarray(x0, dtype=float), np.asarray(x1, dtype=float))
        near, circles = there.copy(), self.circular
        apart = there[..., circles] - here[..., circles]
        near[..., circles] -= apart - wrapped(apart)
        for own in self.quaternions:
            along = np.sum(here[..., own] * there[..., own], axis=-1, keepdims=True)
            near[..., own] = np.where(along < 0, -there[..., own], there[..., own])
        return near

    def continuous(self, states: ArrayLike) -> Array:
        """Return states in a row, shape (n, nx), each written nearest to the one before."""
        rows = np.array(states, dtype=float)
        for k in range(1, len(rows)):
            rows[k] = self.nearest(rows[k - 1], rows[k])
        return rows

    def carried(self, states: ArrayLike, begin: ArrayLike) -> Array:
        """Return a motion, states of shape (n, nx), carried on from another beginning.

        Entries keep the difference of the beginnings, quaternions their sign: what is the same
        state, or differs where nothing depends on it, goes on to be that.
        """
        there = np.asarray(begin, dtype=float)
        carried = np.array(states, dtype=float)
        shift, near = there - carried[0], self.nearest(there, carried[0])
        for own in self.quaternions:
            shift[own] = 0.0
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


def emit_space(circular: Sequence[bool], attitudes: Sequence[int]) -> Iterator[str]:
    """Yield the functions of a state space.

    Args:
        circular: Whether each entry of a state is an angle on the circle, length nx.
        attitudes: Where quaternions begin in a state.
    """
    yield _emit_difference(circular, attitudes)
    yield _emit_retract(len(circular), attitudes)


def _emit_difference(circular: Sequence[bool], attitudes: Sequence[int]) -> str:
    routine = Routine("difference", BETWEEN)
    turned = {first + k for first in attitudes for k in range(4)}
    for i, circle in enumerate(circular):
        if i not in turned:
            apart = routine.sub(routine.load("%y", i), routine.load("%x", i))
            routine.store("%out", i, _wrapped(routine, apart, i) if circle else apart)
    for first in attitudes:
        _chord(routine, range(first, first + 4))
    routine.give("0")
    return routine.text()


def _wrapped(routine: Routine, angle: Register, entry: int) -> Register:
    """Return ``wrapped`` of an angle, itself where its circle has no circumference."""
    turn = routine.load("%turn", entry)
    turns = routine.div(routine.add(angle, routine.mul(turn, literal(0.5))), turn)
    whole = routine.line(f"call double @llvm.floor.f64(double {turns})")
    short = routine.sub(angle, routine.mul(whole, turn))
    circle = routine.line(f"fcmp ogt double {turn}, {literal(0.0)}")
    return routine.line(f"select i1 {circle}, double {short}, double {angle}")


def _chord(routine: Routine, entries: range) -> None:
    """Write q1 - q0 or -q1 - q0 of a quaternion, whichever is shorter."""
    here, there = ([routine.load(array, i) for i in entries] for array in ("%x", "%y"))
    along = literal(0.0)
    for a, b in zip(here, there, strict=True):
        along = routine.add(along, routine.mul(a, b))
    opposite = routine.line(f"fcmp olt double {along}, {literal(0.0)}")
    for i, a, b in zip(entries, here, there, strict=True):
        other = routine.line(f"fneg double {b}")
        near = routine.line(f"select i1 {opposite}, double {other}, double {b}")
        routine.store("%out", i, routine.sub(near, a))


def _emit_retract(size: int, attitudes: Sequence[int]) -> str:
    routine = Routine("retract", BETWEEN)
    turned = {first + k for first in attitudes for k in range(4)}
    for i in range(size):
        if i not in turned:
            moved = routine.add(routine.load("%x", i), routine.load("%y", i))
            routine.store("%out", i, moved)
    for first in attitudes:
        entries = range(first, first + 4)
        moved_to = [routine.add(routine.load("%x", i), routine.load("%y", i)) for i in entries]
        square = literal(0.0)
        for entry in moved_to:
            square = routine.add(square, routine.mul(entry, entry))
        length = routine.line(f"call double @llvm.sqrt.f64(double {square})")
        for i, entry in zip(entries, moved_to, strict=True):
            routine.store("%out", i, routine.div(entry, length))
    routine.give("0")
    return routine.text()

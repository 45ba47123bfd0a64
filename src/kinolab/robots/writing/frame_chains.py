"""A frame of a machine as a chain of joints with numbers for parameters.

Translations commute with each other, and rotations about one axis do; joints come first and what is
constant after them, so that frames that move alike have the same joints, however they are written.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import sympy

from kinolab.dynamics.language.frames import AXES, Frame, Motion, Rotation, Translation
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import AnyCoordinate
from kinolab.dynamics.symbols.expressions import is_zero
from kinolab.dynamics.symbols.symbols import Coordinate, Parameter
from kinolab.errors import Mistake
from kinolab.numerics.arrays import Array
from kinolab.robots.tree.constant_frames import ROUNDING, turned_about
from kinolab.robots.tree.kinematic_tree import JointKind, pose_of

CLEAN = 1e-15  # what is nearer to 0 or +-1 in a rotation matrix is meant to be that
REMEDY = "Write it as a chain of joints, such as arm @ move(l) @ rot_z(q)."


@dataclass(frozen=True, eq=False)
class Move:
    """A joint as a frame has it: its position is ``factor`` times a coordinate.

    Attributes:
        coordinate: An attitude where ``kind`` is ``"ball"``.
        kind: ``"revolute"``, ``"prismatic"`` or ``"ball"``.
        axis: Unit vector in the joint's frame, shape (3,).
        factor: Positive.
    """

    coordinate: AnyCoordinate
    kind: JointKind
    axis: Array
    factor: float = 1.0

    def is_like(self, other: Move) -> bool:
        """Whether two joints move alike."""
        return (
            (self.coordinate, self.kind) == (other.coordinate, other.kind)
            and np.allclose(self.axis, other.axis, rtol=0.0, atol=ROUNDING)
            and abs(self.factor - other.factor) <= ROUNDING * self.factor
        )


@dataclass(frozen=True, eq=False)
class ChainStep:
    """Joints that commute with each other, and a constant pose (4, 4) after them."""

    moves: tuple[Move, ...] = ()
    then: Array = field(default_factory=lambda: np.eye(4))

    def takes(self, moves: tuple[Move, ...]) -> bool:
        """Whether more joints commute with all of it."""
        if any(move.kind == "ball" for move in (*self.moves, *moves)):
            return False
        every = (*self.moves, *moves)
        if every[0].kind == "prismatic":
            still = np.array_equal(self.then[:3, :3], np.eye(3))
            return still and all(move.kind == "prismatic" for move in every)
        axis = moves[0].axis
        return (
            all(
                move.kind == "revolute" and np.array_equal(np.abs(move.axis), np.abs(axis))
                for move in every
            )
            and np.allclose(self.then @ [*axis, 0.0], [*axis, 0.0], rtol=0.0, atol=CLEAN)
            and not (self.then[:3, 3].any())
        )


class FrameChains:
    """The chains of a machine's frames, and what is wrong with those that have none."""

    def __init__(self, system: Mechanism) -> None:
        self.mistakes: list[Mistake] = []
        self._values = system.parameter_values
        self._found: dict[Frame, tuple[ChainStep, ...] | None] = {}

    def of(self, frame: Frame, where: str) -> tuple[ChainStep, ...] | None:
        """Return the chain of a frame; None where it has none, which is noted once."""
        if frame not in self._found:
            self._found[frame] = self._chain(frame, where)
        return self._found[frame]

    def _chain(self, frame: Frame, where: str) -> tuple[ChainStep, ...] | None:
        steps, sound = [ChainStep()], True
        for motion in frame.motions:
            step = self._step(motion, where)
            if step is None:
                sound = False
            elif not step.moves:
                steps[-1] = replace(steps[-1], then=steps[-1].then @ step.then)
            elif steps[-1].takes(step.moves):
                moves = _together((*steps[-1].moves, *step.moves))
                steps[-1] = ChainStep(moves, steps[-1].then @ step.then)
            else:
                steps.append(step)
        return tuple(steps) if sound else None

    def _step(self, motion: Motion, where: str) -> ChainStep | None:
        """Return a motion as joints and what is constant; None where it is neither."""
        if isinstance(motion, Translation):
            return self._slides(motion, where)
        if isinstance(motion, Rotation):
            axis = np.eye(3)[AXES[motion.axis]]
            found = self._linear(motion.angle, where, "turns")
            if found is None:
                return None
            angle, factors = found
            moves = [_move(c, "revolute", factor * axis) for c, factor in factors.items()]
            return ChainStep(tuple(moves), pose_of(np.zeros(3), cleaned(turned_about(axis, angle))))
        return ChainStep((Move(motion.attitude, "ball", np.zeros(3)),))

    def _slides(self, motion: Translation, where: str) -> ChainStep | None:
        parts = [self._linear(part, where, "moves") for part in motion.by]
        found = [part for part in parts if part is not None]
        if len(found) < 3:
            return None
        ways: dict[Coordinate, Array] = {}
        for k, (_, factors) in enumerate(found):
            for coordinate, factor in factors.items():
                ways.setdefault(coordinate, np.zeros(3))[k] += factor
        moves = tuple(_move(c, "prismatic", way) for c, way in ways.items())
        return ChainStep(moves, pose_of(np.array([place for place, _ in found]), np.eye(3)))

    def _linear(
        self, expression: sympy.Expr, where: str, verb: str
    ) -> tuple[float, dict[Coordinate, float]] | None:
        """Return an expression's constant and its factors of coordinates, if it is linear."""
        value = self.numbers(expression)
        free = sorted(value.free_symbols, key=str)
        factors = {symbol: sympy.simplify(sympy.diff(value, symbol)) for symbol in free}
        if not all(isinstance(c, Coordinate) and not f.free_symbols for c, f in factors.items()):
            what = f"its frame {verb} by {expression}, which is not linear in the coordinates."
            mistake = Mistake(where, what, REMEDY)
            if mistake not in self.mistakes:
                self.mistakes.append(mistake)
            return None
        at_zero = value.subs(dict.fromkeys(free, 0))
        return float(at_zero), {c: float(f) for c, f in factors.items() if not is_zero(f)}

    def numbers(self, expression: sympy.Expr) -> sympy.Expr:
        """Return an expression with the values of parameters."""
        known = expression.atoms(Parameter)
        return expression.subs({entry: self._values[entry.name] for entry in known})


def cleaned(turn: Array) -> Array:
    """Return a rotation matrix (3, 3) with exact entries where 0 and +-1 are meant."""
    near = np.round(turn)
    return np.where(np.abs(turn - near) < CLEAN, near, turn)


def _move(coordinate: Coordinate, kind: JointKind, way: Array) -> Move:
    """Return the joint that moves by a coordinate times a vector (3,)."""
    size = float(np.linalg.norm(way))
    axis = way / size + 0.0  # no -0.0
    return Move(coordinate, kind, axis, 1.0 if abs(size - 1.0) < CLEAN else size)


def _together(moves: tuple[Move, ...]) -> tuple[Move, ...]:
    """Return joints that commute, one for each coordinate."""
    ways: dict[Coordinate, Array] = {}
    for move in moves:
        assert isinstance(move.coordinate, Coordinate)
        way = ways.setdefault(move.coordinate, np.zeros(3))
        ways[move.coordinate] = way + move.factor * move.axis
    moving = ((c, way) for c, way in ways.items() if np.abs(way).max() > ROUNDING)
    return tuple(_move(c, moves[0].kind, way) for c, way in moving)

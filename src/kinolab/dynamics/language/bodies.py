"""What is seen and touched: rigid bodies, and the cables between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.frames import Frame, Number
from kinolab.dynamics.language.shapes import DrawnMesh, Scalar, Shape
from kinolab.dynamics.symbols.expressions import exact, is_zero
from kinolab.errors import InputError, Mistake


@checked
@dataclass(frozen=True, init=False)
class Body:
    """A rigid body whose centre of mass is the origin of its frame.

    Args:
        name: Its name in contacts, goals and renderings.
        frame: Pose of the centre of mass.
        mass: In [kg].
        inertia: About the centre of mass along the frame's axes, in [kg m^2]: the principal
            moments (xx, yy, zz), or (xx, yy, zz, xy, xz, yz) with the entries of the matrix. A
            single number, such as 0.01, stands for three equal moments, as of a ball, a cube or a
            body that turns about one axis only; 0 for a point mass.
        added_mass: Added mass of an ideal fluid: six numbers for (x, y, z) in [kg] and about
            (x, y, z) in [kg m^2], or the symmetric 6x6 matrix in that order, in the body's axes.
        shape: One or several solids in the body's frame; none for a pure mass.
        touches_ground: Whether it may contact the ground (wheels, feet), without penetration.
        color: Red, green and blue in [0, 1]; chosen from a palette when left out.
        whirl: Spin about its z axis in animations only, in [rad/s] of film: for rotors whose spin
            is not modelled. Collision checks use the shape as given.
        drawn: What is drawn instead of its shapes, which alone can touch something; ``()`` for
            nothing.
        located: Whether it is anywhere. False for an inertia alone, such as that of a rotor which
            only its joint feels: its frame says how it moves, and no workspace limits it.
        prescribed: Whether time alone moves it, as an obstacle: of its machine it meets those that
            ``System(collisions=…)`` pairs it with, of the world nothing.
    """

    name: str
    frame: Frame
    mass: sympy.Expr
    inertia: tuple[sympy.Expr, ...]  # xx, yy, zz, xy, xz, yz
    added_mass: tuple[tuple[sympy.Expr, ...], ...]  # 6 rows of 6, or none
    shapes: tuple[Shape, ...]
    touches_ground: bool
    color: tuple[float, float, float] | None
    whirl: float
    drawn: tuple[DrawnMesh, ...] | None
    located: bool
    prescribed: bool

    def __init__(
        self,
        name: str,
        frame: Frame,
        *,
        mass: Number = 0,
        inertia: Number | tuple[Number, ...] = 0,
        added_mass: Sequence[Number] | Sequence[Sequence[Number]] = (),
        shape: Shape | Sequence[Shape] | None = None,
        touches_ground: bool = False,
        color: tuple[float, float, float] | None = None,
        whirl: float = 0.0,
        drawn: Sequence[DrawnMesh] | None = None,
        located: bool = True,
        prescribed: bool = False,
    ) -> None:
        given = () if shape is None else shape
        vars(self).update(
            name=name,
            frame=frame,
            mass=exact(mass),
            inertia=_six(name, inertia),
            added_mass=_six_by_six(name, added_mass),
            shapes=tuple(given) if isinstance(given, Sequence) else (given,),
            touches_ground=touches_ground,
            color=color,
            whirl=float(whirl),
            drawn=None if drawn is None else tuple(drawn),
            located=located,
            prescribed=prescribed,
        )

    @property
    def massless(self) -> bool:
        """Whether it has neither mass nor inertia, those of a fluid included."""
        fluid = (entry for row in self.added_mass for entry in row)
        return all(is_zero(value) for value in (self.mass, *self.inertia, *fluid))

    @property
    def inertia_matrix(self) -> sympy.Matrix:
        """The inertia tensor about the centre of mass, 3x3, in [kg m^2]."""
        xx, yy, zz, xy, xz, yz = self.inertia
        return sympy.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _six(name: str, inertia: Number | tuple[Number, ...]) -> tuple[sympy.Expr, ...]:
    given = inertia if isinstance(inertia, tuple) else (inertia,) * 3
    if len(given) not in (3, 6):
        what = f"its inertia has {len(given)} entries."
        remedy = "Give (xx, yy, zz) or (xx, yy, zz, xy, xz, yz)."
        raise InputError([Mistake(f"body {name!r}", what, remedy)])
    return tuple(exact(entry) for entry in (*given, 0, 0, 0)[:6])


def _six_by_six(name: str, added: Sequence[Any]) -> tuple[tuple[sympy.Expr, ...], ...]:
    rows = [list(row) if isinstance(row, Sequence) else row for row in added]
    if rows and not isinstance(rows[0], list):
        rows = [[entry if i == j else 0 for j in range(len(rows))] for i, entry in enumerate(rows)]
    matrix = tuple(tuple(exact(entry) for entry in row) for row in rows)
    square = len(matrix) in (0, 6) and all(len(row) == 6 for row in matrix)
    if not square or any(
        matrix[i][j] != matrix[j][i] for i in range(len(matrix)) for j in range(i)
    ):
        remedy = "Give six numbers, or a symmetric matrix of 6 rows of 6."
        raise InputError([Mistake(f"body {name!r}", "its added mass is not 6x6.", remedy)])
    return matrix


@checked
@dataclass(frozen=True)
class Cable:
    """A taut rope, string or chain: a capsule between the origins of two frames.

    It has neither mass nor force of its own; coordinates, constraints and inputs define its effect.
    It collides with obstacles, not with the ground, and with bodies and cables of its machine only
    where ``System(collisions=…)`` pairs them.

    Attributes:
        between: The frames of its ends, at any distance.
        name: Its name in contacts; numbered by the system when left out.
        radius: In [m], a number or an expression in parameters.
        collides: Whether it takes part in collision checks; otherwise it is only drawn.
    """

    between: tuple[Frame, Frame] | list[Frame]
    name: str = ""
    radius: Scalar = 0.01
    collides: bool = True

    def __post_init__(self) -> None:
        """Validate that there are two ends; a list of two is accepted."""
        if len(self.between) != 2:
            what = f"it has {len(self.between)} ends."
            remedy = "Give a pair, such as (trolley.frame, load.frame)."
            raise InputError([Mistake(f"Cable {self.name!r} between", what, remedy)])
        object.__setattr__(self, "between", tuple(self.between))


AnyCable: TypeAlias = Cable | tuple[Frame, Frame] | list[Frame]


def as_cables(entries: Sequence[AnyCable]) -> tuple[Cable, ...]:
    """Convert pairs of frames to cables, and number unnamed ones."""
    cables = [entry if isinstance(entry, Cable) else Cable(entry) for entry in entries]
    names = [f"cable {k + 1}" if len(cables) > 1 else "cable" for k in range(len(cables))]
    return tuple(c if c.name else replace(c, name=n) for c, n in zip(cables, names, strict=True))

"""The mass, inertia and centre of mass of links that are fixed to each other, as parameters."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.frames import Frame, move
from kinolab.dynamics.language.offer import Offer
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import Parameter

AXES = "xyz"
BEGINNINGS = ("m", "I", "cx", "cy", "cz")  # of parameters' names


@checked
@dataclass(frozen=True)
class Lump:
    """The mass properties of a link that is fixed to others, in its own axes.

    Attributes:
        name: What its parameters are called after.
        at: Its origin in the frame in which all of them are, in [m].
        turn: Its axes there: the rows of a rotation matrix.
        mass: In [kg].
        centre: Centre of mass, in [m].
        inertia: About that: xx, yy, zz, xy, xz, yz, in [kg m^2].
    """

    name: str
    at: tuple[float, ...]
    turn: tuple[float, ...]
    mass: float
    centre: tuple[float, ...]
    inertia: tuple[float, ...]

    def parameters(self) -> tuple[tuple[Parameter, str], ...]:
        """Return its mass, the factor of its inertia where it has any, and its centre."""
        name = self.name
        centre = (
            (Parameter(f"c{axis}_{name}", value, "m"), f"centre of mass of {name} along its {axis}")
            for axis, value in zip(AXES, self.centre, strict=True)
        )
        scale = (Parameter(f"I_{name}", 1.0), f"factor of the inertia of {name}")
        mass = (Parameter(f"m_{name}", self.mass, "kg"), f"mass of {name}")
        return (mass, *((scale,) if any(self.inertia) else ()), *centre)

    def properties(self, asked: Collection[str]) -> tuple[sympy.Expr, sympy.Matrix, sympy.Matrix]:
        """Return mass, centre (3, 1) and inertia about it (3, 3), in the frame of all."""
        own = {p.name: p if p.name in asked else exact(p.default) for p, _ in self.parameters()}
        turn = sympy.Matrix(3, 3, [*map(exact, self.turn)])
        centre = sympy.Matrix([own[f"c{axis}_{self.name}"] for axis in AXES])
        xx, yy, zz, xy, xz, yz = map(exact, self.inertia)
        inertia = sympy.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        scale = own.get(f"I_{self.name}", sympy.Integer(1))
        place = sympy.Matrix([*map(exact, self.at)]) + turn * centre
        return own[f"m_{self.name}"], place, scale * (turn * inertia * turn.T)


@checked
@dataclass(frozen=True)
class LumpedMass(Offer):
    """The mass properties of a body that consists of several.

    Attributes:
        body: Its name.
        frame: In which they are.
        lumps: Those that it consists of.
    """

    body: str
    frame: Frame
    lumps: tuple[Lump, ...]

    def parameters(self) -> tuple[tuple[Parameter, str], ...]:
        """Return those of each."""
        return tuple(told for lump in self.lumps for told in lump.parameters())

    def fits(
        self,
        bodies: Sequence[Body],
        efforts: Sequence[Effort],  # noqa: ARG002 - it is of bodies
        own: Collection[str],  # noqa: ARG002
    ) -> bool:
        """Whether there is such a body."""
        return any(body.name == self.body for body in bodies)

    def taken(
        self, words: Mapping[str, tuple[Any, ...]], before: Collection[str], asked: Collection[str]
    ) -> Mapping[str, tuple[Any, ...]]:
        """Return the words with another body of the same name."""
        made = self._together([*before, *asked])
        return {
            name: tuple(_with_body(word, made) for word in given) for name, given in words.items()
        }

    def _together(self, asked: Collection[str]) -> Body:
        """Return the mass of all, with moments of inertia by parallel axes."""
        parts = [lump.properties(asked) for lump in self.lumps]
        mass = sympy.Add(*(m for m, _, _ in parts))
        (_, centre, inertia), *others = parts
        if others:
            centre = sum((m * c for m, c, _ in parts), sympy.zeros(3, 1)) / mass
            inertia = sum((i + m * _moment(c - centre) for m, c, i in parts), sympy.zeros(3))
        six = tuple(inertia[k] for k in (0, 4, 8, 1, 2, 5))
        return Body(self.body, self.frame @ move(*centre), mass=mass, inertia=six)


def _moment(arm: sympy.Matrix) -> sympy.Matrix:
    """Return the moments of inertia of 1 kg at the end of an arm (3, 1), shape (3, 3)."""
    return arm.dot(arm) * sympy.eye(3) - arm * arm.T


def _with_body(word: Any, made: Body) -> Any:
    """Return a body or what acts on bodies, with another body in place of that of its name."""
    if isinstance(word, Body):
        return made if word.name == made.name else word
    held = {f.name: getattr(word, f.name) for f in fields(word) if f.name != "_"}
    acting = {key: made for key, v in held.items() if isinstance(v, Body) and v.name == made.name}
    return replace(word, **acting) if acting else word

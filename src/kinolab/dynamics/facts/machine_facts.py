"""What planning asks of a machine besides its equations of motion: plain facts, without SymPy.

They are kept with the compiled machine, so that one from the cache needs no symbols.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.dynamics.language.shapes import DrawnMesh, Shape
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.state_parts import Part

if TYPE_CHECKING:
    from kinolab.dynamics.language.flatness import Flat
    from kinolab.dynamics.language.mechanism_parts import MechanismParts

Limits = tuple[float, float]


@dataclass(frozen=True)
class CoordinateFacts:
    """A coordinate or an attitude; limits, scale and speed in ``unit``, the latter per second.

    Attributes:
        entries: Names of its entries in a configuration: one, or four for an attitude.
        rates: Names of its velocities: one, or three for an attitude.
    """

    name: str
    unit: str
    limits: Limits
    speed: float
    scale: float
    entries: tuple[str, ...]
    rates: tuple[str, ...]


@dataclass(frozen=True)
class StateFacts:
    """An auxiliary state; ``is_speed`` says whether it is a velocity of the machine."""

    name: str
    unit: str
    limits: Limits
    scale: float
    is_speed: bool


@dataclass(frozen=True)
class QuasiVelocityFacts:
    """A quasi-velocity that is a state; ``direction`` says in words what it is."""

    name: str
    unit: str
    speed: float
    scale: float
    direction: str


@dataclass(frozen=True)
class InputFacts:
    """An input, or a reference of feedback."""

    name: str
    unit: str
    limits: Limits


TIME = "time"  # what the clock is called of a machine among obstacles that move
JOINT = "+"  # between the names of machines in that of all


def members(system_name: str) -> tuple[str, ...]:
    """Return the names of the machines that one consists of, by its own; none if it is one."""
    names = tuple(system_name.split(JOINT))
    return names if len(names) > 1 else ()


def member_of(name: str, machines: Sequence[str]) -> str:
    """Return the machine, of several, that something belongs to by its name; none: empty."""
    own = (machine for machine in machines if name.startswith(f"{machine}_"))
    return max(own, key=len, default="")


@dataclass(frozen=True)
class BodyGeometry:
    """What the world sees of one body; shapes have numeric dimensions.

    A body that ``touches_ground`` rests on it (a wheel, a foot) and may only not sink into it. One
    that whirls is drawn turning about its z axis, at so many [rad/s] of film. The bounds of a world
    hold for those that move. One that is prescribed is an obstacle that moves as time says: it
    meets only those that it is paired with.
    """

    name: str
    shapes: tuple[Shape, ...]
    touches_ground: bool = False
    color: tuple[float, float, float] | None = None  # red, green, blue in [0, 1]
    whirl: float = 0.0
    drawn: tuple[DrawnMesh, ...] | None = None  # instead of the shapes
    moves: bool = True
    prescribed: bool = False


@dataclass(frozen=True)
class CableGeometry:
    """What the world sees of one cable; its ends come with every pose.

    One that does not collide keeps its row among the ends.
    """

    name: str
    radius: float  # [m]
    collides: bool = True


@dataclass(frozen=True)
class ConstraintFacts:
    """A constraint; ``of_position`` says whether it closes a loop."""

    name: str
    of_position: bool


@dataclass(frozen=True)
class RequirementFacts:
    """A requirement; ``needs_inputs`` says whether inputs or forces decide on it."""

    name: str
    needs_inputs: bool


@dataclass(frozen=True)
class TransitionFacts:
    """A transition, and the indices of the modes that it joins."""

    name: str
    source: int
    target: int


@dataclass(frozen=True)
class FlatFacts:
    """A flat map, ``PlaneCurves`` or another.

    Attributes:
        plane_curves: Whether the flat outputs are a point of a plane curve.
        coordinates: Names of the coordinates that it determines.
        outputs: Names of the flat outputs; none of plane curves, whose ``steered`` coordinates
            are functions of ``curvature``.
        defined: The outputs as functions of coordinates.
        determined: The coordinates, or those that are steered, as functions of the outputs and
            their derivatives, named with primes.
    """

    plane_curves: bool
    coordinates: tuple[str, ...]
    outputs: tuple[str, ...]
    defined: Formulas
    determined: Formulas

    @property
    def steered(self) -> tuple[str, ...]:
        """The coordinates that the curvature of a plane curve determines."""
        return self.coordinates[3:] if self.plane_curves else ()


@dataclass(frozen=True)
class JointFrames:
    """The joints' frames as functions of the configuration.

    Attributes:
        names: Of the coordinates that move them, such as ``psi`` or ``x, y``.
        poses: Rows of [R | p], 12 functions per frame, with the values of parameters.
    """

    names: tuple[str, ...]
    poses: Formulas

    def at(self, x: Array, names: Sequence[str]) -> Array:
        """Return the poses at states (n, nx) whose entries have names, shape (n, joints, 12)."""
        values = self.poses(dict(zip(names, x.T, strict=False)))
        columns = [np.broadcast_to(value, len(x)) for value in values]
        return np.reshape(columns, (len(self.names), 12, len(x))).transpose(2, 0, 1)


@dataclass(frozen=True)
class OfferedFacts:
    """A number in ``unit`` that becomes a parameter once one asks for it; ``what`` says of what."""

    name: str
    value: float
    unit: str
    what: str


@dataclass(frozen=True)
class MachineFacts:
    """A machine without its mechanics, in the order of ``Mechanism``'s own fields.

    Attributes:
        parts: Of a configuration: lines, circles and unit spheres.
        all_rates: Whether every rate is a state.
        references: Those of its feedback; None where it has none.
        parameters: Values in SI units, by name.
        flat: What its flat outputs determine; None where none are known.
        down: Unit vector of gravity in the world; None where there is none.
        modes: Names of its modes, if its mechanics switch.
        transitions: Between its modes, in the order in which they are tried.
        joints: The frames of its joints, for pictures.
        offered: What is, or may become, a parameter of a robot from a file.
    """

    name: str
    coordinates: tuple[CoordinateFacts, ...]
    parts: tuple[Part, ...]
    states: tuple[StateFacts, ...]
    inputs: tuple[InputFacts, ...]
    references: tuple[InputFacts, ...] | None
    parameters: tuple[tuple[str, float], ...]
    bodies: tuple[BodyGeometry, ...]
    cables: tuple[CableGeometry, ...]
    constraints: tuple[ConstraintFacts, ...]
    requirements: tuple[RequirementFacts, ...]
    collisions: tuple[tuple[str, str], ...]
    unwatched: tuple[tuple[str, str], ...]
    notes: tuple[tuple[str, str], ...]
    all_rates: bool
    flat: FlatFacts | None
    down: tuple[float, float, float] | None
    modes: tuple[str, ...]
    transitions: tuple[TransitionFacts, ...]
    joints: JointFrames
    offered: tuple[OfferedFacts, ...]

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of what can be given a value: of its parameters, and of what it offers."""
        own = (name for name, _ in self.parameters)
        return tuple(dict.fromkeys((*own, *(entry.name for entry in self.offered))))

    def transitions_from(self, x: Array) -> list[TransitionFacts]:
        """Return the transitions that may end the mode of a state, shape (nx,)."""
        return [t for t in self.transitions if t.source == int(x[-1])] if self.modes else []

    @property
    def rate_names(self) -> tuple[str, ...]:
        """Names of all velocities, the dependent ones included."""
        return tuple(name for c in self.coordinates for name in c.rates)

    @property
    def chosen(self) -> tuple[InputFacts, ...]:
        """What planners choose: inputs, or the references of feedback."""
        return self.inputs if self.references is None else self.references

    @property
    def closes_loops(self) -> bool:
        """Whether a constraint is on positions."""
        return any(constraint.of_position for constraint in self.constraints)


def facts_of(system: MechanismParts) -> MachineFacts:
    """Return the facts of a machine that is described by symbols.

    Raises:
        InputError: If the limits of an input are not finite, or lower is not below upper.
    """
    from kinolab.dynamics.language.constraints import PositionConstraint
    from kinolab.dynamics.language.inputs import bounds_of
    from kinolab.dynamics.language.mechanism_parts import state_parts
    from kinolab.dynamics.language.offer import offered
    from kinolab.dynamics.symbols.symbols import ForceSymbol, InputSymbol

    references = None if system.feedback is None else system.feedback.references
    return MachineFacts(
        name=system.name,
        coordinates=tuple(
            CoordinateFacts(
                *(c.name, c.unit, (c.lower, c.upper), c.speed, c.scale),
                entries=tuple(entry.name for entry in c.entries),
                rates=tuple(entry.name for entry in c.rates),
            )
            for c in system.coordinates
        ),
        parts=state_parts(system),
        states=tuple(
            StateFacts(s.name, s.unit, s.limits, s.scale, s.velocity is not None)
            for s in system.states
        ),
        inputs=tuple(InputFacts(u.name, u.unit, bounds_of(u)) for u in system.inputs),
        references=None
        if references is None
        else tuple(InputFacts(r.name, r.unit, bounds_of(r)) for r in references),
        parameters=tuple((p.name, system.parameter_values[p.name]) for p in system.parameters),
        bodies=tuple(
            BodyGeometry(
                *(b.name, system.resolved_shapes(b), b.touches_ground, b.color, b.whirl, b.drawn),
                moves=b.located and b.frame.moves and not b.prescribed,
                prescribed=b.prescribed,
            )
            for b in system.bodies
        ),
        cables=tuple(
            CableGeometry(c.name, system.number(c.radius), c.collides) for c in system.cables
        ),
        constraints=tuple(
            ConstraintFacts(c.name, isinstance(c, PositionConstraint))
            for c in system.all_constraints
        ),
        requirements=tuple(
            RequirementFacts(r.name, bool(r.margin.atoms(InputSymbol, ForceSymbol)))
            for r in system.all_requirements
        ),
        collisions=system.collisions,
        unwatched=system.unwatched,
        notes=system.notes,
        all_rates=system.velocities == "all" or bool(system.modes),
        flat=None if system.flat is None else _flat(system, system.flat),
        down=system.down,
        modes=tuple(names := [mode.name for mode in system.modes]),
        transitions=tuple(
            TransitionFacts(t.name, names.index(t.source), names.index(t.target))
            for t in system.transitions
        ),
        joints=_joints(system),
        offered=tuple(
            OfferedFacts(p.name, p.default, p.unit, what)
            for p, what in offered(system.offers).values()
        ),
    )


def _joints(system: MechanismParts) -> JointFrames:
    from kinolab.dynamics.derivation.lowering import Lowering
    from kinolab.dynamics.facts.joint_frames import joint_frames, pose_nodes
    from kinolab.dynamics.language.mechanism_parts import configuration_symbols

    graph, frames = ExpressionGraph(), joint_frames(system)
    numbers = {p: graph.constant(system.parameter_values[p.name]) for p in system.parameters}
    entries = {s: graph.variable(s.name) for s in configuration_symbols(system)}
    poses = pose_nodes(Lowering(graph, {**numbers, **entries}), tuple(frames))
    return JointFrames(tuple(frames.values()), Formulas.of(graph, poses))


def _flat(system: MechanismParts, flat: Flat) -> FlatFacts:
    from kinolab.dynamics.derivation.lowering import Lowering
    from kinolab.dynamics.language.flatness import FlatOutputs, output_symbols

    outputs = flat.outputs if isinstance(flat, FlatOutputs) else ()
    pairs = flat.determined if isinstance(flat, FlatOutputs) else flat.steered
    graph = ExpressionGraph()
    values = {p: graph.constant(system.parameter_values[p.name]) for p in system.parameters}
    places = {c: graph.variable(c.name) for c in flat.coordinates}
    defined = [Lowering(graph, {**values, **places})(e) for _, e in outputs]
    names = output_symbols(name for name, _ in outputs)
    bound = {**values, **{symbol: graph.variable(symbol.name) for symbol in names}}
    determined = []
    for coordinate, expression in pairs:
        bound[coordinate] = Lowering(graph, bound)(expression)
        determined.append(bound[coordinate])
    return FlatFacts(
        not isinstance(flat, FlatOutputs),
        tuple(c.name for c in flat.coordinates),
        tuple(name for name, _ in outputs),
        Formulas.of(graph, defined),
        Formulas.of(graph, determined),
    )

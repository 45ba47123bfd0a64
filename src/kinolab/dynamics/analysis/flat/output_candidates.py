"""Candidates for flat outputs: coordinates, and places of points of a machine.

Of many machines the flat outputs are coordinates, the place of a joint, of an axle, of a centre of
mass, or of a point on an axis through that.

Sources: Murray, Rathinam, Sluis, Differential flatness of mechanical control systems: a catalog of
prototype systems, ASME 1995; Levine, Analysis and Control of Nonlinear Systems, 2009, chapter 6.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice

import sympy

from kinolab.dynamics.analysis.flat.control_system import ControlSystem
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.facts.joint_frames import pose_nodes
from kinolab.dynamics.language.frames import Frame, move, movers_of, pose
from kinolab.dynamics.symbols.symbols import Coordinate

AXES = ("x", "y", "z")
CENTRE = "the centre of mass of "


@dataclass(frozen=True)
class Candidate:
    """A function of the configuration that may be a flat output.

    Attributes:
        node: It in the expression graph.
        said: What it is, in words.
        symbol: The coordinate, or the entry of an attitude; None of a place.
        frame: The frame whose origin it is an entry of, if it is one.
        entry: Which one, 0 to 2; 3 for the tangent of the heading of its x axis.
    """

    node: Node
    said: str
    symbol: sympy.Symbol | None = None
    frame: Frame | None = None
    entry: int = 0

    @property
    def expression(self) -> sympy.Expr:
        """It in coordinates and parameters."""
        if self.symbol is not None or self.frame is None:
            return sympy.sympify(self.symbol)
        turn, place = pose(self.frame)
        return turn[1, 0] / turn[0, 0] if self.entry == 3 else place[self.entry]


@dataclass(frozen=True)
class Point:
    """A point of a machine.

    Attributes:
        said: Whose, in words.
        frame: Its frame, in whose axes points beside it are looked for.
        entries: Its entries in the world that change.
        central: Whether it is a body's centre of mass.
    """

    said: str
    frame: Frame
    entries: tuple[Candidate, ...]
    central: bool


class Candidates:
    """The candidates of one machine."""

    def __init__(self, control: ControlSystem) -> None:
        self._control, self._tape = control, control.tape
        fields = control.fields
        named = {s.name: s for s in (*fields.symbols, *fields.constants)}
        bound = {symbol: self._tape.variable(name) for name, symbol in named.items()}
        self._lower = Lowering(self._tape, bound)
        self.coordinates = tuple(self._coordinates())
        self._by_node = {one.node: one for one in self.coordinates}
        self.points = tuple(self._points())

    def sets(self) -> Iterator[tuple[Candidate, ...]]:
        """Yield sets of as many candidates as inputs: coordinates, then points and coordinates."""
        return islice(self._sets(), 2000)  # a test of one takes a millisecond

    def beside(self, point: Point, axis: int, offset: float) -> Point:
        """Return a point on an axis of a point's frame, in [m] from it."""
        arm = [0.0, 0.0, 0.0]
        arm[axis] = offset
        way = "along" if offset > 0 else "against"
        said = f"the point {abs(offset):.6g} m {way} the {AXES[axis]} axis from {point.said}"
        return self._point(said, point.frame @ move(*arm), central=False)

    def slopes(self, point: Point, axis: int) -> list[Node]:
        """Return how the entries of a point change along an axis of its frame."""
        rows = pose_nodes(self._lower, [point.frame])
        return [rows[4 * one.entry + axis] for one in point.entries]

    def _sets(self) -> Iterator[tuple[Candidate, ...]]:
        count, seen = len(self._control.inputs), set[frozenset[Node]]()
        yield from self._with_headings(count)
        for how_many in range(count + 1):
            for points in combinations(self.points, how_many):
                for chosen in self._completed(points, count):
                    key = frozenset(one.node for one in chosen)
                    if len(key) == count and key not in seen:
                        seen.add(key)
                        yield chosen

    def _with_headings(self, count: int) -> Iterator[tuple[Candidate, ...]]:
        """Yield a place and the heading there, as of multirotors, where there are four inputs."""
        if all(isinstance(c, Coordinate) for c in self._control.system.coordinates):
            return
        for point in self.points:
            if point.central and len(point.entries) == 3 == count - 1:
                heading = self._heading(point)
                if self._tape.depends_on(heading.node) & frozenset(self._control.state):
                    yield (*point.entries, heading)

    def _completed(self, points: Sequence[Point], count: int) -> Iterator[tuple[Candidate, ...]]:
        places = [one for point in points for one in point.entries]
        if len(places) > count:
            yield from combinations(places, count) if len(points) == 1 else ()
            return
        for others in combinations(self.coordinates, count - len(places)):
            yield (*places, *others)

    def _coordinates(self) -> Iterator[Candidate]:
        for coordinate in self._control.system.coordinates:
            own = [coordinate] if isinstance(coordinate, Coordinate) else coordinate.entries[:3]
            for symbol in own:
                yield Candidate(self._lower(symbol), symbol.name, symbol)

    def _points(self) -> Iterator[Point]:
        known = set[tuple[Node, ...]]()
        for said, frame, central in self._frames():
            point = self._point(said, frame, central=central)
            key = tuple(one.node for one in point.entries)
            if key and (central or key not in known):
                known.add(key)
                yield point

    def _frames(self) -> Iterator[tuple[str, Frame, bool]]:
        """Yield the bodies' centres of mass, then the origins along the chains to them."""
        bodies = self._control.system.bodies
        located = [body for body in bodies if body.located]
        for body in located:
            yield f"{CENTRE}{body.name}", body.frame, True
        for body in located:
            for k in range(1, len(body.frame.motions)):
                frame = Frame(body.frame.motions[:k])
                turned = [m.name for motion in body.frame.motions[k:] for m in movers_of(motion)]
                yield f"the joint of {turned[0] if turned else body.name}", frame, False

    def _point(self, said: str, frame: Frame, *, central: bool) -> Point:
        rows = pose_nodes(self._lower, [frame])
        moving = frozenset(self._control.state)
        entries = tuple(
            replace(self._by_node[node], frame=frame, entry=k)
            if node in self._by_node
            else Candidate(node, f"{AXES[k]} of {said}", None, frame, k)
            for k, node in enumerate(rows[3::4])
            if self._tape.depends_on(node) & moving
        )
        return Point(said, frame, entries, central)

    def _heading(self, point: Point) -> Candidate:
        rows = pose_nodes(self._lower, [point.frame])
        node = self._tape.div(rows[4], rows[0])
        body = point.said.removeprefix(CENTRE)
        return Candidate(node, f"the tangent of the heading of {body}", None, point.frame, 3)

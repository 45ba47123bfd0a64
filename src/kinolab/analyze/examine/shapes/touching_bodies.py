"""Which bodies touch at rest, each other or the ground, and how far apart they are elsewhere."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics import Body
from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.mechanism_parts import atoms_of, coordinate_of
from kinolab.numerics.arrays import Array
from kinolab.simulation.stability import random_states
from kinolab.world import CollisionChecker, World
from kinolab.world.shapes.geometry import frame_in_world, lowest_z, reach_of

TOUCHING = 1e-4  # of the smaller body's reach: what rounded sizes in a file leave between two
SUNK = 0.1  # of the reach: how far a body on the ground may stand in it and is on it
APART = 5e-3  # of the same: a gap that can be seen


@dataclass(frozen=True)
class TouchingBodies:
    """Two bodies that touch at rest, or a body on the ground.

    Attributes:
        subject: The machine.
        one: A body.
        other: The one that it touches; None for the ground.
        reach: Of the smaller one about its origin, in [m].
    """

    subject: Subject
    one: Body
    other: Body | None
    reach: float

    @property
    def names(self) -> str:
        """Both, as a title names them."""
        return f"{self.one.name} and {'the ground' if self.other is None else self.other.name}"

    @property
    def moved_by(self) -> frozenset[str]:
        """Names of the coordinates that move either of them."""
        others = frozenset() if self.other is None else self.subject.moving(self.other.frame)
        return self.subject.moving(self.one.frame) | others

    @property
    def moved_together(self) -> frozenset[str]:
        """Names of the coordinates that move both."""
        if self.other is None:
            return frozenset()
        return self.subject.moving(self.one.frame) & self.subject.moving(self.other.frame)

    @property
    def held(self) -> bool:
        """Whether a position constraint joins coordinates of both."""
        stated = (c for c in self.subject.system.constraints if isinstance(c, PositionConstraint))
        owners = [{o.name for a in atoms_of(c.position) if (o := coordinate_of(a))} for c in stated]
        moving = [self.subject.moving(body.frame) for body in self.pair]
        return any(all(own & one for one in moving) for own in owners)

    def gap(self, x: Array, values: Mapping[str, float] | None = None) -> float:
        """Return how far apart they are in [m] at a state.

        Args:
            x: State, shape (nx,).
            values: Other values of parameters, by name.

        Returns:
            Negative where a body is in the ground; bodies that overlap are 0 apart.
        """
        frames = self.subject.model.frames(x, **(values or {})).reshape(-1, 3, 4)
        solid, checker = self._made_for(values) if values else self._made
        own = np.array([frames[self.subject.place_of(body)] for body in self.pair])
        if self.other is None:
            return min(lowest_z(shape, own[0]) for shape in solid[0].shapes)
        return 2.0 * checker.clearance(own)

    @cached_property
    def pair(self) -> tuple[Body, ...]:
        """The bodies, one or two."""
        return (self.one,) if self.other is None else (self.one, self.other)

    @cached_property
    def _made(self) -> tuple[list[BodyGeometry], CollisionChecker]:
        return self._made_for({})

    def _made_for(self, values: Mapping[str, float]) -> tuple[list[BodyGeometry], CollisionChecker]:
        system = self.subject.system.with_parameters(**values) if values else self.subject.system
        solid = [BodyGeometry(body.name, system.resolved_shapes(body)) for body in self.pair]
        names = [(solid[0].name, solid[-1].name)] if self.other is not None else []
        return solid, CollisionChecker(solid, World(), self_pairs=names)

    @property
    def entangled(self) -> bool:
        """Whether the middle of a shape of one body is in the other one at rest."""
        if self.other is None:
            return False
        poses = self.subject.poses(self.subject.rest)
        placed = [
            [(shape, *frame_in_world(shape, poses[self.subject.place_of(body)]))
             for shape in self.subject.system.resolved_shapes(body)]
            for body in self.pair
        ]  # fmt: skip
        return any(
            float(shape.depths(axes.T @ (middle - centre))) > 0.0
            for own, others in (placed, placed[::-1])
            for shape, axes, centre in own
            for _, _, middle in others
        )

    @property
    def touches(self) -> bool:
        """Whether they touch at rest; what is round may stand in the ground with its trimmings."""
        gap = self.gap(self.subject.rest)
        return -self.reach * (APART if self.other else SUNK) <= gap <= TOUCHING * self.reach


def contacts(subject: Subject) -> Iterator[TouchingBodies]:
    """Yield the bodies that touch at rest: on the ground, then each other."""
    solid = [body for body in subject.system.bodies if body.shapes]
    reaches = {
        body.name: reach_of(BodyGeometry(body.name, subject.system.resolved_shapes(body)))
        for body in solid
    }
    for body in solid:
        found = TouchingBodies(subject, body, None, reaches[body.name])
        if body.touches_ground and subject.moving(body.frame) and found.touches:
            yield found
    origins = subject.poses(subject.rest)[:, :, 3]
    for one, other in combinations(solid, 2):
        far = origins[subject.place_of(one)] - origins[subject.place_of(other)]
        found = TouchingBodies(subject, one, other, min(reaches[one.name], reaches[other.name]))
        near = np.linalg.norm(far) <= (1 + TOUCHING) * (reaches[one.name] + reaches[other.name])
        if near and found.moved_by and found.touches:
            yield found


def standing(subject: Subject) -> Iterator[Remark]:
    """Yield the bodies that are on the ground, or in it, however the machine moves, by mistake.

    Of those that may touch it, not those whose middle is on it: balls around a point on which the
    machine stands.
    """
    states, poses = [subject.rest, *random_states(subject.model)], subject.poses(subject.rest)
    for body in subject.system.bodies:
        if not (body.shapes and subject.moving(body.frame)):
            continue
        geometry = BodyGeometry(body.name, subject.system.resolved_shapes(body))
        contact = TouchingBodies(subject, body, None, reach_of(geometry))
        gaps, rounding = np.array([contact.gap(x) for x in states]), TOUCHING * contact.reach
        own = poses[subject.place_of(body)]
        middles = [abs(frame_in_world(shape, own)[1][2]) for shape in geometry.shapes]
        if not body.touches_ground and np.all(np.abs(gaps) <= rounding):
            what = f"{body.name} always touches the ground z = 0, which is a collision for every "
            what += "plan. Where it stands, rolls or slides on it: Body(…, touches_ground=True)."
            yield Remark("collision with the ground", body.name, what, ("Body", body.name))
        deep = gaps.max() < -SUNK * contact.reach and min(middles) > rounding
        if body.touches_ground and deep and np.ptp(gaps) <= rounding:
            what = f"Its shape always goes {-gaps[0]:.3g} m into the ground z = 0, which it may "
            what += "touch and not enter. Is it as high above the ground as its radius or half its "
            what += "height, and has its shape a diameter in the place of a radius?"
            yield Remark("sunk into the ground", body.name, what, ("Body", body.name))

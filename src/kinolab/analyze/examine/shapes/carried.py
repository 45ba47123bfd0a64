"""Bodies that others carry: whether they stay where they are joined."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.analyze.examine.shapes.joints import SMALL
from kinolab.analyze.examine.shapes.touching_bodies import APART, TouchingBodies
from kinolab.dynamics import Body, Coordinate
from kinolab.dynamics.symbols.expressions import is_zero
from kinolab.numerics.arrays import Array
from kinolab.simulation.stability import random_states
from kinolab.world.shapes.geometry import frame_in_world, triangles

ROUNDING = 1e-9  # relative, of velocities: compiled derivatives are exact
SEEN = 1e-3  # share of a velocity from which it is another one
SLENDER = (
    3.0  # length to width of a rod, of which m l^2 / 12 is short of m (l^2 + w^2) / 12 by 10 %
)
ORDER = (
    "Are the factors of its frame in the wrong order? What is carried begins with the frame of "
    "what carries it: base @ rot_y(q) @ move(…)."
)


def left_behind(subject: Subject) -> Iterator[Remark]:
    """Yield the bodies that go along with another at rest, and elsewhere where they are turned.

    A coordinate that moves two bodies, one of which has further ones, carries both as one: where
    it does so at rest and no longer as the further ones move, these turn the motion, too.
    """
    for body in subject.system.bodies:
        if body.touches_ground:
            continue  # what stands on the ground follows that, such as wheels that lean
        for base in subject.carriers(body):
            if not base.shapes and is_zero(base.mass):
                continue  # a rotor's inertia, which has no place
            if found := _left_behind(subject, body, base):
                yield found
                break


def _left_behind(subject: Subject, body: Body, base: Body) -> Remark | None:
    shared = subject.moving(base.frame)
    own = [c for c in subject.plain if c.name in subject.moving(body.frame) - shared]
    if not own:
        return None
    there = subject.rest.copy()
    for k, c in enumerate(own):
        # Shares of spans, by which what is carried is moved against what carries it
        there[subject.plain[c]] += (0.3, -0.2, 0.45)[k % 3] * subject.span(c)
    (gap, size), (further, faster) = (
        _carried(subject, body, base, x) for x in (subject.rest, there)
    )
    for coordinate in (c for c in subject.plain if c.name in shared):
        k = subject.plain[coordinate]
        if gap[k] <= ROUNDING * size[k] and further[k] > SEEN * faster[k]:
            names = " and ".join(c.name for c in own)
            names += " have" if len(own) > 1 else " has"
            what = f"{coordinate} moves {body.name} along with {base.name} at rest, and another "
            what += f"way where {names} moved: they part, and {body.name} turns about another "
            what += f"point than one of {base.name}. {ORDER}"
            about = f"{body.name} and {base.name}"
            return Remark("carried at rest only", about, what, ("Body", body.name))
    return None


def _carried(subject: Subject, body: Body, base: Body, x: Array) -> tuple[Array, Array]:
    """Return how fast a body's origin leaves its base, and how fast it moves, (nq,) each."""
    origin = subject.poses(x)[subject.place_of(body)][:, 3]
    gap = np.linalg.norm(subject.slip(body, base, origin, x), axis=0)
    size = np.linalg.norm(subject.slip(body, None, origin, x), axis=0)
    return gap, size + 1e-12


def swung_off(subject: Subject, touching: Sequence[TouchingBodies]) -> Iterator[Remark]:
    """Yield the bodies that turn about an axis which does not go through them.

    Either they touch what carries them at rest and are swung off it, or they are rods that point at
    the joint and end before it.
    """
    for body in (body for body in subject.system.bodies if body.shapes):
        bases = [base for base in subject.carriers(body) if base.shapes]
        beside = [c for c in touching if c.other and body in c.pair
                  and not _fixed(subject, *c.pair)]  # fmt: skip
        joined = [c for c in beside if any(base in c.pair for base in bases)]
        for coordinate in _turning(subject, body, bases[:1]):
            axis = axis_of(subject, body, coordinate)
            if axis is None or depth_of(subject, body, axis) > -APART * reach_of(subject, body):
                continue
            if joined and all(_off(contact, coordinate) for contact in joined):
                yield _swung(joined[0], body, coordinate)
                break
            if (joined or not beside) and (
                found := _floats(subject, body, bases, axis, coordinate)
            ):
                yield found
                break


def _fixed(subject: Subject, one: Body, other: Body) -> bool:
    """Whether two bodies move by the same coordinates, as parts of one link do."""
    return subject.moving(one.frame) == subject.moving(other.frame)


def _turning(subject: Subject, body: Body, bases: Sequence[Body]) -> list[Coordinate]:
    """Return the coordinates that move a body and not what carries it; none unless all turn it."""
    shared = subject.moving(bases[0].frame) if bases else frozenset()
    own = subject.moving(body.frame) - shared
    plain = [c for c in subject.plain if c.name in own]
    turning = len(plain) == len(own) and all(c.unit == "rad" for c in plain)
    return plain if bases and turning else []


def axis_of(subject: Subject, body: Body, coordinate: Coordinate) -> tuple[Array, Array] | None:
    """Return a point of the axis about which a coordinate turns a body, and its direction.

    Both have shape (3,), in the world; None where it does not turn it about an axis that stands.
    """
    x, k = subject.rest, subject.plain[coordinate]
    origin = subject.poses(x)[subject.place_of(body)][:, 3]
    spin, speed = subject.spin(body, x)[:, k], subject.slip(body, None, origin, x)[:, k]
    size = float(np.linalg.norm(spin))
    if size < 1e-9 or abs(spin @ speed) > SEEN * size * (np.linalg.norm(speed) + 1e-12):
        return None
    return origin + np.cross(spin, speed) / size**2, spin / size


def _corners(subject: Subject, body: Body) -> Array:
    pose = subject.poses(subject.rest)[subject.place_of(body)]
    shapes = subject.system.resolved_shapes(body)
    own: Array = np.vstack([triangles(shape)[0] for shape in shapes])
    return np.asarray(own @ pose[:, :3].T + pose[:, 3])


def reach_of(subject: Subject, body: Body) -> float:
    """Return half the diagonal of a box around a body, in [m]."""
    corners = _corners(subject, body)
    return float(np.linalg.norm(np.ptp(corners, axis=0)) / 2)


def depth_of(subject: Subject, body: Body, axis: tuple[Array, Array], reach: float = 0.0) -> float:
    """Return how deep a line goes into a body in [m]; negative where it passes.

    Args:
        axis: A point and the direction of the line, shape (3,) each, in the world.
        reach: How far from that point in [m] it is looked for.
    """
    pose = subject.poses(subject.rest)[subject.place_of(body)]
    # 41 points of an axis, over the reach of a body
    along = np.linspace(-1, 1, 41) * (reach or 2 * reach_of(subject, body))
    points = axis[0] + along[:, None] * axis[1]
    placed = [(s, *frame_in_world(s, pose)) for s in subject.system.resolved_shapes(body)]
    return max(float(s.depths((points - middle) @ axes).max()) for s, axes, middle in placed)


def _off(contact: TouchingBodies, coordinate: Coordinate) -> bool:
    """Whether two bodies are apart as soon as a coordinate moves, either way."""
    gaps = [contact.gap(contact.subject.moved({coordinate: way})) for way in (SMALL, -SMALL)]
    return min(gaps) > APART * contact.reach


def _swung(contact: TouchingBodies, body: Body, coordinate: Coordinate) -> Remark:
    what = f"They touch at rest, and come apart where {coordinate} moves: {body.name} turns about "
    what += f"an axis that does not go through it. {ORDER}"
    return Remark("touches at rest only", contact.names, what, ("Body", body.name))


def _floats(
    subject: Subject,
    body: Body,
    bases: Sequence[Body],
    axis: tuple[Array, Array],
    coordinate: Coordinate,
) -> Remark | None:
    """Find a rod that points at its joint, which is in what carries it, and does not reach it."""
    system = subject.system
    corners = _corners(subject, body)
    middle = (corners.max(axis=0) + corners.min(axis=0)) / 2
    joint = axis[0] + ((middle - axis[0]) @ axis[1]) * axis[1]
    away = (middle - joint) / max(float(np.linalg.norm(middle - joint)), ROUNDING)
    along = (corners - joint) @ away
    length, gap = float(np.ptp(along)), float(along.min())
    width = 2 * np.linalg.norm(corners - joint - np.outer(along, away), axis=1).max()
    reach = reach_of(subject, body)
    base = next((b for b in bases if depth_of(subject, b, (joint, axis[1]), reach) >= 0), None)
    between = any(
        float(((_corners(subject, one) - joint) @ away).min()) < gap
        for one in system.bodies
        if one is not body and one.shapes and _fixed(subject, one, body)
    )
    if between or system.cables or base is None or length < SLENDER * width:
        return None
    if not width <= gap <= length:  # beyond what a joint of its own width is
        return None
    what = (
        f"{body.name} turns with {coordinate} about a point of {base.name}, and ends {gap:.3g} m "
        f"away from it: nothing joins them. A uniform rod of {length:.3g} m has its middle half "
        f"of that from its joint, and this one has it {gap + length / 2:.3g} m away."
    )
    about = f"{body.name} and {base.name}"
    return Remark("away from its joint", about, what, ("Body", body.name))


def _falling(subject: Subject) -> Array:
    """Return the accelerations of coordinates from rest at random places, shape (states, nq)."""
    model = subject.model
    states = random_states(model)
    states[:, model.speeds] = 0.0
    return subject.begun(states, np.tile(model.null_control(), (len(states), 1)))


def on_their_own_axis(subject: Subject) -> Iterator[Remark]:
    """Yield the rods that a joint turns about their own length, though only friction acts in it."""
    x = subject.rest
    for body in (body for body in subject.system.bodies if body.shapes):
        own = _corners(subject, body)
        points = own - (own.max(axis=0) + own.min(axis=0)) / 2
        bases = [b for b in subject.carriers(body) if b.shapes or not b.massless]
        for coordinate in _turning(subject, body, bases[:1]):
            spin = subject.spin(body, x)[:, subject.plain[coordinate]]
            still = not subject.poses_by(x)[subject.place_of(body), :, 3][
                :, subject.plain[coordinate]
            ].any()
            size = float(np.linalg.norm(spin))
            if coordinate.name in subject.driven or not (still and size > ROUNDING):
                continue
            if np.abs(_falling(subject)[:, subject.plain[coordinate]]).max() > ROUNDING:
                continue  # what hangs on it lets it swing
            along = points @ spin / size
            width = 2 * np.linalg.norm(points - np.outer(along, spin / size), axis=1).max()
            if np.ptp(along) >= SLENDER * width:
                what = f"{coordinate} turns it about its own length, and nothing but friction acts "
                what += (
                    "in that joint: it does not swing. Is the axis another one, rot_x, rot_y or "
                )
                what += "rot_z?"
                yield Remark("turns about its own length", body.name, what, ("Body", body.name))

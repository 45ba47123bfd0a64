"""Round bodies that touch something: what keeps them from slipping, and whether it does."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.analyze.examine.shapes.joints import parting
from kinolab.analyze.examine.shapes.touching_bodies import TouchingBodies
from kinolab.dynamics import Body
from kinolab.dynamics.language.mechanism_parts import (
    atoms_of,
    configuration_symbols,
    coordinate_of,
    tangent_symbols,
)
from kinolab.dynamics.language.shapes import Shape, ShapeKind
from kinolab.dynamics.symbols.symbols import RateSymbol
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.world.shapes.geometry import frame_in_world, sizes

ROUNDING = 1e-6  # relative, of slips: compiled derivatives are exact
WRONG = 0.02  # share of the spin's own slip from which a rolling wheel slips
# Of its middle's speed, from which a wheel slides along its axle: where one that leans is steered,
# its lowest point is off the axis that it is steered about, and constraints at that leave as much.
ASIDE = 0.02
NEAR = 0.1  # of the radius: shapes of wheels are trimmed by as much
SUNK = 0.3  # of the radius: a ball that lies so deep in what it rolls on is in the wrong place
ASKEW = "rolling along the wrong direction"


@dataclass(frozen=True)
class Wheel:
    """A round body at a configuration, on what it touches.

    Attributes:
        centre: Its middle in the world in [m], shape (3,).
        axle: Unit vector along its axis, shape (3,); None of a ball.
        normal: Unit vector from what it touches to it, shape (3,).
        point: Where it touches, in [m], shape (3,).
        arm: How far that is from its middle, in [m].
    """

    centre: Array
    axle: Array | None
    normal: Array
    point: Array
    arm: float


def slips(contact: TouchingBodies) -> Iterator[Remark]:
    """Yield what is wrong about the rolling of a round body on what it touches."""
    for body, base in ((contact.one, contact.other), (contact.other, contact.one)):
        if body is None or (shape := round_shape(contact.subject, body)) is None:
            continue
        plain = contact.subject.plain
        places = [
            contact.subject.moved({c: shares[i % 2] for i, c in enumerate(plain)}, turned=shares[0])
            for shares in ((0.0, 0.0), (0.35, -0.2), (-0.3, 0.4))  # shares of spans, alternating
        ]
        wheels = [_wheel(contact.subject, body, base, shape, x) for x in places]
        if not any(wheels[1:]):
            if wheels[0] is not None and _rolls_at_rest(contact, body, base, wheels[0]):
                yield parting(contact, "several coordinates move", tuple(plain))
            continue  # else they touch by chance, and part as the machine moves
        for k, (x, wheel) in enumerate(zip(places, wheels, strict=True)):
            found = [] if wheel is None else list(_judged(contact.subject, body, base, wheel, x))
            if k and any(remark.kind.startswith("rolling") for remark in found):
                found = [_aside(remark) for remark in found]
            yield from found
            if found or (k == 0 and wheel is None):
                break


def _rolls_at_rest(contact: TouchingBodies, body: Body, base: Body | None, wheel: Wheel) -> bool:
    """Whether the middle of a round body moves on its base at rest, and what touches does not."""
    subject, x = contact.subject, contact.subject.rest
    try:
        moving, _ = subject.in_motion(x)
    except KinolabError:
        return False
    across = np.eye(3) - np.outer(wheel.normal, wheel.normal)
    slip, middle = (moving @ (across @ subject.slip(body, base, p, x)).T
                    for p in (wheel.point, wheel.centre))  # fmt: skip
    return bool(np.abs(slip).max() <= WRONG * np.abs(middle).max() and np.abs(middle).max() > 0)


def _aside(remark: Remark) -> Remark:
    """Say that what rolls at rest, and so has sign and radius right, slips elsewhere."""
    if not remark.kind.startswith("rolling"):
        return remark
    what = (
        f"Where {remark.part[1]!r} holds, {remark.about} rolls at rest and slips where the machine "
        "has turned: what is constrained is not the velocity along which it rolls. Take that of "
        "a frame that is steered with it, V = velocity(frame), along its axis: V.x."
    )
    return replace(remark, kind=ASKEW, sentence=what)


def round_shape(subject: Subject, body: Body) -> Shape | None:
    """Return the ball, or the widest cylinder, that a body is; None of one that is not round."""
    shapes = subject.system.resolved_shapes(body)
    round_ = [shape for shape in shapes if sizes(shape)[0] is ShapeKind.SPHERE]
    round_ = round_ or [shape for shape in shapes if sizes(shape)[0] is ShapeKind.CYLINDER]
    return max(round_, key=lambda shape: float(sizes(shape)[1][0]), default=None)


def _wheel(subject: Subject, body: Body, base: Body | None, shape: Shape, x: Array) -> Wheel | None:
    """Return a round body where it touches its base at a state; None where it does not."""
    poses = subject.poses(x)
    pose = poses[subject.place_of(body)]
    axes, _ = frame_in_world(shape, pose)
    ball = sizes(shape)[0] is ShapeKind.SPHERE
    # Of a pair of wheels on an axle, the middle one counts.
    centre = pose[:, 3] if not ball else pose[:, :3] @ np.array(shape.at, dtype=float) + pose[:, 3]
    along = axes[:, 2]
    if not ball:
        offset = pose[:, :3] @ np.array(shape.at, dtype=float)
        centre = centre + offset - (offset @ along) * along
    away = _away_from(subject, base, poses, centre)
    if away is None:
        return None
    normal, height = away
    down = normal if ball else normal - (normal @ along) * along
    # 0.3: cosine up to which a wheel stands on its rim and not on its face
    if np.linalg.norm(down) < np.sqrt(1 - 0.3**2) or height <= 0:
        return None
    down = down / np.linalg.norm(down)
    arm = height / float(down @ normal)
    if abs(arm - sizes(shape)[1][0]) > (SUNK if ball else NEAR) * sizes(shape)[1][0]:
        return None
    return Wheel(centre, None if ball else along, normal, centre - arm * down, arm)


def _away_from(
    subject: Subject, base: Body | None, poses: Array, centre: Array
) -> tuple[Array, float] | None:
    """Return the direction from a base to a point, and how far it is in [m]."""
    if base is None:
        return np.array([0.0, 0.0, 1.0]), float(centre[2])
    pose, nearest = poses[subject.place_of(base)], None
    for shape in subject.system.resolved_shapes(base):
        axes, middle = frame_in_world(shape, pose)
        own = axes.T @ (centre - middle)
        far = -float(shape.depths(own))
        if nearest is None or far < nearest[1]:
            h = 1e-6 * max(abs(far), 1e-3)
            slope = np.array([float(shape.depths(own - h * e) - shape.depths(own + h * e))
                              for e in np.eye(3)])  # fmt: skip
            nearest = axes @ slope, far
    if nearest is None or not np.linalg.norm(nearest[0]) > 0:
        return None
    return nearest[0] / np.linalg.norm(nearest[0]), nearest[1]


def _judged(
    subject: Subject, body: Body, base: Body | None, wheel: Wheel, x: Array
) -> Iterator[Remark]:
    try:
        moving, rates = subject.in_motion(x)
    except KinolabError:
        return
    slope = subject.slip(body, base, wheel.point, x)
    middle = subject.slip(body, base, wheel.centre, x)
    slope = slope - np.outer(wheel.normal, wheel.normal @ slope)
    size = float(np.abs(slope).max(initial=0.0))
    if np.abs(moving @ middle.T).max() <= ROUNDING * max(np.abs(moving @ slope.T).max(), 1e-300):
        return  # its middle stays where it is on that: it is mounted on it and turns in its place
    turned = subject.poses_by(x)[subject.place_of(body)][:, :3]
    spun = False
    for coordinate, k in subject.plain.items():
        still = np.abs(middle[:, k]).max() <= ROUNDING * size
        if not still or np.linalg.norm(slope[:, k]) <= ROUNDING * size:
            continue
        if wheel.axle is not None:
            own = subject.poses(x)[subject.place_of(body)][:, :3].T @ wheel.axle
            if np.abs(turned[..., k] @ own).max() > ROUNDING:
                continue  # it turns the axle, too
        spun = True
        along = slope[:, k] / np.linalg.norm(slope[:, k])
        spin = moving[:, k] * (along @ slope[:, k])
        whole = moving @ slope.T @ along
        yield from _rolls(subject, body, base, [RateSymbol(coordinate)], whole - spin, spin, wheel)
    if wheel.axle is None:
        yield from _rolls_about_all(subject, body, base, moving, slope, middle, wheel)
    if wheel.axle is not None and (spun or _skids(subject, body, base, moving, x)):
        side = wheel.axle - (wheel.axle @ wheel.normal) * wheel.normal
        across = slope.T @ (side / np.linalg.norm(side))
        if np.abs(moving @ across).max() <= ASIDE * np.abs(moving @ middle.T).max():
            return
        if subject.model.nt == subject.model.nq:  # with attitudes, rates of entries are no rates
            moving = rates = np.random.default_rng(0).uniform(-1, 1, rates.shape)
        yield from _slips_aside(subject, body, base, moving @ across, x, rates)


def _rolls_about_all(
    subject: Subject,
    body: Body,
    base: Body | None,
    moving: Array,
    slope: Array,
    middle: Array,
    wheel: Wheel,
) -> Iterator[Remark]:
    """Judge a ball that turns by an attitude, along the direction in which it slips most.

    Args:
        body: The ball.
        base: What it is on; None for the ground.
        moving: Rates of a configuration's entries in allowed motions, shape (n, nq).
        slope: Slip of the point that touches by these rates, in [m/s], shape (3, nq).
        middle: The same of its middle.
        wheel: The ball where it touches.
    """
    owned = subject.moving(body.frame) - (subject.moving(base.frame) if base else frozenset())
    for turning in subject.turning:
        places = subject.places_of(turning)
        if turning.name not in owned or np.abs(middle[:, places]).max() > ROUNDING:
            continue  # it is carried round by it
        whole, spin = moving @ slope.T, moving[:, places] @ slope[:, places].T
        most = np.linalg.svd(whole)[2][0]
        along = (whole - spin) @ most, spin @ most
        yield from _rolls(subject, body, base, turning.rates, *along, wheel)
        return


def _skids(subject: Subject, body: Body, base: Body | None, moving: Array, x: Array) -> bool:
    """Whether nothing guides a body with wheels that do not turn: it moves or swings all ways.

    One that something guides may have castors, which are drawn as wheels and turn by themselves.
    """
    if base is not None:
        return False
    origin = subject.poses(x)[subject.place_of(body)][:, 3]
    ways = np.vstack([subject.slip(body, None, origin, x)[:2], subject.spin(body, x)[2:]])
    motions = moving @ ways.T
    largest = np.abs(motions).max(axis=0)
    if largest.min() > 0 and np.linalg.matrix_rank(motions / largest, tol=1e-6) == 3:
        return True
    return any(
        _swings(subject, body, int(k), moving) for k in np.flatnonzero(np.abs(ways[2]) > ROUNDING)
    )


def _swings(subject: Subject, body: Body, k: int, moving: Array) -> bool:
    """Whether a body turns by an entry of its own that what carries it does not decide."""
    bases = [one for one in subject.carriers(body) if subject.moving(one.frame)]
    if not bases or k not in subject.plain.values():
        return False
    carried = [i for c, i in subject.plain.items() if c.name in subject.moving(bases[0].frame)]
    if k in carried:
        return False
    others = moving[:, carried]
    left = moving[:, k] - others @ np.linalg.lstsq(others, moving[:, k], rcond=None)[0]
    return bool(np.abs(left).max() > ROUNDING * max(np.abs(moving[:, k]).max(), 1e-300))


def _rolls(
    subject: Subject,
    body: Body,
    base: Body | None,
    rates: Sequence[sympy.Symbol],
    carried: Array,
    spin: Array,
    wheel: Wheel,
) -> Iterator[Remark]:
    """Judge how a round body's middle goes along with its spin, both as slips (n,) in [m/s].

    A ball that turns about every axis rolls by two constraints, a wheel by one.

    Source: Neimark, Fufaev, Dynamics of Nonholonomic Systems, 1972, chapter 2.
    """
    on = "the ground" if base is None else base.name
    if np.abs(carried).max() <= ROUNDING * max(np.abs(spin).max(), 1e-300):
        return  # it turns in its place
    if any(_rubs(subject, body, base, own) for own in rates):
        return
    about, owner = body.name, coordinate_of(rates[0])
    constraints = _constraints_on(subject, rates)
    if not constraints:
        what = f"{body.name} touches {on} and moves along it, but nothing joins that to "
        what += f"{owner.name if owner else ''}, by which it turns: it slides as on ice. It rolls "
        what += f'with constraints=[zero(velocity - radius * {rates[0]}, "rolling")]'
        what += ", and so along the other direction." if rates[1:] else "."
        yield Remark("no rolling constraint", about, what, ("Body", body.name))
        return
    if np.abs(carried + spin).max() <= WRONG * np.abs(spin).max():
        return
    if len(constraints) < min(len(rates), 2):
        what = f"{constraints[0]!r} keeps it from slipping along one direction, and nothing along "
        what += f"the other, in which it slides on {on} as on ice: a ball rolls by two constraints."
        yield Remark("no rolling constraint", about, what, ("Body", body.name))
        return
    named, part = " and ".join(map(repr, constraints)), ("zero", constraints[0])
    ratio = float(carried @ spin / (spin @ spin)) if (spin @ spin) > 0 else 0.0
    fits = np.abs(carried - ratio * spin).max() <= WRONG * np.abs(carried).max()
    begin = f"Where {named} hold{'s' * (constraints[1:] == [])}, {body.name} slips on {on}: "
    if fits and abs(ratio - 1) <= WRONG:
        what = "its middle goes the way that it would roll back. The sign before "
        what += f"{' or '.join(map(str, rates))} is wrong, or that of the rotation in its frame."
        yield Remark("rolling with the wrong sign", about, begin + what, part)
    elif fits and ratio < 0:
        what = f"it rolls as with the radius {-ratio * wheel.arm:.4g} m, and its middle is "
        what += f"{wheel.arm:.4g} m from where it touches."
        sunk = -ratio * wheel.arm - wheel.arm
        what += f" Or is it in the wrong place, and sinks {sunk:.3g} m into {on}?" * (sunk > 0)
        yield Remark("rolling with the wrong radius", about, begin + what, part)
    elif fits and ratio > 0:
        what = f"it rolls backwards, as with the radius {ratio * wheel.arm:.4g} m, and its middle "
        what += f"is {wheel.arm:.4g} m from where it touches: sign and radius are wrong."
        yield Remark("rolling with the wrong sign", about, begin + what, part)
    else:
        what = "what is constrained is not the velocity along which it rolls on that."
        yield Remark(ASKEW, about, begin + what, part)


def _slips_aside(
    subject: Subject,
    body: Body,
    base: Body | None,
    free: Array,
    x: Array,
    rates: Array,
) -> Iterator[Remark]:
    """Say that a wheel slips along its axle, unless a force acts along it or an input decides it.

    Args:
        base: What it is on; None for the ground.
        free: Slips along the axle at ``rates``, in [m/s], shape (n,).
        x: State, shape (nx,).
        rates: Of all coordinates, shape (n, nt), which constraints need not allow.
    """
    acting = _acting_along(subject, x, rates)
    if acting.size:
        left = free - acting @ np.linalg.lstsq(acting, free, rcond=None)[0]
        if np.abs(left).max() <= ROUNDING * float(np.abs(free).max()):
            return
    on = "the ground" if base is None else base.name
    what = f"{body.name} is a wheel on {on}, and nothing keeps it from sliding along its axle. "
    what += 'A wheel that grips has constraints=[zero(V.y, "no sideslip")], with V the velocity of '
    what += "a frame that is steered with it and does not roll."
    yield Remark("no sideslip constraint", body.name, what, ("Body", body.name))


def _constraints_on(subject: Subject, rates: Sequence[sympy.Symbol]) -> list[str]:
    """Return the names of constraints on a coordinate's rates and others."""
    held = subject.system.constraints
    return [c.name for c in held if not set(rates).isdisjoint(atoms_of(c.velocity))]


def _rubs(subject: Subject, body: Body, base: Body | None, own: sympy.Symbol) -> bool:
    """Whether a force acts, or an input or a state decides, along a rate and a motion's."""
    turned = coordinate_of(own)
    frames = [one.frame for one in (body, base) if one is not None]
    moving = {name for frame in frames for name in subject.moving(frame)}
    moving -= {turned.name} if turned is not None else set()
    along = (symbols for _, symbols in subject.pushed_along if own in symbols)
    return any((owner := coordinate_of(s)) is not None and owner.name in moving
               for symbols in along for s in symbols)  # fmt: skip


def _acting_along(subject: Subject, x: Array, rates: Array) -> Array:
    """Return those velocities in motions at a state, shape (n, velocities)."""
    system = subject.system
    values = system.substitutions
    symbols = [*configuration_symbols(system), *tangent_symbols(system)]
    known = [one.subs(values) for one, own in subject.pushed_along if own <= {*symbols, *values}]
    if not known:
        return np.zeros((len(rates), 0))
    function = sympy.lambdify(symbols, known, "numpy")
    rows = [function(*x[: subject.model.nq], *row) for row in rates]
    return np.array(rows, dtype=float)

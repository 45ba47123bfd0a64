"""Numbers in other units: masses, lengths, inertias, angles and gravity against everyday size."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import permutations
from typing import Any

import numpy as np
import sympy

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics import Body, Coordinate, Parameter
from kinolab.dynamics.codegen.state_space import TURN
from kinolab.dynamics.language.forces import Effort, Gravity
from kinolab.dynamics.language.frames import Rotation
from kinolab.dynamics.language.mechanism_parts import energies_in, loads_in
from kinolab.dynamics.language.shapes import Shape, ShapeKind
from kinolab.dynamics.model.units import in_digits
from kinolab.dynamics.symbols.expressions import exact, parts_of
from kinolab.numerics.arrays import Array
from kinolab.robots.solids.solid_mass import box_mass, cylinder_mass, mesh_mass
from kinolab.robots.tree.joint_inertia import together
from kinolab.robots.tree.kinematic_tree import Inertial, Link
from kinolab.simulation.stability import random_states
from kinolab.world.shapes.geometry import placement, sizes, triangles

# Of a moment of inertia to m r^2, where r is how far the shape goes from that axis. No body that
# lies within its shape has more than 1, which is that of a hoop. Shapes may leave parts out of a
# body whose moments are typed in: a wrong unit there is a factor of 1e4 (kg cm^2) at least.
LARGEST_INERTIA, LARGEST_TYPED = 1.01, 100.0
THIN = 0.25  # of the largest r^2: about such an axis, moments are often rounded up
DENSEST = 22_590.0  # [kg/m^3] osmium; CRC Handbook of Chemistry and Physics
AIR = 1.2  # [kg/m^3] at 20 °C
ROUNDING = 1e-9
SLACK = 0.01  # relative: numbers in files have three digits
WEAKEST, STRONGEST = 0.1, 30.0  # [m/s^2] moons and planets: Ceres has 0.28, Jupiter 24.8
# whole numbers as one has them in degrees, up to a turn; 10 and 100 rad stand for no limit
DEGREES = frozenset(range(11, 361)) - {100}
# [m/s] of the rim of a disk of steel of 800 MPa: (3 + nu) / 8 rho v^2 is the stress in its middle;
# Timoshenko, Goodier, Theory of Elasticity, 3rd ed., 1970, section 32.
BURSTING = 500.0
LONGEST = 100.0  # [m] of a body: what is longer was hardly meant in m
STIFFEST = 1e8  # [m^2/s^2] E / rho of carbon fibres in a resin; steel has a quarter of it
# Of moments to those of the body's mass spread over its shapes: shapes are rough, so that they may
# be twice as large or small, and are of another order where only that brings them so near.
FITS, MISFITS = 2.0, 4.0


def odd_numbers(subject: Subject) -> Iterator[Remark]:
    """Yield the numbers that look like another unit."""
    for body in subject.system.bodies:
        swapped = [*_order(subject, body), *_flat(subject, body), *_round(subject, body)]
        yield from swapped[:1] or _inertia(subject, body)
        yield from _density(subject, body)
        yield from _length(subject, body)
    yield from _points(subject)
    yield from _angles(subject)
    yield from _limits(subject)
    yield from _speeds(subject)
    yield from _gravity(subject)


def _corners(subject: Subject, body: Body) -> list[Array]:
    return [triangles(shape)[0] for shape in subject.system.resolved_shapes(body)]


def _reach(subject: Subject, body: Body) -> float:
    """Return how far a body's shape goes from its centre of mass, in [m]; 0 without a shape."""
    corners = _corners(subject, body)
    return max((float(np.linalg.norm(points, axis=1).max()) for points in corners), default=0.0)


def _inertia(subject: Subject, body: Body) -> Iterator[Remark]:
    """Compare the principal moments with mass and shape, axis by axis.

    A single number for all axes counts where the shape is widest: it may be meant for one of them.
    """
    mass = subject.system.number(body.mass)
    own, axes = np.linalg.eigh(subject.system.inertia_of(body))
    points = _whole(subject, body)
    if not (mass > 0 and own[-1] > 0 and len(points)):
        return  # a point mass, or a wheel whose mass counts elsewhere
    reaches = np.max((points**2).sum(axis=1)[:, None] - (points @ axes) ** 2, axis=0)  # squared
    widest, used = reaches.max(), body.inertia_matrix.free_symbols
    derived = used & exact(body.mass).free_symbols or any(
        getattr(symbol, "unit", "") == "kg" for symbol in used
    )
    if not derived or np.ptp(own) <= ROUNDING * own[-1]:
        reaches = np.full(3, widest)
    allowed = np.where(
        reaches < THIN * widest, 1 / THIN, LARGEST_INERTIA if derived else LARGEST_TYPED
    )
    shares = own / (mass * np.maximum(reaches, ROUNDING))
    k = int(np.argmax(shares / allowed))
    size = "large"
    if shares[k] <= allowed[k]:
        k, size = int(np.argmax(own)), "small"
        if own[k] >= 1e-3 * mass * widest:  # a sphere of a third of the radius has 0.04
            return
    along = max(zip(np.abs(axes[:, k]), "xyz", strict=True))[1]
    what = (
        f"It is {in_digits(own[k])} kg m^2 about its {along} axis, and {in_digits(mass)} kg within "
        f"{math.sqrt(reaches[k]):.3g} m of that have {'at most' if size == 'large' else 'about'} "
        f"{in_digits(mass * reaches[k])} kg m^2: "
    )
    if derived and size == "large":
        what += (
            "is it that about the centre of mass, are its moments in the order x, y, z, and are "
        )
        what += "the shape's sizes whole ones, not halves?"
    else:
        what += "is it in kg m^2? 1 kg m^2 = 10^4 kg cm^2 = 10^6 kg mm^2 = 10^7 g cm^2."
    yield Remark(f"inertia too {size}", body.name, what, ("Body", body.name))


def _whole(subject: Subject, body: Body) -> Array:
    """Return the corners of a body's shapes, and of those that are fixed to it, in its frame."""
    poses = subject.poses(subject.rest)
    own = poses[subject.place_of(body)]
    corners = [np.zeros((0, 3)), *_corners(subject, body)]
    for other in subject.system.bodies:
        if other.massless and other.frame.motions[: len(body.frame.motions)] == body.frame.motions:
            pose = poses[subject.place_of(other)]
            if subject.moving(other.frame) == subject.moving(body.frame):
                placed = [c @ pose[:, :3].T + pose[:, 3] for c in _corners(subject, other)]
                corners += [(c - own[:, 3]) @ own[:, :3] for c in placed]
    return np.vstack(corners)


def _points(subject: Subject) -> Iterator[Remark]:
    """Compare where forces act on a body with how far its shape goes."""
    for effort in subject.system.efforts:
        body, at = getattr(effort, "on", None), getattr(effort, "at", None)
        reach = _reach(subject, body) if body in subject.system.bodies else 0.0
        if body is None or not reach or at is None:
            continue
        away = math.hypot(*map(subject.system.number, at))
        # 10 reaches of a body, from where a force acts on it: mm for m is a factor of 1e3
        away = max(away, *_levers(subject, effort), 0.0)
        if away > 10.0 * reach:
            what = f"The {effort} acts {away:.3g} m away from its centre of mass, and its shape "
            what += f"goes {reach:.3g} m far: are at=, or levers, in m and not in mm or cm?"
            part = (type(effort).__name__, "")
            yield Remark("force far from its body", body.name, what, part)
            return


def _levers(subject: Subject, effort: Effort) -> Iterator[float]:
    """Yield how far from a body's centre the force of each input in a wrench acts, in [m].

    A force F and a torque T are a force on the line in the distance |F x T| / |F|^2, and a torque
    about that line.
    """
    stated = [getattr(effort, word, (0, 0, 0)) for word in ("force", "torque")]
    rest: dict[sympy.Expr, float] = {c: float(subject.rest[k]) for c, k in subject.plain.items()}
    for entry in subject.system.inputs:
        slopes = [[exact(part).diff(entry.symbol).subs(rest) for part in one] for one in stated]
        if all(isinstance(s, Parameter) for r in slopes for e in r for s in e.free_symbols):
            force, torque = np.array([[subject.system.number(e) for e in r] for r in slopes])
            if force @ force > 0:
                yield float(np.linalg.norm(np.cross(force, torque)) / (force @ force))


def _order(subject: Subject, body: Body) -> Iterator[Remark]:
    """Compare each moment with the most that the body's mass has about that axis within its shape.

    A point at (x, y, z) in the box around the shape has y^2 + z^2 about x. Moments beyond that may
    belong to a body whose shape leaves parts out; if they fit in another order they are swapped.
    """
    system, corners = subject.system, _corners(subject, body)
    moments = system.inertia_of(body)
    if not corners or np.any(moments - np.diag(np.diag(moments))):
        return
    far = np.abs(np.vstack(corners)).max(axis=0) ** 2
    most = system.number(body.mass) * (far.sum() - far)
    given = np.diag(moments)
    fitting = [o for o in permutations(range(3)) if (given[list(o)] <= most * (1 + SLACK)).all()]
    worst, at_most = int(np.argmax(given - most)), " at most"
    if not fitting or given[worst] <= most[worst] * (1 + SLACK):
        fitting = _as_solid(subject, body, given)
        if fitting:
            at_most = ""
            most = np.diag(solid_inertia(subject, body))
            worst = int(np.argmax(given / most))
    if not fitting or given[worst] <= most[worst] * (1 + SLACK):
        return
    right = ", ".join(f"{given[k]:.4g}" for k in fitting[0])
    what = f"It is {given[worst]:.4g} kg m^2 about {'xyz'[worst]}, and its mass within its shape "
    what += f"has {most[worst]:.3g} kg m^2 about that axis{at_most}. In the order ({right}) the "
    what += "moments of inertia about x, y and z fit its shape."
    yield Remark("inertia in another order", body.name, what, ("Body", body.name))


def _as_solid(subject: Subject, body: Body, given: Array) -> list[tuple[int, ...]]:
    """Return the order in which moments are those of the solid, if in their own they are not."""
    solid = np.diag(solid_inertia(subject, body))
    if not (solid.min() > 0 and given.min() > 0):
        return []
    off = {o: np.abs(np.log(given[list(o)] / solid)).max() for o in permutations(range(3))}
    best = min(off, key=lambda order: off[order])
    return [best] if off[best] < math.log(FITS) and off[0, 1, 2] > math.log(MISFITS) else []


def solid_inertia(subject: Subject, body: Body) -> Array:
    """Return the inertia (3, 3) about its origin of a body whose mass is spread over its shapes."""
    parts = []
    for shape in subject.system.resolved_shapes(body):
        (kind, half), pose = sizes(shape), np.vstack([placement(shape), np.eye(4)[3]])
        if kind is ShapeKind.BOX:
            own: Inertial | None = box_mass((2.0 * half).tolist(), 1.0)
        elif kind is ShapeKind.CYLINDER:
            own = cylinder_mass(half[0], 2.0 * half[2], 1.0)
        else:
            own, pose = mesh_mass(*triangles(shape), 1.0), np.eye(4)
        parts.append((Link("", own), pose))
    whole = together(parts)
    arm, share = whole.centre, subject.system.number(body.mass) / max(whole.mass, 1e-300)
    spread = arm @ arm * np.eye(3) - np.outer(arm, arm)  # parallel axes
    return np.asarray(share * (whole.inertia + whole.mass * spread))


def _wheel(subject: Subject, body: Body) -> tuple[int, float, float] | None:
    """Return the axis of a body of coaxial disks, its radius and its width; None of others."""
    shapes = subject.system.resolved_shapes(body)
    axes = {shape.axis for shape in shapes if shape.symmetric == "z"}
    if len(axes) != 1 or any(shape.symmetric != "z" for shape in shapes):
        return None
    k, points = "xyz".index(axes.pop()), np.vstack(_corners(subject, body))
    across = np.delete(points, k, axis=1)
    return k, float(np.linalg.norm(across, axis=1).max()), float(np.ptp(points[:, k]))


def _flat(subject: Subject, body: Body) -> Iterator[Remark]:
    """Yield the flat wheels with less inertia about their axles than across.

    About the axle of what is flat it is the sum of those about two diameters.
    """
    found = _wheel(subject, body)
    given = [subject.system.number(body.inertia_matrix[j, j]) for j in range(3)]
    if found is not None and found[2] <= found[1]:
        k, _, _ = found
        least = min(given[:k] + given[k + 1 :])
        if given[k] < least * (1 - SLACK):
            what = f"It is a flat wheel, and has {given[k]:.4g} kg m^2 about its axle, {'xyz'[k]}, "
            what += f"and {least:.4g} kg m^2 across: the largest moment of inertia of what is flat "
            what += "is that about its axle."
            yield Remark("inertia in another order", body.name, what, ("Body", body.name))


def _round(subject: Subject, body: Body) -> Iterator[Remark]:
    """Yield the bodies of revolution of which not the axle, but another axis is the odd one out.

    What is round has one moment of inertia about all axes across its axle.
    """
    found = _wheel(subject, body)
    given = [subject.system.number(body.inertia_matrix[j, j]) for j in range(3)]
    for k, other in ((0, 1), (0, 2), (1, 2)):
        odd = 3 - k - other
        alike = abs(given[k] - given[other]) <= ROUNDING * max(given)
        differs = abs(given[odd] - given[k]) > SLACK * max(given)
        if found is not None and alike and differs and odd != found[0]:
            axle, across = "xyz"[found[0]], "xyz"[3 - odd - found[0]]
            what = (
                f"Its shape is round about {axle}. It has {given[k]:.4g} kg m^2 about {axle} and "
            )
            what += f"about {across}, and {given[odd]:.4g} about {'xyz'[odd]}: across its axle the "
            what += "moments of inertia of what is round are alike."
            yield Remark("inertia in another order", body.name, what, ("Body", body.name))


def _speeds(subject: Subject) -> Iterator[Remark]:
    """Yield the wheels that would burst at the limit of their speed."""
    for body in subject.system.bodies:
        found = _wheel(subject, body)
        for c in subject.plain if found else ():
            own = f"{c.name}" in subject.moving(body.frame)
            turns = own and c == getattr(body.frame.motions[-1], "angle", None)
            power = (
                math.isfinite(c.speed) and math.log10(c.speed).is_integer()
            )  # stands for no limit
            if (
                found
                and turns
                and math.isfinite(c.speed)
                and c.speed * found[1] > BURSTING
                and not power
            ):
                what = f"At its limit of {c.speed:g} rad/s the rim of {body.name} goes at "
                what += (
                    f"{c.speed * found[1]:.3g} m/s, and a disk of steel bursts at {BURSTING:g}: is "
                )
                what += f"it in turns a minute, which would be {c.speed * math.pi / 30:.4g} rad/s?"
                yield Remark("speed too large", c.name, what, ("angle", c.name))


def _density(subject: Subject, body: Body) -> Iterator[Remark]:
    """Compare a body's mass with what its shapes would weigh, made of something."""
    mass = subject.system.number(body.mass)
    volume = sum(map(_volume, subject.system.resolved_shapes(body)))
    if not (mass > 0 and volume > 0):
        return
    density = mass / volume
    told = f"{in_digits(mass)} kg in {volume:.3g} m^3 are {in_digits(density)} kg/m^3"
    # A mass in g, or one of three lengths in mm, is a factor of 1e3; shapes may leave parts out.
    if density > 5 * DENSEST:
        what = (
            f"{told}, and osmium, the densest metal, has {DENSEST:.5g}: is its mass in kg and not "
        )
        what += f"in g ({in_digits(mass / 1e3)} kg), are its sizes in m?"
        yield Remark("mass too large", body.name, what, ("Body", body.name))
    elif density < 0.1 * AIR:  # boxes around propellers hold little else than air
        what = f"{told}, far less than air ({AIR:g}): are its sizes in m and not in mm or cm, is "
        what += "its mass in kg?"
        yield Remark("mass too small", body.name, what, ("Body", body.name))


def _volume(shape: Shape) -> float:
    """Return the volume of a shape in [m^3], by the divergence theorem over its triangles."""
    points, faces = triangles(shape)
    a, b, c = (points[np.asarray(faces)[:, k]] - np.mean(points, axis=0) for k in range(3))
    return float(np.abs(np.einsum("ij,ij->i", a, np.cross(b, c))).sum() / 6)


def _length(subject: Subject, body: Body) -> Iterator[Remark]:
    """Compare a body's length, and the circle on which an angle moves it, with what there is.

    A bar that is held at one end bends under its weight by L^4 g rho / (2 E r^2).

    Source: Gere, Mechanics of Materials, 6th ed., 2004, appendix G, table G-1.
    """
    slopes = subject.poses_by(subject.rest)[subject.place_of(body), :, 3]
    for c, k in subject.plain.items():
        if c.unit == "rad" and (arm := float(np.linalg.norm(slopes[:, k]))) > LONGEST:
            what = f"{c.name} moves it on a circle of {arm:.4g} m: lengths are in m, not in mm or "
            what += "cm. Is one of those in its frame too large?"
            yield Remark("size too large", body.name, what, ("Body", body.name))
            return
    corners = _corners(subject, body)
    if not (corners and subject.moving(body.frame)):
        return  # what stands still may be a floor
    largest = float(np.ptp(np.vstack(corners), axis=0).max())
    half = float(np.sort(np.ptp(np.vstack(corners), axis=0))[1]) / 2
    bends = (
        math.inf if subject.system.gravity is None else (2 * STIFFEST * half**2 / 9.81) ** (1 / 3)
    )
    if largest > min(LONGEST, bends):
        what = f"Its shape is {largest:.5g} m long"
        what += f" and {2 * half:.3g} m wide, and bends by its length" * (largest <= LONGEST)
        what += ": lengths are in m, not in mm or cm."
        yield Remark("size too large", body.name, what, ("Body", body.name))


def _angles(subject: Subject) -> Iterator[Remark]:
    """Yield constant angles of more than a turn, in rotations, sines and cosines."""
    system, told = subject.system, set[str]()
    rotations = [
        (("Body", body.name), body.name, f"rot_{motion.axis}", motion.angle)
        for body in system.bodies
        for motion in body.frame.motions
        if isinstance(motion, Rotation)
    ]
    for part, about, word, angle in [*rotations, *_trigonometry(subject)]:
        value = _constant(subject, angle)
        if value is not None and abs(value) > TURN + 1e-9 and f"{word}({angle})" not in told:
            told.add(f"{word}({angle})")
            stated = str(angle) if angle.is_number else f"{angle}, with {value:g} in it"
            what = f"{word}({stated}) is {value:g} rad, more than a whole turn. Angles are in rad: "
            what += f"{value:g} degrees are {value:g} * pi / 180 = {math.radians(value):.4g} rad."
            yield Remark("degrees", about, what, part)
    for parameter in system.parameters:
        if parameter.unit.lower() in {"deg", "degree", "degrees", "°"}:
            what = f"Its unit is {parameter.unit!r}, and angles are in rad: convert it, value * pi "
            what += "/ 180, where it is declared."
            yield Remark("degrees", parameter.name, what, ("parameter", parameter.name))


def _trigonometry(subject: Subject) -> Iterator[tuple[tuple[str, str], str, str, sympy.Expr]]:
    """Yield the arguments of sines and cosines with their parts' words and names."""
    system = subject.system
    stated: list[tuple[tuple[str, str], str, list[Any]]] = [
        (("Body", b.name), b.name, [e for m in b.frame.motions for e in getattr(m, "by", ())])
        for b in system.bodies
    ]
    stated += [(("zero", c.name), c.name, [c.stated]) for c in system.constraints]
    stated += [
        ((type(effort).__name__, ""), str(effort), [*energies_in(effort),
         *(load.magnitude for load in loads_in(effort))])
        for effort in system.efforts
    ]  # fmt: skip
    for part, about, expressions in stated:
        for entry in parts_of(tuple(map(exact, expressions))):
            if isinstance(entry, sympy.sin | sympy.cos | sympy.tan):
                yield part, about, type(entry).__name__, entry.args[0]


def _constant(subject: Subject, angle: sympy.Expr) -> float | None:
    """Return the constant part of an angle in [rad], where coordinates are 0; None of no number."""
    stated = exact(angle)
    if not all(isinstance(s, Coordinate | Parameter) for s in stated.free_symbols):
        return None
    zeros = {s: 0 for s in stated.free_symbols if isinstance(s, Coordinate)}
    try:
        return subject.system.number(stated.subs(zeros))
    except (TypeError, ValueError):
        return None


def _limits(subject: Subject) -> Iterator[Remark]:
    """Yield angles, and inputs, whose limits are whole numbers as one has them in degrees.

    A flat wheel may well turn a few times about its axle.
    """
    turned = {body.frame.motions[-1]: found for body in subject.system.bodies
              if body.frame.motions and (found := _wheel(subject, body))}  # fmt: skip
    axles = {getattr(motion, "angle", None) for motion, (k, radius, width) in turned.items()
             if width <= radius and getattr(motion, "axis", "") == "xyz"[k]}  # fmt: skip
    free = (c for c in subject.plain if c not in axles)
    limited = [("angle", c.name, c.unit, (c.lower, c.upper)) for c in free]
    inputs = zip(subject.system.inputs, subject.model.control_bounds, strict=True)
    limited += [(type(e).__name__, e.name, e.unit, tuple(ends)) for e, ends in inputs]
    for word, name, unit, limits in limited:
        ends = [end for end in limits if math.isfinite(end) and end]
        if unit == "rad" and ends and all(abs(end) in DEGREES for end in ends):
            what = f"Its limits are {limits[0]:g} and {limits[1]:g} rad, more than a whole turn. "
            what += "Limits are in rad: 90 degrees are pi / 2."
            yield Remark("degrees", name, what, (word, name))


def _gravity(subject: Subject) -> Iterator[Remark]:
    """Compare gravity's direction with the ground, and its strength with that of planets."""
    gravity = subject.system.gravity
    if gravity is None:
        return
    strength, part = subject.system.number(gravity.strength), ("toward", "")
    standing = [b.name for b in subject.system.bodies if b.touches_ground]
    upward = gravity.down[2] > 1 - ROUNDING  # oblique gravity stands for an inclined plane
    aside = abs(gravity.down[2]) < ROUNDING
    idle = aside and not any(
        np.abs(np.array(gravity.down, dtype=float) @ subject.poses_by(x)[:, :, 3]).max() > ROUNDING
        for x in random_states(subject.model)
    )
    if upward or (aside and (standing or idle)):
        way = direction_of(gravity)
        what = f"It pulls toward {way}, and the ground is the plane z = 0 with z up"
        what += f", on which {standing[0]} stands" if standing else ""
        what += ". No body moves along it, so that it does nothing" * idle
        what += ': it is toward("-z").'
        title = "gravity points up" if upward else "gravity points aside"
        yield Remark(title, "", what, part)
    elif gravity.down[1] > 1 - ROUNDING and _planar(subject):
        what = "It pulls toward +y, the way that is up in a plane of x and y: "
        what += 'it is toward("-y") there.'
        yield Remark("gravity points up", "", what, part)
    if strength and not WEAKEST <= strength <= STRONGEST:
        what = f"Its strength is {strength:g} m/s^2, and that of the earth is 9.81 m/s^2."
        yield Remark("gravity of another size", "", what, part)


def _planar(subject: Subject) -> bool:
    """Whether all bodies move in the plane of x and y, in which y is up."""
    x = subject.rest
    return not any(
        np.abs(subject.spin(body, x)[:2]).max(initial=0.0) > ROUNDING
        or np.abs(subject.poses_by(x)[k, 2, 3]).max(initial=0.0) > ROUNDING
        for k, body in enumerate(subject.system.bodies)
    )


def direction_of(gravity: Gravity) -> str:
    """Return which way gravity pulls: ``-z``, or the components of an oblique direction."""
    along = [(axis, part) for axis, part in zip("xyz", gravity.down, strict=True) if part]
    if len(along) != 1:
        return f"({', '.join(f'{part:.3g}' for part in gravity.down)})"
    return f"{'-' if along[0][1] < 0 else '+'}{along[0][0]}"

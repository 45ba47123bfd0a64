"""Answers that students hand in: wrong ones are refused, right ones in another form are accepted.

A wrong answer is named by what its author misunderstood, a right one by its form. Wrong ones must
be refused for the values that they return, not because they crash; where the reason is another
one, it is given. Chapter 3 has its answers in ``test_exercises``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from math import (
    acosh,
    asin,
    atan,
    atan2,
    comb,
    cos,
    degrees,
    exp,
    factorial,
    hypot,
    inf,
    log,
    pi,
    radians,
    remainder,
    sin,
    sqrt,
    tan,
)
from typing import Any

import numpy as np
import pytest
import sympy
from scipy.linalg import schur, solve_continuous_lyapunov
from scipy.spatial.transform import Rotation
from scipy.stats import binom

from kinolab.dynamics import (
    Body,
    Control,
    Force,
    Mode,
    Potential,
    System,
    Transition,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)
from kinolab.testing import check
from kinolab.testing.answers.answers_from_afar import judging, mark_from_afar
from kinolab.testing.exercises import exercises, judged

MACHINES = ("2.3", "4.3", "11.2", "12.2")  # their answers are described when their turn comes
REASONS = {  # patterns of why most wrong answers are refused, where it is not a value
    "2.3": "the acceleration of (alpha|beta)",
    "4.3": "the acceleration of (psi|phi)",
    "9.3": "there is a shorter one",
    "11.2": "s it is at",
    "12.2": "the acceleration of theta",
}

RIGHT: dict[str, dict[str, Any]] = {}
WRONG: dict[str, dict[str, Any]] = {}


@dataclass(frozen=True)
class Because:
    """A wrong answer that is refused for another reason than most, of which this is a pattern."""

    reason: str
    answer: Any


# 1.1, the distance on a torus with weights 1 and 0.5


def wrapped_once(difference: float) -> float:
    return min(abs(difference), 2 * pi - abs(difference))


RIGHT["1.1"] = {
    "angles by atan2": lambda a, b, c, d: hypot(
        atan2(sin(c - a), cos(c - a)), atan2(sin(d - b), cos(d - b)) / 2
    ),
    "NumPy, modulo a turn": lambda a, b, c, d: np.linalg.norm(
        [1.0, 0.5] * ((np.array([c - a, d - b]) + pi) % (2 * pi) - pi)
    ),
}
WRONG["1.1"] = {
    "no wrap": lambda a, b, c, d: hypot(c - a, 0.5 * (d - b)),
    "modulo a turn, never the short way": lambda a, b, c, d: hypot(
        (c - a) % (2 * pi), 0.5 * ((d - b) % (2 * pi))
    ),
    "wound up by a turn at most": lambda a, b, c, d: hypot(
        wrapped_once(c - a), 0.5 * wrapped_once(d - b)
    ),
    "the wrap after the subtraction of wrapped lengths": lambda a, b, c, d: hypot(
        abs(remainder(c, 2 * pi)) - abs(remainder(a, 2 * pi)),
        0.5 * (abs(remainder(d, 2 * pi)) - abs(remainder(b, 2 * pi))),
    ),
    "the weight outside of the square": lambda a, b, c, d: sqrt(
        remainder(c - a, 2 * pi) ** 2 + 0.5 * remainder(d - b, 2 * pi) ** 2
    ),
    "sum instead of root of squares": lambda a, b, c, d: (
        abs(remainder(c - a, 2 * pi)) + 0.5 * abs(remainder(d - b, 2 * pi))
    ),
    "weights of the joints exchanged": lambda a, b, c, d: hypot(
        0.5 * remainder(c - a, 2 * pi), remainder(d - b, 2 * pi)
    ),
    "angles in degrees": lambda a, b, c, d: hypot(
        remainder(c - a, 360), 0.5 * remainder(d - b, 360)
    ),
}

# 1.2, the angle between two attitudes, of which both signs of a quaternion are the same


def between(p: Any, other: Any) -> Any:
    return Rotation.from_quat(p).inv() * Rotation.from_quat(other)


RIGHT["1.2"] = {
    "by SciPy's rotations": lambda p, q: between(p, q).magnitude(),
    "by chords": lambda p, q: 4 * asin(min(np.linalg.norm(p - q), np.linalg.norm(p + q)) / 2),
}
WRONG["1.2"] = {
    "angle between the quaternions, no factor 2": lambda p, q: np.arccos(abs(p @ q)),
    "q and -q taken for two attitudes": lambda p, q: 2 * np.arccos(p @ q),
    "product without the inverse": lambda p, q: (
        Rotation.from_quat(p) * Rotation.from_quat(q)
    ).magnitude(),
    "length of the chord": lambda p, q: min(np.linalg.norm(p - q), np.linalg.norm(p + q)),
    "in degrees": lambda p, q: np.degrees(between(p, q).magnitude()),
}

# 1.3, half the angle of the directions in which a link touches a disk


def shadow(
    d: float, r: float, link: float, covered: Any = pi, beyond: Any = 0.0, side: Any = asin
) -> Any:
    if d <= r:
        return covered
    if link < d - r:
        return beyond
    if link >= sqrt(d**2 - r**2):
        return side(r / d)
    return np.arccos((d**2 + link**2 - r**2) / (2 * d * link))


def shadow_of_reach(d: float, r: float, link: float) -> Any:
    """The case of the tip is taken wherever the link does not reach the centre."""
    if d <= r or link < d - r:
        return shadow(d, r, link)
    return asin(r / d) if link >= d else np.arccos((d**2 + link**2 - r**2) / (2 * d * link))


def shadow_of_half_angles(d: float, r: float, link: float) -> float:
    """The tip by the half-angle formula, and all cases by the place where the link touches."""
    if d <= r:
        return pi
    reach = min(link, sqrt((d - r) * (d + r)))
    return 2 * asin(sqrt(max(r**2 - (d - reach) ** 2, 0.0) / (4 * d * reach)))


RIGHT["1.3"] = {
    "half-angle formula for all cases": shadow_of_half_angles,
    "side case by atan2": lambda d, r, link: shadow(
        d, r, link, side=lambda _: atan2(r, sqrt(d**2 - r**2))
    ),
}
WRONG["1.3"] = {
    "covered origin taken for a half turn": partial(shadow, covered=pi / 2),
    "a link that is too short touches straight ahead": lambda d, r, link: shadow(
        d, r, link, beyond=asin(min(r / d, 1.0))
    ),
    "tangent of the angle instead of its sine": partial(shadow, side=atan),
    "link ends at the centre, not at the tangent point": shadow_of_reach,
    "infinite link": lambda d, r, _: pi if d <= r else asin(r / d),
    "the whole angle instead of its half": lambda d, r, link: min(2 * shadow(d, r, link), pi),
    "in degrees": lambda d, r, link: degrees(shadow(d, r, link)),
}

# 2.1, body velocity


def vee(matrix: Any) -> list[float]:
    return [*matrix[:3, 3], matrix[2, 1], matrix[0, 2], matrix[1, 0]]


def by_axes(g: Any, g_dot: Any) -> tuple[Any, Any]:
    """Linear and angular velocity; twice the latter is the sum of axis x rate over the axes."""
    axes = g[:3, :3]
    return axes.T @ g_dot[:3, 3], axes.T @ np.cross(axes.T, g_dot[:3, :3].T).sum(axis=0) / 2


RIGHT["2.1"] = {
    "solve instead of the inverse": lambda g, g_dot: np.array(vee(np.linalg.solve(g, g_dot))),
    "transpose, for the last row of the derivative is 0": lambda g, g_dot: vee(g.T @ g_dot),
    "turning by its axes": lambda g, g_dot: np.hstack(by_axes(g, g_dot)),
}
WRONG["2.1"] = {
    "spatial velocity, the other order": lambda g, g_dot: vee(g_dot @ np.linalg.inv(g)),
    "along the world's axes": lambda g, g_dot: [*g_dot[:3, 3], *vee(g_dot @ np.linalg.inv(g))[3:]],
    "linear part along the world's axes": lambda g, g_dot: [
        *g_dot[:3, 3],
        *vee(np.linalg.inv(g) @ g_dot)[3:],
    ],
    "matrix instead of its inverse": lambda g, g_dot: vee(g @ g_dot),
    "other triangle of the skew matrix": lambda g, g_dot: (
        vee(np.linalg.inv(g) @ g_dot)[:3] + [-entry for entry in vee(np.linalg.inv(g) @ g_dot)[3:]]
    ),
    "angular part first": lambda g, g_dot: np.roll(vee(np.linalg.inv(g) @ g_dot), 3),
    "a pair of vectors": Because("shape", by_axes),
}

# 2.2, a trailer


def trailer(x: float, y: float, psi: float, beta: float, hitch: float = -0.5) -> Any:
    return (
        x + hitch * cos(psi) - 1.2 * cos(psi + beta),
        y + hitch * sin(psi) - 1.2 * sin(psi + beta),
        psi + beta,
    )


def rot(turn: float) -> Any:
    return np.array([[cos(turn), -sin(turn), 0.0], [sin(turn), cos(turn), 0.0], [0.0, 0.0, 1.0]])


def shift(along: float, aside: float = 0.0) -> Any:
    return np.array([[1.0, 0.0, along], [0.0, 1.0, aside], [0.0, 0.0, 1.0]])


def of_product(g: Any) -> list[float]:
    return [g[0, 2], g[1, 2], atan2(g[1, 0], g[0, 0])]


RIGHT["2.2"] = {
    "product of matrices, heading by atan2": lambda x, y, psi, beta: of_product(
        shift(x, y) @ rot(psi) @ shift(-0.5) @ rot(beta) @ shift(-1.2)
    ),
    "an array": lambda *pose: np.array(trailer(*pose)),
}
WRONG["2.2"] = {
    "hitch ahead of the axle": partial(trailer, hitch=0.5),
    "no hitch": partial(trailer, hitch=0.0),
    "beta taken for the trailer's heading": lambda x, y, psi, beta: (
        x - 0.5 * cos(psi) - 1.2 * cos(beta),
        y - 0.5 * sin(psi) - 1.2 * sin(beta),
        beta,
    ),
    "beta turns the other way": lambda x, y, psi, beta: trailer(x, y, psi, -beta),
    "turned before the hitch was reached": lambda x, y, psi, beta: of_product(
        shift(x, y) @ rot(psi) @ rot(beta) @ shift(-0.5) @ shift(-1.2)
    ),
    "turned about the world's origin": lambda x, y, psi, beta: of_product(
        rot(psi) @ shift(x, y) @ shift(-0.5) @ rot(beta) @ shift(-1.2)
    ),
    "heading of the car returned": lambda *pose: (*trailer(*pose)[:2], pose[2]),
}

# 2.3, a rod on a universal joint

ALPHA, BETA = angle("alpha"), angle("beta")
THIN = (2.0 / 12, 2.0 / 12, 0)


def rod(frame: Any, inertia: Any = THIN) -> System:
    body = Body("bar", frame, mass=2.0, inertia=inertia)
    return System("rod", bodies=[body], gravity=toward("-z", 9.81))


def hanging(along: float = -0.5) -> Any:
    return rot_z(ALPHA) @ rot_y(BETA) @ move(0, 0, along)


def rod_of_parameters() -> System:
    m, size = parameter("m", 2.0, "kg"), parameter("l", 1.0, "m")
    across = m * size**2 / 12
    body = Body("bar", hanging(-size / 2), mass=m, inertia=(across, across, 0))
    return System("rod", bodies=[body], gravity=toward("-z", 9.81))


RIGHT["2.3"] = {
    "rod along the body's x axis": lambda: rod(
        rot_z(ALPHA) @ rot_y(BETA) @ rot_y(pi / 2) @ move(0.5, 0, 0), (0, 2.0 / 12, 2.0 / 12)
    ),
    "mass and length are parameters": rod_of_parameters,
}
WRONG["2.3"] = {
    "all mass at the centre": lambda: rod(hanging(), 0),
    "all mass at the end": lambda: rod(hanging(-1.0), 0),
    "inertia about the end, counted twice": lambda: rod(hanging(), (2.0 / 3, 2.0 / 3, 0)),
    "inertia without the mass": lambda: rod(hanging(), (1.0 / 12, 1.0 / 12, 0)),
    "inertia about its own axis too": lambda: rod(hanging(), 2.0 / 12),
    "frame at the end": lambda: rod(hanging(-1.0)),
    "stands up": lambda: rod(hanging(0.5)),
    "factors in the other order": Because(
        "resists a motion of alpha", lambda: rod(rot_y(BETA) @ rot_z(ALPHA) @ move(0, 0, -0.5))
    ),
    "moved before it is turned": lambda: rod(move(0, 0, -0.5) @ rot_z(ALPHA) @ rot_y(BETA)),
    "beta swings the other way": Because(
        "centre of mass", lambda: rod(rot_z(ALPHA) @ rot_y(-BETA) @ move(0, 0, -0.5))
    ),
    "alpha turns the other way": Because(
        "centre of mass", lambda: rod(rot_z(-ALPHA) @ rot_y(BETA) @ move(0, 0, -0.5))
    ),
    "swings about x": Because(
        "centre of mass", lambda: rod(rot_z(ALPHA) @ rot_x(BETA) @ move(0, 0, -0.5))
    ),
}

# 4.1, the turn rate at which the rim slides

RIGHT["4.1"] = {
    "three significant digits": 3.92,
    "as a NumPy number": np.float64(0.6 * 9.81) / 1.5,
}
WRONG["4.1"] = {
    "centripetal force of the wheel, not of the path": sqrt(0.6 * 9.81 / 0.25),
    "radius of the path": 1.5**2 / (0.6 * 9.81),
    "without gravity": 0.6 / 1.5,
    "in degrees": degrees(0.6 * 9.81 / 1.5),
    "friction shared between both directions": 0.6 * 9.81 / 1.5 / sqrt(2.0),
}

# 4.2, accelerations and multipliers


def multiplied(M: Any, f: Any, w: Any, bend: Any, sign: float = 1.0, bend_sign: float = 1.0) -> Any:
    inverse = np.linalg.inv(M)
    force = -np.linalg.solve(w @ inverse @ w.T, w @ inverse @ f + bend_sign * bend)
    return np.concatenate([inverse @ (f + w.T @ force), sign * force])


def in_place(M: Any, f: Any, w: Any, bend: Any) -> Any:
    """Right, and writes over what it is given."""
    bend += w @ np.linalg.solve(M, f)
    force = np.linalg.solve(w @ np.linalg.solve(M, w.T), -bend)
    f += w.T @ force
    return np.hstack([np.linalg.solve(M, f), force])


def of_all_equations(M: Any, f: Any, w: Any, bend: Any) -> list[float]:
    """With the symmetric matrix, whose unknowns are the negative multipliers."""
    n, k = len(f), len(bend)
    matrix = np.block([[M, w.T], [w, np.zeros((k, k))]])
    solved = np.linalg.solve(matrix, [*f, *-bend])
    return [*solved[:n], *-solved[n:]]


RIGHT["4.2"] = {
    "all equations at once, a list": of_all_equations,
    "writes over its arguments": in_place,
}
WRONG["4.2"] = {
    "multipliers with the other sign": partial(multiplied, sign=-1.0),
    "the constraint does not turn": partial(multiplied, bend_sign=0.0),
    "its turning with the other sign": partial(multiplied, bend_sign=-1.0),
    "multipliers first": lambda M, f, w, bend: np.roll(multiplied(M, f, w, bend), len(bend)),
    "accelerations without the constraints": lambda M, f, w, bend: np.concatenate(
        [np.linalg.solve(M, f), multiplied(M, f, w, bend)[len(f) :]]
    ),
    "masses left out": lambda _, f, w, bend: multiplied(np.eye(len(f)), f, w, bend),
    "accelerations only": Because(
        "shape", lambda M, f, w, bend: multiplied(M, f, w, bend)[: len(f)]
    ),
    "two arrays": Because(
        "one array", lambda M, f, w, bend: np.split(multiplied(M, f, w, bend), [len(f)])
    ),
}

# 4.3, a coin on a slope


WEIGHT = 9.81 * sin(radians(10.0))  # of 1 kg along the table


def slope(
    weight: float = WEIGHT,
    downhill: str = "x",
    start: float = 0.0,
    rolls: float = 1.0,
    slips: bool = False,
    inertia: Any = (1 / 64, 1 / 32, 1 / 64),
) -> System:
    x, y, psi, phi = length("x"), length("y"), angle("psi"), angle("phi")
    fork = move(x, y, 0.25) @ rot_z(psi)
    coin = Body("coin", fork @ rot_y(phi), mass=1.0, inertia=inertia)
    V = velocity(fork)
    constraints = [zero(V.x - rolls * 0.25 * rate(phi), "rolling")]
    constraints += [] if slips else [zero(V.y, "no sideslip")]
    pull = Potential(-weight * ({"x": x, "y": y}[downhill] - start))
    return System("slope", bodies=[coin], constraints=constraints, efforts=[pull])


def slope_of_force() -> System:
    """The weight's part along the table, as a force in the axes of the spinning coin."""
    x, y, psi, phi = length("x"), length("y"), angle("psi"), angle("phi")
    fork = move(x, y, 0.25) @ rot_z(psi)
    coin = Body("coin", fork @ rot_y(phi), mass=1.0, inertia=(1 / 64, 1 / 32, 1 / 64))
    V = velocity(fork)
    ahead, side = WEIGHT * sympy.cos(psi), -WEIGHT * sympy.sin(psi)
    pull = (sympy.cos(phi) * ahead, side, sympy.sin(phi) * ahead)
    return System(
        "slope",
        bodies=[coin],
        constraints=[zero(V.y, "no sideslip"), zero(V.x - rate(phi) / 4, "rolling")],
        efforts=[Wrench(on=coin, force=pull)],
    )


RIGHT["4.3"] = {
    "a force instead of a potential": slope_of_force,
    "potential counted from elsewhere": lambda: slope(start=3.0),
}
WRONG["4.3"] = {
    "potential with the sign of the work": lambda: slope(-WEIGHT),
    "cosine of the slope": lambda: slope(9.81 * cos(radians(10.0))),
    "slope in degrees": lambda: slope(9.81 * sin(10.0)),
    "downhill along y": lambda: slope(downhill="y"),
    "rolls backward": lambda: slope(rolls=-1.0),
    "diameter for radius": lambda: slope(rolls=2.0),
    "may slip aside": lambda: slope(slips=True),
    "a hoop's inertia": lambda: slope(inertia=(1 / 32, 1 / 16, 1 / 32)),
    "no inertia about the axle": lambda: slope(inertia=(1 / 64, 0, 1 / 64)),
}

# 5.1, the bracket of two wheels

RIGHT["5.1"] = {
    "of radius and track, an array": lambda psi: (
        0.1**2 / 0.4 * np.array([np.sin(psi), -np.cos(psi), 0])
    ),
    "a cross product": lambda psi: 0.05 * 0.25 * 2 * np.cross([cos(psi), sin(psi), 0], [0, 0, 1]),
}
WRONG["5.1"] = {
    "the other order": lambda psi: [-0.025 * sin(psi), 0.025 * cos(psi), 0],
    "one of two terms": lambda psi: [0.0125 * sin(psi), -0.0125 * cos(psi), 0],
    "sum of both terms": lambda _: [0, 0, 0],
    "at the heading 0 only": lambda _: [0, -0.025, 0],
    "along the heading": lambda psi: [0.025 * cos(psi), 0.025 * sin(psi), 0],
    "diameter for radius": lambda psi: [0.1 * sin(psi), -0.1 * cos(psi), 0],
}

# 5.2, growth vectors of a train

RIGHT["5.2"] = {
    "lists": [[2, 3, 4, 5], [2, 3, 4, 4, 5]],
    "arrays": (np.array([2, 3, 4, 5]), np.array([2, 3, 4, 4, 5])),
}
WRONG["5.2"] = {
    "right angle in degrees, which is no right angle": ((2, 3, 4, 5), (2, 3, 4, 5)),
    "exchanged": ((2, 3, 4, 4, 5), (2, 3, 4, 5)),
    "what each step adds": ((2, 1, 1, 1), (2, 1, 1, 0, 1)),
    "one trailer": ((2, 3, 4), (2, 3, 3, 4)),
    "right angle at the second trailer, and never full": ((2, 3, 4, 5), (2, 3, 4, 4)),
    "the ordinary one only": Because("two tuples", (2, 3, 4, 5)),
    "number of steps": Because("two tuples", (4, 5)),
}

# 5.3, backing up along two arcs


def aside(d: float, steering: float, arcs: float = 2.0, bend: Any = tan) -> Any:
    curvature = bend(steering) / 2.7
    return arcs * (1.0 - cos(curvature * d)) / curvature


def two_arcs(d: float, steering: float) -> float:
    place, heading = 0j, 1.0 + 0j
    for turned in (steering, -steering):
        radius = 2.7 / tan(turned)
        onward = heading * np.exp(-1j * d / radius)
        place += (onward - heading) * radius / 1j
        heading = onward
    return float(place.imag)


RIGHT["5.3"] = {
    "half-angle formula": lambda d, steering: (
        4 * (2.7 / tan(steering)) * sin(tan(steering) * d / 2 / 2.7) ** 2
    ),
    "two arcs of a circle in the complex plane": two_arcs,
}
WRONG["5.3"] = {
    "only to second order": lambda d, steering: d**2 * tan(steering) / 2.7,
    "first arc only": partial(aside, arcs=1.0),
    "to the other side": lambda d, steering: -aside(d, steering),
    "always to the left": lambda d, steering: abs(aside(d, steering)),
    "one long arc": lambda d, steering: aside(2 * d, steering, arcs=1.0),
    "wheelbase is the radius of the front wheel": partial(aside, bend=sin),
    "steering in degrees": lambda d, steering: aside(d, radians(steering)),
    "distance along instead of aside": lambda d, steering: (
        2 * sin(tan(steering) / 2.7 * d) / (tan(steering) / 2.7)
    ),
}

# 6.1, a coin that reverses


def reversing(x1: float, y1: float, x2: float, y2: float) -> Any:
    psi = atan2(y1, x1) + pi
    v = x1 * cos(psi) + y1 * sin(psi)
    return [cos(psi), sin(psi), v, (y2 * cos(psi) - x2 * sin(psi)) / v]


RIGHT["6.1"] = {
    "heading by atan2, a list": reversing,
    "an array": lambda x1, y1, x2, y2: np.array(
        [
            -x1 / hypot(x1, y1),
            -y1 / hypot(x1, y1),
            -hypot(x1, y1),
            (x1 * y2 - x2 * y1) / (x1**2 + y1**2),
        ]
    ),
}
WRONG["6.1"] = {
    "forward": lambda x1, y1, x2, y2: (
        x1 / hypot(x1, y1),
        y1 / hypot(x1, y1),
        hypot(x1, y1),
        (x1 * y2 - y1 * x2) / hypot(x1, y1) ** 2,
    ),
    "heading along the velocity": lambda *case: (
        -reversing(*case)[0],
        -reversing(*case)[1],
        *reversing(*case)[2:],
    ),
    "speed without its sign": lambda *case: (
        *reversing(*case)[:2],
        -reversing(*case)[2],
        reversing(*case)[3],
    ),
    "turns the other way in reverse": lambda *case: (*reversing(*case)[:3], -reversing(*case)[3]),
    "curvature for turn rate": lambda *case: (
        *reversing(*case)[:3],
        reversing(*case)[3] / reversing(*case)[2],
    ),
    "lateral acceleration for turn rate": lambda *case: (
        *reversing(*case)[:3],
        reversing(*case)[3] * reversing(*case)[2],
    ),
}

# 6.2, a crane from its load


def crane(
    X: float, Z: float, theta: float, height: float = 9.0, toward_trolley: float = -1.0
) -> tuple[float, float, float]:
    rope = (height - Z) / cos(theta)
    return theta, rope, X + toward_trolley * rope * sin(theta)


RIGHT["6.2"] = {
    "angle by atan2": lambda X, Z, X2, Z2: list(crane(X, Z, atan2(-X2, Z2 + 9.81))),
    "rope by Pythagoras": lambda X, Z, X2, Z2: np.array(
        [
            -atan(X2 / (9.81 + Z2)),
            hypot(9 - Z, (9 - Z) * X2 / (9.81 + Z2)),
            X + (9 - Z) * X2 / (9.81 + Z2),
        ]
    ),
}
WRONG["6.2"] = {
    "leans into the acceleration": lambda X, Z, X2, Z2: crane(X, Z, atan(X2 / (Z2 + 9.81))),
    "vertical acceleration left out": lambda X, Z, X2, _: crane(X, Z, -atan(X2 / 9.81)),
    "gravity with the other sign": lambda X, Z, X2, Z2: crane(X, Z, -atan(X2 / (9.81 - Z2))),
    "tangent upside down": lambda X, Z, X2, Z2: crane(X, Z, -atan2(Z2 + 9.81, X2)),
    "small angles": lambda X, Z, X2, Z2: crane(X, Z, -X2 / (Z2 + 9.81)),
    "rope hangs to the floor": lambda X, Z, X2, Z2: crane(
        X, Z, -atan(X2 / (Z2 + 9.81)), height=0.0
    ),
    "trolley on the other side": lambda X, Z, X2, Z2: crane(
        X, Z, -atan(X2 / (Z2 + 9.81)), toward_trolley=1.0
    ),
    "in degrees": lambda X, Z, X2, Z2: (
        -degrees(atan(X2 / (Z2 + 9.81))),
        *crane(X, Z, -atan(X2 / (Z2 + 9.81)))[1:],
    ),
}

# 6.3, the shortest duration; the largest second derivative of the timing is 10 / sqrt(3)

STEEPEST = 10 / sqrt(3)
RIGHT["6.3"] = {
    "three significant digits": 2.55,
    "from samples of the timing": sqrt(
        1.5 * 0.25 * 3 * max(60 * r - 180 * r**2 + 120 * r**3 for r in np.linspace(0, 1, 2001))
    ),
}
WRONG["6.3"] = {
    "rate only": 3 * 15 / 8 / (12 * 0.25),
    "no inertia about the axle": sqrt(0.25 * 3 * STEEPEST),
    "a hoop": sqrt(2 * 0.25 * 3 * STEEPEST),
    "torque is taken for a force": sqrt(1.5 * 3 * STEEPEST),
    "diameter for radius": sqrt(1.5 * 0.5 * 3 * STEEPEST),
    "square root forgotten": 1.5 * 0.25 * 3 * STEEPEST,
    "steepest in the middle": sqrt(1.5 * 0.25 * 3 * 15 / 8),
    "sum of both": 1.875 + sqrt(1.5 * 0.25 * 3 * STEEPEST),
    "mean speed at the limit": 3 / (12 * 0.25),
}

# 7.1, the nearest state


def nearest(
    states: Any, sample: Any, weight: float, turn: Any = lambda d: (d + pi) % (2 * pi) - pi
) -> Any:
    angles = turn(states[:, 0] - sample[0])
    return np.argmin(angles**2 + (weight * (states[:, 1] - sample[1])) ** 2)


def nearest_of_loop(states: Any, sample: Any, weight: float) -> int:
    distances = [
        hypot(remainder(a - sample[0], 2 * pi), weight * (rate - sample[1])) for a, rate in states
    ]
    return distances.index(min(distances))


def nearest_in_place(states: Any, sample: Any, weight: float) -> Any:
    """Right, and writes over what it is given."""
    states -= sample
    states[:, 0] = np.arctan2(np.sin(states[:, 0]), np.cos(states[:, 0]))
    states[:, 1] *= weight
    return np.linalg.norm(states, axis=1).argmin()


RIGHT["7.1"] = {
    "a loop": nearest_of_loop,
    "writes over its arguments": nearest_in_place,
}
WRONG["7.1"] = {
    "no wrap": partial(nearest, turn=lambda d: d),
    "modulo a turn, never the short way": partial(nearest, turn=lambda d: d % (2 * pi)),
    "wound up by a turn at most": partial(
        nearest, turn=lambda d: np.minimum(abs(d), 2 * pi - abs(d))
    ),
    "sine of the difference": partial(nearest, turn=np.sin),
    "chord for arc": partial(nearest, turn=lambda d: 2 * np.sin(d / 2)),
    "a turn is 360": partial(nearest, turn=lambda d: (d + 180) % 360 - 180),
    "weight forgotten": lambda states, sample, _: nearest(states, sample, 1.0),
    "weight divides": lambda states, sample, weight: nearest(states, sample, 1 / weight),
    "angles only": lambda states, sample, _: nearest(states, sample, 0.0),
    "the state instead of its row": Because(
        "shape", lambda states, sample, weight: states[nearest(states, sample, weight)]
    ),
}

# 7.2, fewer than k successes

RIGHT["7.2"] = {
    "what is left of the others": lambda n, p, k: (
        1 - sum(comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(k, n + 1))
    ),
    "sum of probabilities": lambda n, p, k: np.sum(binom.pmf(np.arange(k), n, p)),
}
WRONG["7.2"] = {
    "k included": lambda n, p, k: binom.cdf(k, n, p),
    "exactly k": lambda n, p, k: binom.pmf(k, n, p),
    "no success at all": lambda n, p, _: (1 - p) ** n,
    "success instead of failure": lambda n, p, k: 1 - binom.cdf(k - 1, n, p),
    "failures and successes exchanged": lambda n, p, k: binom.cdf(k - 1, n, 1 - p),
    "order of the successes is fixed": lambda n, p, k: sum(
        p**i * (1 - p) ** (n - i) for i in range(k)
    ),
    "limit of rare events": lambda n, p, k: (
        exp(-n * p) * sum((n * p) ** i / factorial(i) for i in range(k))
    ),
}

# 7.3, extend


def extend(
    state: Any,
    target: Any,
    free: Any = lambda way: max(way) < 2,
    half: float = 0.5,
    misses: Any = lambda x, v: x**2 + v**2,
    held: float = 0.5,
) -> Any:
    x, v = state
    t = np.linspace(0, held, 201)
    ends = [
        (x + v * held + half * a * held**2, v + a * held)
        for a in (-4.0, -1.0, 0.0, 1.0)
        if free(x + v * t + half * a * t**2)
    ]
    return min(ends, key=lambda end: misses(end[0] - target[0], end[1] - target[1]))


def extend_by_apex(state: Any, target: Any, when: Any = lambda t: 0 < t < 0.5) -> Any:
    """Where it turns round is taken for the farthest point, if that is the time to."""
    x, v = state
    ends = []
    for a in (-4.0, -1.0, 0.0, 1.0):
        end = np.array([x + 0.5 * v + 0.125 * a, v + 0.5 * a])
        apex = x - v**2 / (2 * a) if a < 0 and when(-v / a) else x
        if max(x, end[0], apex) < 2:
            ends.append(end)
    return min(ends, key=lambda end: np.linalg.norm(end - target))


RIGHT["7.3"] = {
    "where it turns round, an array": extend_by_apex,
    "way sampled, a tuple": extend,
    "distance by hypot": partial(extend, misses=hypot),
}
WRONG["7.3"] = {
    "only the end must be in front of the wall": partial(extend, free=lambda way: way[-1] < 2),
    "no wall": partial(extend, free=lambda _: True),
    "factor 1/2 forgotten": partial(extend, half=1.0),
    "Euler's step": partial(extend, half=0.0),
    "nearest in position only": partial(extend, misses=lambda x, _: x**2),
    "nearest in speed only": partial(extend, misses=lambda _, v: v**2),
    "held for one second": partial(extend, held=1.0),
    "farthest point counted at any time": partial(extend_by_apex, when=lambda _: True),
    "farthest point counted before the start": partial(extend_by_apex, when=lambda t: t < 0.5),
    "target reached in any case": lambda _, target: target,
}

# 8.1, the force of a round pillar


def push(x: float, y: float, power: float = 2.0, radius: float = 0.5, cut: bool = True) -> Any:
    away = np.array([x - 2.0, y - 1.0])
    d = np.linalg.norm(away)
    rho = d - radius
    if cut and rho >= 0.6:
        return np.zeros(2)
    return 0.02 * (1 / rho - 1 / 0.6) / rho**power * away / d


def push_of_potential(x: float, y: float, step: float = 1e-5) -> list[float]:
    """Central differences of the potential, to fourth order."""

    def potential(x: float, y: float) -> float:
        rho = min(hypot(x - 2, y - 1) - 0.5, 0.6)
        return 0.01 * (1 / rho - 1 / 0.6) ** 2

    def slope(along: Callable[[float], float]) -> float:
        near, far = along(step) - along(-step), along(2 * step) - along(-2 * step)
        return (8 * near - far) / (12 * step)

    return [-slope(lambda s: potential(x + s, y)), -slope(lambda s: potential(x, y + s))]


RIGHT["8.1"] = {
    "differences of the potential": push_of_potential,
    "by the angle from the centre": lambda x, y: (
        np.linalg.norm(push(x, y)) * np.cos(atan2(y - 1, x - 2)),
        np.linalg.norm(push(x, y)) * np.sin(atan2(y - 1, x - 2)),
    ),
}
WRONG["8.1"] = {
    "gradient instead of force": lambda x, y: -push(x, y),
    "distance to the centre": partial(push, radius=0.0),
    "diameter for radius": partial(push, radius=0.25),
    "reaches everywhere": partial(push, cut=False),
    "inner derivative forgotten": partial(push, power=0.0),
    "a power too many": partial(push, power=3.0),
    "half of it, as in the potential": lambda x, y: push(x, y) / 2,
    "direction not normalised": lambda x, y: push(x, y) * hypot(x - 2, y - 1),
    "size only": Because("shape", lambda x, y: np.linalg.norm(push(x, y))),
}

# 8.2, torques of forces at elbow and tip


def torques(
    q1: float, q2: float, *forces: float, relative: bool = True, at_elbow: float = 1.0
) -> list[float]:
    """By moments about the joints."""
    turn = q1 + q2 if relative else q2
    elbow, link = np.array([cos(q1), sin(q1)]), np.array([cos(turn), sin(turn)])
    first, second = at_elbow * np.array(forces[:2]), np.array(forces[2:])

    def moment(arm: Any, force: Any) -> float:
        return float(arm[0] * force[1] - arm[1] * force[0])

    return [moment(elbow, first) + moment(elbow + link, second), moment(link, second)]


RIGHT["8.2"] = {
    "moments about the joints": torques,
    "written out, a tuple": lambda q1, q2, ax, ay, bx, by: (
        -sin(q1) * (ax + bx) + cos(q1) * (ay + by) - sin(q1 + q2) * bx + cos(q1 + q2) * by,
        -sin(q1 + q2) * bx + cos(q1 + q2) * by,
    ),
}
WRONG["8.2"] = {
    "second angle taken from the axis x": partial(torques, relative=False),
    "torques that balance the forces": lambda *case: [-t for t in torques(*case)],
    "tip only": partial(torques, at_elbow=0.0),
    "both forces at the tip": lambda q1, q2, ax, ay, bx, by: torques(
        q1, q2, 0.0, 0.0, ax + bx, ay + by
    ),
    "forces exchanged": lambda q1, q2, ax, ay, bx, by: torques(q1, q2, bx, by, ax, ay),
    "Jacobians not transposed": lambda q1, q2, ax, ay, bx, by: (
        np.array([[-sin(q1), 0.0], [cos(q1), 0.0]]) @ [ax, ay]
        + np.array(
            [[-sin(q1) - sin(q1 + q2), -sin(q1 + q2)], [cos(q1) + cos(q1 + q2), cos(q1 + q2)]]
        )
        @ [bx, by]
    ),
    "elbow moves the second joint too": lambda q1, q2, ax, ay, bx, by: [
        torques(q1, q2, ax, ay, bx, by)[0],
        torques(q1, q2, ax, ay, bx, by)[1] - sin(q1 + q2) * ax + cos(q1 + q2) * ay,
    ],
    "positions for their derivatives": lambda q1, q2, ax, ay, bx, by: [
        cos(q1) * (ax + bx) + sin(q1) * (ay + by) + cos(q1 + q2) * bx + sin(q1 + q2) * by,
        cos(q1 + q2) * bx + sin(q1 + q2) * by,
    ],
}

# 8.3, the gap that stays


def gap(gain: float = 0.01, reach: float = 0.5) -> float:
    """Newton's method for gap^3 + gain / reach gap = gain."""
    rho = 0.3
    for _ in range(50):
        rho -= (rho**3 + gain / reach * rho - gain) / (3 * rho**2 + gain / reach)
    return rho


RIGHT["8.3"] = {"Newton's method": gap(), "three significant digits": 0.185}
WRONG["8.3"] = {
    "no distance of influence": gap(reach=inf),
    "inner derivative forgotten": 1 / (1 / 0.01 + 1 / 0.5),
    "potential 1 instead of slope 1": 1 / (1 / 0.5 + sqrt(2 / 0.01)),
    "where the repulsion begins": 0.5,
    "square of the distance left out": sqrt(0.01),
    "half of the gain": gap(0.005),
    "gain and reach of the chapter's horseshoe": gap(0.001, 0.3),
}

# 9.1, least time under a limit of acceleration and speed


def least_time(distance: float, limit: float, fastest: float, threshold: float = 1.0) -> float:
    if distance <= threshold * fastest**2 / limit:
        return 2 * sqrt(distance / limit)
    return distance / fastest + fastest / limit


RIGHT["9.1"] = {
    "by the top speed": lambda distance, limit, fastest: (
        (top := min(fastest, sqrt(limit * distance))) / limit + distance / top
    ),
    "ramps and the rest": lambda distance, limit, fastest: (
        2 * (ramp := min(fastest / limit, sqrt(distance / limit)))
        + (distance - limit * ramp**2) / fastest
    ),
}
WRONG["9.1"] = {
    "no speed limit": lambda distance, limit, _: 2 * sqrt(distance / limit),
    "always at the speed limit": partial(least_time, threshold=0.0),
    "case of one ramp": partial(least_time, threshold=0.5),
    "cases too late": partial(least_time, threshold=2.0),
    "cases exchanged": lambda distance, limit, fastest: (
        distance / fastest + fastest / limit
        if distance <= fastest**2 / limit
        else 2 * sqrt(distance / limit)
    ),
    "does not stop": lambda distance, limit, fastest: (
        sqrt(2 * distance / limit)
        if distance <= fastest**2 / limit / 2
        else distance / fastest + fastest / limit / 2
    ),
    "ramps counted as full way": lambda distance, limit, fastest: (
        2 * sqrt(distance / limit)
        if distance <= fastest**2 / limit
        else distance / fastest + 2 * fastest / limit
    ),
}

# 9.2, defects


def defects(x: Any, u: Any, h: float, half: float = 0.5) -> Any:
    s, v = x[:-1].T
    return x[1:] - np.column_stack([s + h * v + half * h**2 * u, v + h * u])


def defects_in_place(x: Any, u: Any, h: float) -> Any:
    """Right, and writes over what it is given; the last knot first."""
    for k in range(len(u), 0, -1):
        s, v = x[k - 1]
        x[k] -= [s + h * v + u[k - 1] * h**2 / 2, v + h * u[k - 1]]
    return x[1:]


RIGHT["9.2"] = {
    "product of matrices, nested lists": lambda x, u, h: (
        x[1:] - x[:-1] @ [[1, 0], [h, 1]] - np.outer(u, [h**2 / 2, h])
    ).tolist(),
    "writes over its arguments": defects_in_place,
}
WRONG["9.2"] = {
    "Euler's step": lambda x, u, h: defects(x, u, h, half=0.0),
    "factor 1/2 forgotten": lambda x, u, h: defects(x, u, h, half=1.0),
    "reached less wanted": lambda x, u, h: -defects(x, u, h),
    "knots exchanged": lambda x, u, h: defects(x[::-1], u[::-1], h),
    "steps of length 1": lambda x, u, _: defects(x, u, 1.0),
    "not of each step": Because("shape", lambda x, u, h: np.abs(defects(x, u, h)).max(axis=0)),
}

# 9.3, the best shortcuts


def farthest_first(path: Any, is_free: Any) -> list[int]:
    rows = [0]
    while rows[-1] < len(path) - 1:
        rows.append(
            max(j for j in range(rows[-1] + 1, len(path)) if is_free(path[rows[-1]], path[j]))
        )
    return rows


def best(path: Any, is_free: Any, cost: Any = lambda a, b: np.linalg.norm(b - a)) -> list[int]:
    """From the last row backward, with the rest of the way as a tuple of length and rows."""
    ways: dict[int, tuple[float, list[int]]] = {len(path) - 1: (0.0, [len(path) - 1])}
    for i in range(len(path) - 2, -1, -1):
        ways[i] = min(
            (cost(path[i], path[j]) + ways[j][0], [i, *ways[j][1]])
            for j in range(i + 1, len(path))
            if is_free(path[i], path[j])
        )
    return ways[0][1]


def dropped(path: Any, is_free: Any) -> list[int]:
    """Leave rows out one after the other wherever their neighbours see each other."""
    rows = list(range(len(path)))
    k = 1
    while k < len(rows) - 1:
        if is_free(path[rows[k - 1]], path[rows[k + 1]]):
            del rows[k]
        else:
            k += 1
    return rows


RIGHT["9.3"] = {
    "backward, a tuple": lambda path, is_free: tuple(best(path, is_free)),
    "backward, an array": lambda path, is_free: np.array(best(path, is_free)),
}
WRONG["9.3"] = {
    "as far as possible each time": farthest_first,
    "as few rows as possible": partial(best, cost=lambda *_: 1.0),
    "squares of the lengths": partial(best, cost=lambda a, b: (b - a) @ (b - a)),
    "rows left out one by one": dropped,
    "nothing left out": lambda path, _: list(range(len(path))),
    "straight through the discs": Because("not free", lambda path, _: [0, len(path) - 1]),
    "last row left out": Because("first row", lambda path, is_free: best(path, is_free)[:-1]),
    "from the last row to the first": Because(
        "increasing order", lambda path, is_free: best(path, is_free)[::-1]
    ),
    "points for their numbers": Because(
        "numbers of rows", lambda path, is_free: path[best(path, is_free)]
    ),
    "nothing returned": Because("no answer", lambda *_: None),
}

# 10.1, how long a rod takes to fall by ten degrees

GROWTH = sqrt(9.81 / 0.5)
RIGHT["10.1"] = {
    "logarithm": log(2 * 10 / 0.001) / GROWTH,
    "three significant digits": 2.24,
}
WRONG["10.1"] = {
    "half of the exponential forgotten": log(10 / 0.001) / GROWTH,
    "upside down": acosh(10 / 0.001) * GROWTH,
    "square root forgotten": acosh(10 / 0.001) / (9.81 / 0.5),
    "a rod with mass": acosh(10 / 0.001) / sqrt(1.5 * 9.81 / 0.5),
    "in degrees against radians": acosh(radians(10) / 0.001) / GROWTH,
    "of a length of 1 m": acosh(10 / 0.001) / sqrt(9.81),
    "a quarter of its period when it hangs": pi / 2 / GROWTH,
    "logarithm to base 10": np.log10(2 * 10 / 0.001) / GROWTH,
}

# 10.2, a Riccati solver


def riccati(
    A: Any,
    B: Any,
    Q: Any,
    R: Any,
    half: float = -1.0,
    weigh: Any = np.linalg.inv,
    cost: float = -1.0,
    adjoint: Any = np.transpose,
) -> Any:
    H = np.block([[A, -B @ weigh(R) @ B.T], [cost * Q, -adjoint(A)]])
    values, vectors = np.linalg.eig(H)
    chosen = vectors[:, half * values.real > 0]
    X, Y = chosen[: len(A)], chosen[len(A) :]
    return (Y @ np.linalg.pinv(X)).real


def by_schur(A: Any, B: Any, Q: Any, R: Any) -> list[list[float]]:
    n = len(A)
    H = np.block([[A, -B @ np.linalg.inv(R) @ B.T], [-Q, -A.T]])
    basis = schur(H, sort="lhp")[1][:, :n]
    made: list[list[float]] = np.linalg.solve(basis[:n].T, basis[n:].T).T.tolist()
    return made


def by_newton(A: Any, B: Any, Q: Any, R: Any) -> Any:
    """Kleinman's iteration, from a gain that places the spectrum left of -beta (Bass 1961)."""
    beta = 2.0 * np.linalg.norm(A) + 1.0
    gramian = solve_continuous_lyapunov(A + beta * np.eye(len(A)), 2.0 * B @ B.T)
    K = B.T @ np.linalg.pinv(gramian)
    for _ in range(40):
        closed = A - B @ K
        P = solve_continuous_lyapunov(closed.T, -(Q + K.T @ R @ K))
        K = np.linalg.solve(R, B.T @ P)
    return P


RIGHT["10.2"] = {
    "by an ordered Schur form": by_schur,
    "by Newton's method": by_newton,
}
WRONG["10.2"] = {
    "unstable half": partial(riccati, half=1.0),
    "R instead of its inverse": partial(riccati, weigh=lambda R: R),
    "Q with the other sign": partial(riccati, cost=1.0),
    "A not transposed": partial(riccati, adjoint=lambda A: A),
    "X and Y exchanged": lambda *case: np.linalg.inv(riccati(*case)),
    "half of it": lambda *case: riccati(*case) / 2,
    "gain instead of P": Because(
        "shape", lambda A, B, Q, R: np.linalg.solve(R, B.T @ riccati(A, B, Q, R))
    ),
}

# 10.3, the controllable subspace of two equal poles on a cart

RIGHT["10.3"] = {
    "an integer": 4,
    "rank by NumPy": np.linalg.matrix_rank(np.diag([1, 1, 1, 1, 0, 0])),
}
WRONG["10.3"] = {
    "all six, as with different rods": 6,
    "difference without its rate": 5,
    "what cannot be reached": 2,
    "configurations only": 3,
}

# 11.1, the whole way of a ball that bounces


def summed(h0: float, e: float) -> float:
    total = height = h0
    while height > 1e-12:
        height *= e**2
        total += 2 * height
    return total


RIGHT["11.1"] = {
    "sum of the bounces": summed,
    "two drops per bounce, less the first": lambda h0, e: h0 * (2 / (1 - e**2) - 1),
}
WRONG["11.1"] = {
    "ways up left out": lambda h0, e: h0 / (1 - e**2),
    "drop counted twice": lambda h0, e: 2 * h0 / (1 - e**2),
    "heights fall as speeds do": lambda h0, e: h0 * (1 + e) / (1 - e),
    "first bounce only": lambda h0, e: h0 + 2 * h0 * e**2,
    "bounces only": lambda h0, e: 2 * h0 * e**2 / (1 - e**2),
    "height above the start": lambda h0, e: h0 * (1 - e**2) / (1 + e**2),
}

# 11.2, between floor and ceiling


def bouncing(
    floor: Any = 0.9, ceiling: Any = 0.5, top: Any = lambda h: 2.0 - h, g: float = 9.81
) -> System:
    h = length("h", 0.0, 2.0)
    blows = [Transition("floor", "flight", "flight", until=h, restitution=floor)]
    if ceiling is not None:
        up = Transition("ceiling", "flight", "flight", until=top(h), restitution=ceiling)
        blows.append(up)
    return System(
        "between",
        bodies=[Body("ball", move(0, 0, h), mass=1.0)],
        gravity=toward("-z", g),
        modes=[Mode("flight")],
        transitions=blows,
    )


def bouncing_by_reset() -> System:
    h = length("h", 0.0, 2.0)
    kept = {"floor": (h, 0.9), "ceiling": (2.0 - h, 0.5)}
    return System(
        "between",
        bodies=[Body("ball", move(0, 0, h), mass=1.0)],
        gravity=toward("-z", 9.81),
        modes=[Mode("flight")],
        transitions=[
            Transition(
                name,
                "flight",
                "flight",
                until=distance,
                provided=-rate(h) if name == "floor" else rate(h),
                reset={rate(h): -e * rate(h)},
            )
            for name, (distance, e) in kept.items()
        ],
    )


RIGHT["11.2"] = {
    "speeds reset": bouncing_by_reset,
    "ceiling with another scale": lambda: bouncing(top=lambda h: 1 - h / 2),
}
WRONG["11.2"] = {
    "floor and ceiling exchanged": lambda: bouncing(0.5, 0.9),
    "no ceiling": lambda: bouncing(ceiling=None),
    "fraction lost for fraction kept": Because("follow one another", lambda: bouncing(floor=0.1)),
    "energy for speed": lambda: bouncing(sqrt(0.9), sqrt(0.5)),
    "guard of the ceiling with the other sign": Because(
        "follow one another", lambda: bouncing(top=lambda h: h - 2.0)
    ),
    "ceiling at 1 m": lambda: bouncing(top=lambda h: 1.0 - h),
    "weaker gravity": lambda: bouncing(g=9.8),
}

# 11.3, the energy that a wheel without a rim loses

RIGHT["11.3"] = {
    "sine": lambda n: sin(2 * pi / n) ** 2,
    "double angle": lambda n: (1 - cos(4 * pi / n)) / 2,
}
WRONG["11.3"] = {
    "speed for energy": lambda n: 1 - cos(2 * pi / n),
    "what is left": lambda n: cos(2 * pi / n) ** 2,
    "half of the angle between spokes": lambda n: sin(pi / n) ** 2,
    "part of the velocity that is stopped": lambda n: sin(2 * pi / n),
    "in degrees": lambda n: sin(360 / n) ** 2,
    "height that is lost": lambda n: 1 - cos(pi / n),
}

# 12.1, the thrust of each rotor

RIGHT["12.1"] = {
    "three significant digits": 3.92,
    "an array with one entry": np.array(0.8 * 9.81) / 2,
}
WRONG["12.1"] = {
    "both rotors": 0.8 * 9.81,
    "mass for weight": 0.4,
    "four rotors": 0.8 * 9.81 / 4,
    "its torque about the middle": 0.8 * 9.81 / 2 * 0.2,
}

# 12.2, a drone

THRUST = (0.0, 8.0)


def drone(
    arm: float = 0.2,
    lift: Any = lambda _, thrust: (0, 0, thrust),
    limit: Any = THRUST,
    gravity: str = "-z",
    about: Any = rot_y,
    inertia: Any = 0.01,
    names: tuple[str, str] = ("left", "right"),
) -> System:
    x, z, theta = length("x", speed=3.0), length("z", speed=3.0), angle("theta", speed=6.0)
    frame = move(x, 0, z) @ about(theta)
    hull = Body("hull", frame, mass=0.8, inertia=inertia)
    rotors = [Control(name, limit=limit) for name in names]
    left, right = (rotor.symbol for rotor in rotors)
    force = lift(theta, left + right)
    return System(
        "drone",
        bodies=[hull],
        inputs=rotors,
        efforts=[Wrench(on=hull, force=force, torque=(0, arm * (left - right), 0))],
        gravity=toward(gravity),
    )


def drone_of_rotors(sign: float = 1.0) -> System:
    """A force at each rotor."""
    x, z, theta = length("x", speed=3.0), length("z", speed=3.0), angle("theta", speed=6.0)
    hull = Body("hull", move(x, 0, z) @ rot_y(theta), mass=0.8, inertia=0.01)
    rotors = [Control(name, limit=THRUST, unit="N") for name in ("left", "right")]
    pushes = [
        Wrench(on=hull, force=(0, 0, rotor.symbol), at=(sign * place, 0, 0))
        for rotor, place in zip(rotors, (-0.2, 0.2), strict=True)
    ]
    return System("drone", bodies=[hull], inputs=rotors, efforts=pushes, gravity=toward("-z", 9.81))


def drone_of_forces() -> System:
    """Both forces act at the centre of mass."""
    x, z, theta = length("x", speed=3.0), length("z", speed=3.0), angle("theta", speed=6.0)
    hull = Body("hull", move(x, 0, z) @ rot_y(theta), mass=0.8, inertia=0.01)
    up = [Force(name, on=hull, along=hull.frame.z, limit=THRUST) for name in ("left", "right")]
    return System("drone", bodies=[hull], inputs=up, gravity=toward("-z", 9.81))


def upright(theta: Any, thrust: Any) -> tuple[Any, ...]:
    """A force along the world's z axis, in the body's axes."""
    return -thrust * sympy.sin(theta), 0, thrust * sympy.cos(theta)


RIGHT["12.2"] = {
    "a force at each rotor": drone_of_rotors,
    "inertia of all axes, other names": lambda: drone(
        inertia=(0.02, 0.01, 0.03), names=("rear", "front")
    ),
}
WRONG["12.2"] = {
    "rotors exchanged": lambda: drone_of_rotors(-1.0),
    "torque with the other sign": lambda: drone(arm=-0.2),
    "distance between the rotors for the arm": lambda: drone(arm=0.4),
    "forces at the middle only": drone_of_forces,
    "moment of inertia of another axis": lambda: drone(inertia=(0.01, 0.02, 0.01)),
    "thrust along the world's z axis": Because("of x", lambda: drone(lift=upright)),
    "thrust along the body's x axis": Because(
        "of x", lambda: drone(lift=lambda _, thrust: (thrust, 0, 0))
    ),
    "gravity upward": Because("of z", lambda: drone(gravity="+z")),
    "turns about the other direction": Because(
        "of x", lambda: drone(about=lambda theta: rot_y(-theta))
    ),
    "rotors that also pull": Because("limit", lambda: drone(limit=8.0)),
}


def cases(kind: dict[str, dict[str, Any]]) -> list[Any]:
    return [
        pytest.param(exercise, answer, id=f"{exercise} {name}")
        for exercise, named in kind.items()
        for name, answer in named.items()
    ]


def handed_in(exercise: str, answer: Any) -> Any:
    return answer() if exercise in MACHINES else answer


@pytest.mark.parametrize(("exercise", "answer"), cases(RIGHT))
def test_a_right_answer_in_another_form_is_accepted(exercise: str, answer: Any) -> None:
    mark = check(exercise, handed_in(exercise, answer))
    assert mark, mark
    assert mark.points == mark.of


@pytest.mark.parametrize(("exercise", "answer"), cases(RIGHT))
def test_a_right_answer_is_right_in_another_process(exercise: str, answer: Any) -> None:
    """As numbers, texts of machines, and functions that are called there."""

    def judge(name: str, given: Any) -> dict[str, Any]:
        return asdict(judged(exercises()[name], given))

    with judging(judge) as address:
        mark = mark_from_afar(address, exercise, handed_in(exercise, answer))
    assert mark["reason"] == ""


@pytest.mark.parametrize(("exercise", "answer"), cases(WRONG))
def test_a_wrong_answer_is_refused_for_what_is_wrong(exercise: str, answer: Any) -> None:
    reason = REASONS.get(exercise, "is not right")
    if isinstance(answer, Because):
        reason, answer = answer.reason, answer.answer
    mark = check(exercise, handed_in(exercise, answer))
    assert not mark
    assert mark.points == 0
    assert re.search(reason, mark.reason), mark.reason


@pytest.mark.parametrize("exercise", [name for name in exercises() if not name.startswith("3.")])
def test_each_exercise_has_answers_of_both_kinds(exercise: str) -> None:
    assert len(RIGHT[exercise]) >= 1
    assert len(WRONG[exercise]) >= 2

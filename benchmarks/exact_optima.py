"""How much longer kinolab's motions are than the shortest there are, where these are known.

    python benchmarks/exact_optima.py                         # all families
    python benchmarks/exact_optima.py reeds_shepp --seed 11   # other goals, other random numbers

Each problem is planned as the default command does. The shortest duration comes from a closed form,
or from the switching times of a bang-bang input, found by SciPy; kinolab computes none of it.
Prints a line for each problem and a Markdown table of the families: the median and the largest
excess in percent.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np
import ompl.base
import scipy

import kinolab
from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Control,
    Drive,
    Rate,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)

CENTRE = 1e-3  # goal tolerance of all entries, in SI units: what it saves is far below a percent
GRAVITY = 9.81  # [m/s^2]
ACCELERATION = 1.0  # [m/s^2] of the double integrator and of the crane's trolley
SPEED, RADIUS = 1.0, 1.0  # [m/s], [m] of Reeds and Shepp's car
GOALS = 20  # of that car, drawn in a square around the start
AROUND = 4.0  # [m] half of its edge
MASS, ROD = 1.0, 1.0  # [kg], [m] of the pendulum
ROPE = 1.0  # [m] of the crane
# Extremals of the pendulum: directions of the costate, seconds and steps, and what is near an end.
COSTATES, HORIZON, TICK, NEAR_MISS = 2000, 5.0, 2e-3, 0.1
NO_ARC = 1e-6  # [s] below which an arc is left out

Slope = Callable[[Any, float], Sequence[float]]  # of a state, under an input


@dataclass(frozen=True)
class Optimum:
    """A problem and the duration of its shortest motion.

    Attributes:
        name: Of the problem.
        scenario: For ``kinolab.load``.
        duration: The shortest, in [s].
    """

    name: str
    scenario: dict[str, Any]
    duration: float


def double_integrator_time(x: float, v: float, end: float, a: float) -> float:
    """Return the least time in [s] in which a mass moves by x, its acceleration limited.

    It speeds up to a peak w and brakes, or the other way round: with the sign s of what comes
    first, w^2 = (v^2 + end^2) / 2 + s a x, and the time is (2 s w - s v - s end) / a.

    Args:
        x: Distance in [m], signed.
        v: Velocity at the beginning in [m/s].
        end: Velocity at the end in [m/s].
        a: Largest acceleration in [m/s^2], positive.

    Source: Bryson, Ho, Applied Optimal Control, 1975, section 3.9.
    """
    times = []
    for s in (1.0, -1.0):
        square = (v**2 + end**2) / 2 + s * a * x
        for w in (math.sqrt(square), -math.sqrt(square)) if square >= 0 else ():
            arcs = (s * (w - v) / a, s * (w - end) / a)
            if min(arcs) >= -1e-12:
                times.append(sum(arcs))
    return min(times)


def reeds_shepp_time(x: float, y: float, psi: float) -> float:
    """Return the least time in [s] of Reeds and Shepp's car from the origin to a pose.

    Args:
        x: In [m].
        y: In [m].
        psi: Heading in [rad].

    Source: Reeds, Shepp, Pacific J. Mathematics 145(2), 1990, as implemented by OMPL.
    """
    space: Any = ompl.base.ReedsSheppStateSpace(RADIUS)
    begin, end = space.allocState(), space.allocState()
    begin.setXY(0.0, 0.0)
    begin.setYaw(0.0)
    end.setXY(x, y)
    end.setYaw(psi)
    return float(space.distance(begin, end)) / SPEED


def swing(x: Any, u: float) -> tuple[float, float]:
    """Return the slope of a pendulum's state (theta, theta_dot), 0 where it hangs, under a torque.

    Args:
        x: In [rad] and [rad/s].
        u: In [N m].
    """
    return x[1], u / (MASS * ROD**2) - GRAVITY / ROD * math.sin(x[0])


def carried(x: Any, u: float) -> tuple[float, float, float, float]:
    """Return the slope of a crane's state (x, theta, x_dot, theta_dot) under an acceleration.

    The load's horizontal acceleration is u cos(theta) + rope theta_ddot along its circle.

    Args:
        x: In [m], [rad], [m/s] and [rad/s]; the load swings towards +x if theta is positive.
        u: Of the trolley, in [m/s^2].
    """
    sway = -(GRAVITY * math.sin(x[1]) + u * math.cos(x[1])) / ROPE
    return x[2], x[3], u, sway


def after_arcs(
    slope: Slope, start: Sequence[float], inputs: Sequence[float], durations: Sequence[float]
) -> Any:
    """Return the state after arcs of constant input, integrated by SciPy."""
    x = np.array(start, dtype=float)
    for u, seconds in zip(inputs, durations, strict=True):
        ends = (0.0, float(seconds))
        x = scipy.integrate.odeint(
            lambda x, _, u=u: slope(x, u), x, ends, rtol=1e-9, atol=1e-11, mxstep=100_000
        )[-1]
    return x


def swing_arcs(
    start: tuple[float, float], ends: Sequence[tuple[float, float]], torque: float
) -> tuple[list[float], list[float]]:
    """Return torques and durations of the shortest motion of a pendulum between two states.

    By Pontryagin's principle the torque is the largest one, with the sign of the second costate.
    Costates at the start are a circle of directions. Motions from many of them show which switch
    how often on the way to an end; a nonlinear program makes their durations exact.

    Args:
        start: Angle in [rad] and its rate in [rad/s].
        ends: The same at the end; one of them is reached, such as upright on either side.
        torque: Largest torque in [N m].
    """
    best = (math.inf, [0.0], [0.0])
    for durations, first, end in _near_misses(start, ends, torque):
        inputs = [first * (-1) ** k for k in range(len(durations))]

        def missed(d: Any, inputs: list[float] = inputs, end: Any = end) -> Any:
            return after_arcs(swing, start, inputs, np.abs(d)) - end

        found = scipy.optimize.minimize(
            lambda d: float(np.sum(d)), durations, method="SLSQP",
            bounds=[(0.0, None)] * len(durations), constraints={"type": "eq", "fun": missed},
            options={"ftol": 1e-13, "eps": 1e-5}, jac=np.ones_like,
        )  # fmt: skip
        if np.abs(missed(found.x)).max() < 1e-6 and found.fun < best[0]:
            arcs = [arc for arc in zip(inputs, found.x.tolist(), strict=True) if arc[1] > NO_ARC]
            best = float(found.fun), [u for u, _ in arcs], [d for _, d in arcs]
    return best[1], best[2]


def _near_misses(
    start: tuple[float, float], ends: Sequence[tuple[float, float]], torque: float
) -> Iterator[tuple[list[float], float, tuple[float, float]]]:
    """Yield durations of arcs, first torque and end of extremals that pass near an end, by time."""
    phi = np.linspace(0.0, 2 * math.pi, COSTATES, endpoint=False)
    z = np.array(
        [np.full(COSTATES, start[0]), np.full(COSTATES, start[1]), np.cos(phi), np.sin(phi)]
    )

    def slope(z: Any) -> Any:
        u = torque * np.sign(z[3])
        down = GRAVITY / ROD * np.cos(z[0])
        return np.array(
            [z[1], u / (MASS * ROD**2) - GRAVITY / ROD * np.sin(z[0]), down * z[3], -z[2]]
        )

    signs, found = [np.sign(z[3])], []
    for k in range(1, round(HORIZON / TICK) + 1):
        k1 = slope(z)
        k2 = slope(z + TICK / 2 * k1)
        k3 = slope(z + TICK / 2 * k2)
        z = z + TICK / 6 * (k1 + 2 * k2 + 2 * k3 + slope(z + TICK * k3))
        signs.append(np.sign(z[3]))
        for end in ends:
            off = np.hypot(z[0] - end[0], z[1] - end[1])
            found += [(off[i], k, i, end) for i in np.flatnonzero(off < NEAR_MISS).tolist()]
    history, seen = np.array(signs), set()
    for _, k, i, end in sorted(found, key=lambda near: near[0]):
        switches = np.flatnonzero(np.diff(history[: k + 1, i])) + 1
        kind = len(switches), history[0, i], end, k * TICK // NEAR_MISS
        if kind not in seen:
            seen.add(kind)
            arcs = TICK * np.diff([0, *switches.tolist(), k])
            yield arcs.tolist(), torque * float(history[0, i]), end


def crane_arcs(distance: float) -> tuple[float, float]:
    """Return the durations in [s] of the first two of four arcs that carry a load to rest.

    The motion is its own mirror image: T - t, distance - x and -theta solve the same equations
    under the negated acceleration. So the arcs +, -, +, - last d1, d2, d2 and d1, and half of the
    way is done in the middle, where the load hangs straight down.

    Args:
        distance: From rest to rest, in [m], positive.

    Source: Pao, Minimum-time control characteristics of flexible structures, J. Guidance, Control
    and Dynamics 19(1), 1996.
    """
    a, rest = ACCELERATION, (0.0, 0.0, 0.0, 0.0)

    def missed(d: Any) -> Any:
        middle = after_arcs(carried, rest, (a, -a), np.abs(d))
        return middle[0] - distance / 2, middle[1]

    # Without the rope it would take d1 + d2 = sqrt(distance / a) of mean speed; several motions
    # solve the equations, and the shortest is wanted.
    about, times = math.sqrt(distance / a), []
    for share in np.linspace(0.1, 0.9, 9):
        for longer in (1.0, 1.3, 1.7):
            guess = about * longer * np.array([share, 1 - share])
            found = scipy.optimize.root(missed, guess, tol=1e-10)
            d = np.abs(found.x)
            if np.abs(missed(d)).max() < 1e-7:
                times.append((float(d.sum()), float(d[0]), float(d[1])))
    return min(times)[1:]


def double_integrators(_: int) -> Iterator[Optimum]:
    """Yield a mass whose acceleration is limited, from rest to rest and between other speeds."""
    x = length("x", -50.0, 50.0, speed=20.0)
    body = Body("mass", move(x), mass=1.0)
    machine = System("mass", bodies=[body], inputs=[Drive("push", on=x, limit=ACCELERATION)])
    for distance, v, end in ((1, 0, 0), (5, 0, 0), (3, 1, 0), (2, -1, 1), (0.5, 2, 0), (-4, 0, 1)):
        yield Optimum(
            f"{distance} m, from {v} to {end} m/s",
            _scenario(machine, {"x_dot": v}, {"x": distance, "x_dot": end}),
            double_integrator_time(distance, v, end, ACCELERATION),
        )


def reeds_shepp_cars(seed: int) -> Iterator[Optimum]:
    """Yield a car whose speed and curvature are limited, in the open, with random goals."""
    x, y, psi = length("x"), length("y"), angle("psi")
    frame = move(x, y) @ rot_z(psi)
    V, curvature = velocity(frame), Control("curvature", limit=1 / RADIUS, unit="1/m")
    machine = System(
        "reeds_shepp",
        bodies=[Body("car", frame, shape=Box(0.6, 0.3, 0.2))],
        constraints=[
            zero(V.y, "no sideslip"),
            zero(rate(psi) - curvature.symbol * V.x, "it turns as it is steered"),
        ],
        inputs=[Rate("speed", on=V.x, limit=SPEED), curvature],
    )
    generator = np.random.default_rng(seed)
    wide = [-3 * AROUND, 3 * AROUND]  # no shortest curve leaves it
    for _ in range(GOALS):
        x1, y1 = generator.uniform(-AROUND, AROUND, 2).round(2).tolist()
        heading = round(float(generator.uniform(-math.pi, math.pi)), 2)
        scenario = _scenario(machine, {}, {"x": x1, "y": y1, "psi": heading})
        scenario["world"] = {"bounds": {"x": wide, "y": wide}}
        name = f"({x1} m, {y1} m, {heading} rad)"
        yield Optimum(name, scenario, reeds_shepp_time(x1, y1, heading))


def pendulums(_: int) -> Iterator[Optimum]:
    """Yield a pendulum whose torque does not hold it aside: swung up, and put to rest."""
    theta = angle("theta", speed=20.0)
    bob = Body("bob", rot_y(theta) @ move(0, 0, -ROD), mass=MASS)
    upright = [(math.pi, 0.0), (-math.pi, 0.0)]
    cases: list[tuple[str, float, tuple[float, float], list[tuple[float, float]]]] = [
        ("swung up by 0.6 of its weight", 0.6, (0.0, 0.0), upright),
        ("swung up by 0.4 of its weight", 0.4, (0.0, 0.0), upright),
        ("put to rest", 0.3, (1.5, 0.0), [(0.0, 0.0)]),
        ("caught from below, upright", 0.5, (0.0, 6.0), upright),
    ]
    for name, share, start, ends in cases:
        torque = share * MASS * GRAVITY * ROD
        machine = System(
            "pendulum",
            bodies=[bob],
            gravity=toward("-z", GRAVITY),
            inputs=[Torque("motor", on=bob, about=WORLD.y, limit=torque)],
        )
        begin = {"theta": start[0], "theta_dot": start[1]}
        goal = {"theta": ends[0][0], "theta_dot": ends[0][1]}
        arcs = swing_arcs(start, ends, torque)[1]
        yield Optimum(name, _scenario(machine, begin, goal), sum(arcs))


def cranes(_: int) -> Iterator[Optimum]:
    """Yield a trolley whose acceleration is limited and that carries a load from rest to rest."""
    rope = parameter("rope", ROPE, "m")
    x, theta = length("x", -50.0, 50.0, speed=20.0), angle("theta", -1.5, 1.5, speed=20.0)
    load = Body("load", move(x) @ rot_y(-theta) @ move(0, 0, -rope), mass=1.0)
    machine = System(
        "crane",
        bodies=[load],
        gravity=toward("-z", GRAVITY),
        inputs=[Drive("travel", on=x, limit=ACCELERATION)],
    )
    for distance in (0.5, 1.0, 2.0, 3.0, 8.0):
        goal = {"x": distance, "theta": 0.0, "x_dot": 0.0, "theta_dot": 0.0}
        yield Optimum(f"{distance} m", _scenario(machine, {}, goal), 2 * sum(crane_arcs(distance)))


FAMILIES: dict[str, Callable[[int], Iterator[Optimum]]] = {
    "double_integrator": double_integrators,
    "reeds_shepp": reeds_shepp_cars,
    "pendulum": pendulums,
    "crane": cranes,
}


def _scenario(machine: System, start: dict[str, Any], goal: dict[str, Any]) -> dict[str, Any]:
    return {"system": machine, "start": start, "goal": {**goal, "tolerance": CENTRE}}


def excesses(family: str, seed: int) -> Iterator[tuple[Optimum, float, float]]:
    """Yield each problem of a family, the duration of its plan in [s] and the excess in percent.

    Args:
        family: Its name.
        seed: Of goals and of planning.
    """
    for optimum in FAMILIES[family](seed):
        plan = kinolab.load(optimum.scenario).solve(seed=seed)
        found = math.inf
        if plan.status == "solved" and plan.trajectory is not None:
            found = plan.trajectory.duration
        yield optimum, found, 100 * (found / optimum.duration - 1)


def main() -> None:
    """Plan all problems and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("families", nargs="*", metavar="FAMILY", help=", ".join(FAMILIES))
    parser.add_argument("--seed", type=int, default=1, help="of goals and of planning")
    given = parser.parse_args()
    unknown = set(given.families) - set(FAMILIES)
    if unknown:
        parser.error(f"Unknown: {', '.join(sorted(unknown))}. Known: {', '.join(FAMILIES)}.")
    lines = ["| family | problems | median excess [%] | largest excess [%] |", "|---|---|---|---|"]
    for family in given.families or FAMILIES:
        over = []
        for optimum, found, excess in excesses(family, given.seed):
            print(
                f"{family}: {optimum.name}: {found:.3f} s, exact {optimum.duration:.3f} s, "
                f"{excess:+.2f} %",
                flush=True,
            )
            over.append(excess)
        lines.append(f"| {family} | {len(over)} | {median(over):.2f} | {max(over):.2f} |")
    print("\n" + "\n".join(lines))


if __name__ == "__main__":
    main()

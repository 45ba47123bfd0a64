"""Machines that use every word of the vocabulary, made with the public names only."""

from __future__ import annotations

from collections.abc import Callable

import sympy

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Buoyancy,
    Capsule,
    Control,
    Coulomb,
    Drive,
    Force,
    Potential,
    Pull,
    Rate,
    Sphere,
    Spring,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    closed,
    force_of,
    lag,
    length,
    move,
    orient,
    parameter,
    rate,
    require,
    rot_x,
    rot_y,
    rot_z,
    rotation,
    toward,
    turn_rate,
    velocity,
    zero,
)


def double_pendulum_3d() -> System:
    """Two rods on universal joints."""
    a = [angle(f"a{i}") for i in range(4)]
    upper = rot_x(a[0]) @ rot_y(a[1]) @ move(0, 0, -0.5)
    lower = upper @ move(0, 0, -0.5) @ rot_x(a[2]) @ rot_y(a[3]) @ move(0, 0, -0.5)
    one = Body("one", upper, mass=1.2, inertia=(0.1, 0.11, 0.01), shape=Capsule(0.05, 1.0))
    two = Body("two", lower, mass=0.8, inertia=(0.09, 0.1, 0.02), shape=Capsule(0.05, 1.0))
    return System(
        "double_pendulum_3d",
        bodies=[one, two],
        gravity=toward("-z", parameter("g", 9.81, "m/s^2")),
        inputs=[
            Torque("shoulder", on=one, about=WORLD.x, limit=5.0),
            Torque("elbow", on=two, about=upper.x, reacts_on=one, limit=5.0),
        ],
    )


def arm(links: int = 6) -> System:
    """A chain of revolute joints about alternating axes, with products of inertia."""
    g, bodies = WORLD, []
    for i in range(links):
        q = angle(f"q{i}")
        g = g @ move(0, 0.02, 0.3) @ (rot_x, rot_y, rot_z)[i % 3](q)
        inertia = (0.05, 0.06, 0.02 + 0.01, 0.003, -0.002, 0.001)
        bodies.append(
            Body(f"link{i}", g @ move(0.01, 0, 0.15), mass=1.0 + 0.1 * i, inertia=inertia)
        )
    inputs = [
        Torque(f"tau{i}", on=body, about=body.frame.z, limit=3.0) for i, body in enumerate(bodies)
    ]
    return System("arm", bodies=bodies, gravity=toward("-z"), inputs=inputs[-2:])


def wheeled_hull() -> System:
    """A body on SO(3) with three reaction wheels."""
    R, wheels = rotation("R", speed=2.0), [angle(f"wheel_{axis}") for axis in "xyz"]
    hull = orient(R)
    Iw = parameter("I_w", 0.01, "kg m^2")
    bodies = [Body("hull", hull, mass=20.0, inertia=(10.0, 12.0, 8.0), shape=Box(1, 1, 1))]
    turns = (rot_x, rot_y, rot_z)
    for axis, turn, q, at in zip("xyz", turns, wheels, (0.2, 0.3, 0.4), strict=True):
        place = hull @ move(*(at if axis == name else 0 for name in "xyz"))
        moments = tuple(Iw if axis == name else 0.6 * Iw for name in "xyz")
        bodies.append(Body(f"wheel_{axis}_body", place @ turn(q), mass=1.0, inertia=moments))
    inputs = [
        Torque(
            f"tau_{axis}",
            on=bodies[1 + i],
            about=getattr(hull, axis),
            limit=0.1,
            reacts_on=bodies[0],
        )
        for i, axis in enumerate("xyz")
    ]
    return System("wheeled_hull", bodies=bodies, inputs=inputs)


def floating_satellite() -> System:
    """The hull where it may also drift."""
    x, y, z, R = length("x"), length("y"), length("z"), rotation("R")
    hull = move(x, y, z) @ orient(R)
    body = Body("hull", hull, mass=20.0, inertia=(10.0, 12.0, 8.0, 0.3, -0.2, 0.1))
    return System(
        "floating_satellite",
        bodies=[body],
        inputs=[Force("thrust", on=body, along=hull.x, limit=1.0)],
        gravity=toward("+y", 1.6),
    )


def finned_hull() -> System:
    """A bottom-heavy ellipsoid in an ideal fluid, with drag and a rudder's wrench."""
    x, y, z, R = length("x"), length("y"), length("z"), rotation("R")
    hull = move(x, y, z) @ orient(R)
    V = velocity(hull)
    thrust = Control("thrust", limit=5.0, unit="N")
    rudder = Control("rudder", limit=0.4, unit="rad")
    elevator = Control("elevator", limit=0.4, unit="rad")
    off_diagonal = [[0.0] * 6 for _ in range(6)]
    for i, value in enumerate((0.6, 8.9, 8.7, 0.1, 0.8, 0.9)):
        off_diagonal[i][i] = value
    off_diagonal[1][5] = off_diagonal[5][1] = 0.3
    off_diagonal[2][4] = off_diagonal[4][2] = -0.2
    body = Body(
        "hull",
        hull,
        mass=10.0,
        inertia=(0.3, 1.2, 1.3),
        added_mass=off_diagonal,
        shape=Capsule(0.2, 1.0, axis="x"),
    )
    weight = 10.0 * 9.81
    fins = Wrench(
        on=body,
        force=(thrust.symbol, 0, 0),
        at=(-0.5, 0, 0),
        torque=(0, 2 * V.x * elevator.symbol, 2 * V.x * rudder.symbol),
    )
    wx, wy, wz = turn_rate(R)
    return System(
        "finned_hull",
        bodies=[body],
        gravity=toward("-z", 9.81),
        inputs=[thrust, rudder, elevator],
        efforts=[
            Buoyancy(on=body, lift=weight, at=(0, 0, 0.05)),
            fins,
            *(
                Viscous(v, c)
                for v, c in zip((V.x, V.y, V.z, wx, wy, wz), (1, 6, 6, 1, 2, 2), strict=True)
            ),
        ],
    )


def four_bar() -> System:
    """A closed loop of three moving bars on a pivot, with a motor."""
    a, b, c = angle("a"), angle("b"), angle("c")
    first = rot_z(a)
    second = first @ move(0.4) @ rot_z(b)
    third = move(1.0) @ rot_z(c)
    bars = [
        Body("crank", first @ move(0.2), mass=0.5, inertia=(0.001, 0.01, 0.01)),
        Body("coupler", second @ move(0.5), mass=1.0, inertia=(0.001, 0.08, 0.08)),
        Body("rocker", third @ move(0.4), mass=0.8, inertia=(0.001, 0.05, 0.05)),
    ]
    tip_x = 0.4 * sympy.cos(a) + 1.0 * sympy.cos(a + b)
    tip_y = 0.4 * sympy.sin(a) + 1.0 * sympy.sin(a + b)
    return System(
        "four_bar",
        bodies=bars,
        gravity=toward("-y"),
        constraints=[
            closed(tip_x - 1.0 - 0.8 * sympy.cos(c), "loop x"),
            closed(tip_y - 0.8 * sympy.sin(c), "loop y"),
        ],
        inputs=[Torque("motor", on=bars[0], about=WORLD.z, limit=5.0)],
        velocities=[a],
    )


def four_bar_by_multipliers() -> System:
    """The same loop with all rates as states, and a constraint that repeats another."""
    chosen = four_bar()
    again = closed(2 * chosen.constraints[0].position, "loop x again")
    return System(
        "four_bar_by_multipliers",
        bodies=chosen.bodies,
        gravity=chosen.gravity,
        constraints=[*chosen.constraints, again],
        inputs=chosen.inputs,
        velocities="all",
    )


def driven_crane() -> System:
    """A trolley that is driven, a hoist that is pulled, a load on a rope; sway is damped."""
    x, l = length("x", 0, 10, speed=1.5), length("l", 0.5, 4.5, speed=1.0)  # noqa: E741
    sway = angle("sway", -1.0, 1.0, speed=2.0)
    m, g = parameter("m", 5.0, "kg"), parameter("g", 9.81, "m/s^2")
    trolley = move(x, 0, 5)
    rope = trolley @ rot_y(-sway)
    load = Body("load", rope @ move(0, 0, -l), mass=m, shape=Box(0.6, 0.6, 0.6))
    cart = Body("trolley", trolley, mass=10.0, shape=Box(0.5, 0.5, 0.2))
    hoist = Pull("hoist", between=(trolley, load.frame), limit=80.0)
    return System(
        "driven_crane",
        bodies=[cart, load],
        gravity=toward("-z", g),
        inputs=[Drive("trolley_drive", on=x, limit=0.5), hoist],
        efforts=[Viscous(rate(sway), 0.1)],
        requirements=[require(hoist.symbol, "the rope only pulls")],
    )


def kinematic_car() -> System:
    """A car moved by speed and steering rate; nothing has mass."""
    x, y, psi, delta = length("x"), length("y"), angle("psi"), angle("delta", -0.6, 0.6)
    rear = move(x, y) @ rot_z(psi)
    front = rear @ move(2.7) @ rot_z(delta)
    V = velocity(rear)
    return System(
        "kinematic_car",
        bodies=[
            Body("car", rear @ move(1.35, 0, 0.5), shape=Box(4, 1.8, 1.4), touches_ground=True)
        ],
        constraints=[zero(V.y, "rear"), zero(velocity(front).y, "front")],
        inputs=[Rate("speed", on=V.x, limit=2.0), Rate("steer", on=delta, limit=0.5)],
    )


def loose_snakeboard() -> System:
    """A rider's rotor and two steered wheel pairs on a board."""
    x, y, th = length("x"), length("y"), angle("th")
    psi, back, front = angle("psi"), angle("phi_b", -1.2, 1.2), angle("phi_f", -1.2, 1.2)
    m, span = parameter("m", 6.0, "kg"), parameter("l", 0.2, "m")
    Jr, Jw = parameter("J_r", 0.072, "kg m^2"), parameter("J_w", 0.0013, "kg m^2")
    J = m * span**2 - Jr - 2 * Jw
    board = move(x, y, 0.1) @ rot_z(th)
    back_axle = board @ move(-span) @ rot_z(back)
    front_axle = board @ move(span) @ rot_z(front)
    bodies = [
        Body("board", board, mass=m, inertia=(J, J, J), shape=Box(0.5, 0.1, 0.02)),
        Body("rotor", board @ rot_z(psi), inertia=(Jr, Jr, Jr)),
        Body("back", back_axle, inertia=(Jw, Jw, Jw)),
        Body("front", front_axle, inertia=(Jw, Jw, Jw)),
    ]
    return System(
        "loose_snakeboard",
        bodies=bodies,
        constraints=[
            zero(velocity(back_axle).y, "back wheels"),
            zero(velocity(front_axle).y, "front wheels"),
        ],
        inputs=[
            Torque("tau_psi", on=bodies[1], about=board.z, reacts_on=bodies[0], limit=1.0),
            Torque("tau_b", on=bodies[2], about=board.z, reacts_on=bodies[0], limit=0.2),
            Torque("tau_f", on=bodies[3], about=board.z, reacts_on=bodies[0], limit=0.2),
        ],
        velocities=[x, psi, back, front],
    )


def trident_snake() -> System:
    """A triangle with three legs of one passive wheel each, steered at their roots.

    Source: Ishikawa, Trident snake robot, SICE 2004.
    """
    x, y, th = length("x"), length("y"), angle("th")
    root = move(x, y) @ rot_z(th)
    legs = [angle(f"phi{i}", -1.2, 1.2) for i in range(3)]
    bodies = [Body("root", root, mass=2.0, inertia=(0.1, 0.1, 0.2), shape=Sphere(0.3))]
    constraints, inputs = [], []
    for i, phi in enumerate(legs):
        leg = root @ rot_z(2 * sympy.pi * i / 3) @ move(0.3) @ rot_z(phi)
        wheel = leg @ move(0.4)
        bodies.append(Body(f"leg{i}", leg @ move(0.2), mass=0.3, inertia=(0.001, 0.01, 0.01)))
        constraints.append(zero(velocity(wheel).y, f"wheel {i}"))
        inputs.append(Torque(f"tau{i}", on=bodies[-1], about=leg.z, reacts_on=bodies[0], limit=1.0))
    return System("trident_snake", bodies=bodies, constraints=constraints, inputs=inputs)


def sprung_cart() -> System:
    """A cart and a mass joined by a spring and dry friction, driven by a lagging motor."""
    x, y = length("x"), length("y")
    k = parameter("k", 40.0, "N/m")
    cart = Body("cart", move(x), mass=2.0)
    block = Body("block", move(x + y + 1, 0.3), mass=1.0)
    demand = Control("demand", limit=10.0, unit="N")
    motor = lag("thrust", demand.symbol, 0.1, unit="N")
    return System(
        "sprung_cart",
        bodies=[cart, block],
        inputs=[demand],
        states=[motor],
        efforts=[
            Spring(between=(cart.frame, block.frame), stiffness=k, length=0.8),
            Coulomb(rate(y), 0.5, 0.05),
            Potential(0.5 * k * x**2),
            Wrench(on=cart, force=(motor.symbol, 0, 0), reacts_on=block, at=(0, 0.1, 0)),
        ],
    )


def rope_pendulum() -> System:
    """A weight on a rope of fixed length, in Cartesian coordinates: the rope may only pull."""
    x, y = length("x"), length("y")
    weight = Body("weight", move(x, y), mass=1.5)
    rope = closed(sympy.sqrt(x**2 + y**2) - 1, "rope")
    return System(
        "rope_pendulum",
        bodies=[weight],
        gravity=toward("-y"),
        constraints=[rope],
        velocities="all",
        inputs=[Force("push", on=weight, along=WORLD.x, limit=3.0)],
        requirements=[require(-force_of(rope), "the rope only pulls")],
    )


MACHINES: dict[str, Callable[[], System]] = {
    make.__name__: make
    for make in (
        double_pendulum_3d,
        arm,
        wheeled_hull,
        floating_satellite,
        finned_hull,
        four_bar,
        four_bar_by_multipliers,
        driven_crane,
        kinematic_car,
        loose_snakeboard,
        trident_snake,
        sprung_cart,
        rope_pendulum,
    )
}

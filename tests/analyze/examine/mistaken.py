"""Machines with one mistake each: right when nothing is planted, and wrong in a named way else."""

from __future__ import annotations

from typing import Any

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Capsule,
    Cylinder,
    Disk,
    Feedback,
    Force,
    Load,
    Potential,
    Reference,
    Sphere,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    closed,
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


def coin(**other: Any) -> System:
    """A coin that rolls upright, with some of its parts exchanged."""
    m, R = parameter("m", other.get("mass", 0.5), "kg"), parameter("R", 0.2, "m")
    x, y, psi, phi = length("x"), length("y"), angle("psi"), angle("phi", speed=9.0)
    fork = move(x, y, R) @ rot_z(psi)
    frame = other.get("frame", fork @ rot_y(phi))
    if other.get("swapped"):
        frame = move(x, y, R) @ rot_y(phi) @ rot_z(psi)
    body = Body(
        "coin",
        frame,
        mass=m,
        inertia=other.get("inertia", (m * R**2 / 4, m * R**2 / 2, m * R**2 / 4)),
        shape=Disk(other.get("radius", R), 0.02, axis="y"),
        touches_ground=True,
    )
    V = velocity(fork)
    forward = rate(x) if other.get("along_x") else V.x
    roll = zero(forward - other.get("sign", 1) * other.get("rolls", R) * rate(phi), "rolling")
    side = zero(V.y, "no sideslip")
    kept = [c for c in (side, roll) if c.name not in other.get("without", ())]
    steer_about = body.frame.z if other.get("own_axis") else fork.z
    return System(
        "coin",
        bodies=[body],
        constraints=kept,
        gravity=toward(other.get("down", "-z"), other.get("g", 9.81)),
        inputs=[
            Torque("drive", on=body, about=fork.y, limit=1.0),
            Torque("steer", on=body, about=steer_about, limit=1.0),
        ],
        efforts=[Wrench(on=body, force=(other.get("push", 0) * V.x, 0, 0))] * ("push" in other),
        expected=other.get("expected", ()),
    )


def arm(**other: Any) -> System:
    """Two links in a vertical plane with a motor at each joint."""
    a, b = angle("a", *other.get("limits", (-2.0, 2.0)), speed=5.0), angle("b", speed=5.0)
    reach, turn = parameter("l", other.get("l", 0.4), "m"), other.get("turn", 0)
    shoulder = move(0, 0, 1) @ rot_y(a)
    elbow = shoulder @ move(reach) @ rot_y(b + turn)
    if other.get("swapped"):
        elbow = move(0, 0, 1) @ move(reach) @ rot_y(a) @ rot_y(b)
    rod = Capsule(0.02, reach, axis="x")
    upper, fore = (
        Body(name, joint @ move(reach / 2), mass=mass, inertia=mass * 0.4**2 / 12, shape=rod)
        for name, joint, mass in (("upper", shoulder, 1.0), ("fore", elbow, other.get("m", 0.5)))
    )
    reacts = None if other.get("alone") else upper
    return System(
        "arm",
        bodies=[upper, fore],
        gravity=toward(other.get("down", "-z")),
        inputs=[
            Torque("first", on=upper, about=WORLD.y, limit=9.0),
            Torque("second", on=fore, about=elbow.y, limit=3.0, reacts_on=reacts),
        ],
        efforts=[
            Wrench(on=fore, torque=(0, other.get("push", -0.1) * rate(b), 0), reacts_on=upper)
        ],
    )


def cart(**other: Any) -> System:
    """A cart on two wheels that a motor drives along a line, with a slider on it."""
    x, s = length("x", speed=2.0), length("s", -0.3, 0.3, speed=1.0)
    phi, r = angle("phi", speed=20.0), parameter("r", 0.1, "m")
    axle = move(x, 0, r)
    hull = Body("hull", axle @ move(0, 0, 0.2), mass=5.0, shape=Box(0.8, 0.3, 0.1))
    sizes = (other.get("radius", r), 0.04)
    wheel = Body(
        "wheel",
        axle @ rot_y(other.get("way", 1) * phi),
        mass=other.get("mass", 0.5),
        inertia=other.get("inertia", 0.0025),
        shape=Cylinder(*sizes, axis="y"),
        touches_ground=True,
    )
    slider = Body("slider", axle @ move(s, 0, 0.3), mass=1.0, shape=Box(0.1, 0.1, 0.1))
    roll = zero(rate(x) - other.get("rolls", r) * rate(phi), "rolling")
    base = None if other.get("alone") else hull
    return System(
        "cart",
        bodies=[hull, wheel, slider],
        constraints=[] if other.get("free") else [roll],
        gravity=toward(other.get("down", "-z")),
        inputs=[
            Torque("motor", on=wheel, about=axle.y, limit=2.0),
            Force("slide", on=slider, along=axle.x, limit=5.0, reacts_on=base),
        ],
        efforts=[Viscous(rate(s), 0.1)],
    )


def ball(**other: Any) -> System:
    """A ball that rolls in a straight gutter on a table."""
    x, phi, R = length("x", -1, 1, speed=1.0), angle("phi", speed=50.0), parameter("R", 0.05, "m")
    table = Body("table", move(0, 0, 0.7), shape=Box(3.0, 1.0, other.get("thick", 0.04)))
    stone = Body(
        "stone",
        move(x, 0, 0.72 + R) @ rot_y(phi),
        mass=other.get("mass", 0.4),
        inertia=other.get("inertia", 0.4 * 0.4 * 0.05**2),
        shape=Sphere(other.get("radius", R)),
    )
    return System(
        "ball",
        bodies=[table, stone],
        constraints=[] if other.get("free") else [zero(rate(x) - R * rate(phi), "rolling")],
        gravity=toward(other.get("down", "-z")),
        inputs=[Force("push", on=stone, along=WORLD.x, limit=1.0)],
    )


def turntable(**other: Any) -> System:
    """A table that turns, with a link that tilts on it and a slider on a rail."""
    psi, q = angle("psi", speed=5.0), angle("q", -1.0, 1.0, speed=5.0)
    s = length("s", -0.2, 0.2, speed=1.0)
    top = move(0, 0, 0.5) @ rot_z(psi)
    table = Body("table", top, mass=4.0, inertia=0.1, shape=Disk(0.4, 0.04))
    link = Body(
        "link", top @ move(0.3, 0, 0.1) @ rot_y(q) @ move(0, 0, 0.1), mass=0.5, inertia=0.01
    )
    slider = Body("slider", top @ move(0, s, 0.1), mass=0.2, inertia=0.001)
    spring = {"energy": Potential(other.get("sign", 1) * 9.0 * s**2 / 2)}
    spring |= {"force": Load(-other.get("sign", 1) * 9.0 * s, rate(s))}
    on = table if other.get("reacts", True) else None
    tilt, rail = (other.get("about", top.y), other.get("along", top.y))
    return System(
        "turntable",
        bodies=[table, link, slider],
        inputs=[
            Torque("swivel", on=table, about=WORLD.z, limit=2.0),
            Torque("tilt", on=link, about=tilt, limit=2.0, reacts_on=on),
            Force("pull", on=slider, along=rail, limit=2.0, reacts_on=table),
        ],
        efforts=[spring[other.get("spring", "energy")]],
        gravity=toward("-z"),
    )


def slung(**other: Any) -> System:
    """A hull in a vertical plane with a load on a stiff rod below it, and a mast on top."""
    x, z, a = length("x"), length("z", 1.0, 9.0), angle("a", -1.0, 1.0)
    place, tilt, down = move(x, 0, z), rot_y(a), move(0, 0, -0.5)
    hook = tilt @ place @ down if other.get("swapped") else place @ tilt @ down
    hull = Body("hull", place, mass=1.0, inertia=0.1, shape=Box(0.3, 0.3, 0.1))
    load = Body("load", hook, mass=0.2, inertia=0.01, shape=Sphere(0.05))
    push = Force("push", on=hull, along=WORLD.x, limit=2.0)
    return System("slung", bodies=[hull, load], inputs=[push], gravity=toward("-z"))


def crane(**other: Any) -> System:
    """A tower on rails with a jib that turns."""
    y, psi = length("y", -2, 2), angle("psi", -2.0, 2.0)
    place, turn, out = move(0, y, 3), rot_z(psi), move(1.0)
    jib_frame = turn @ place @ out if other.get("swapped") else place @ turn @ out
    tower = Body("tower", place, mass=90.0, inertia=9.0, shape=Box(0.3, 0.3, 0.5))
    jib = Body("jib", jib_frame, mass=9.0, inertia=3.0, shape=Box(2.0, 0.1, 0.1))
    drive = Force("drive", on=tower, along=WORLD.y, limit=9.0)
    return System("crane", bodies=[tower, jib], inputs=[drive], gravity=toward("-z"))


def post(**other: Any) -> System:
    """A rod that swings on a post, held upright by a law."""
    q, size = angle("q", -0.5, 0.5, speed=4.0), 0.6
    hinge = move(0, 0, 1) @ rot_y(q)
    if other.get("swapped"):
        middle = rot_y(q) @ move(0, 0, 1 + size / 2)
    else:
        middle = hinge @ move(0, 0, other.get("lever", size / 2))
    stand = Body("stand", move(0, 0, 0.5), shape=Box(0.1, 0.1, 1.0))
    rod = Body("rod", middle, mass=0.4, inertia=0.4 * size**2 / 12, shape=Cylinder(0.02, size))
    wanted = Reference("wanted", limit=0.2, unit="rad")
    gain = other.get("gain", 1)
    law = Feedback([wanted], {"motor": -gain * (9.0 * (q - wanted.symbol) + 1.5 * rate(q))})
    return System(
        "post",
        bodies=[stand, rod],
        inputs=[Torque("motor", on=rod, about=WORLD.y, limit=5.0)],
        feedback=law,
        gravity=toward("-z"),
    )


def sledge(**other: Any) -> System:
    """A board on two fixed wheels, which a rope pulls, in front of one that it tows."""
    x, y, psi, a = length("x"), length("y"), angle("psi"), angle("a", -1.0, 1.0)
    r = parameter("r", 0.1, "m")
    front = move(x, y, r) @ rot_z(psi)
    rear = front @ move(-0.6) @ rot_z(a) @ move(-0.4)
    boards = [
        Body(name, frame, mass=2.0, inertia=0.1, touches_ground=other.get("stands", True), shape=(
            Box(0.3, 0.2, 0.02), Disk(r, 0.02, axis="y", at=(0, 0.15, 0)),
            Disk(r, 0.02, axis="y", at=(0, -0.15, 0))))
        for name, frame in (("board", front), ("towed", rear))
    ]  # fmt: skip
    kept = [("board", front), ("towed", rear)]
    return System(
        "sledge",
        bodies=boards,
        constraints=[zero(velocity(f).y, f"{n} keeps its track")
                     for n, f in kept if n not in other.get("without", ())],
        inputs=[Force("rope", on=boards[0], along=front.x, limit=5.0)],
        gravity=toward("-z"),
    )  # fmt: skip


def block(**other: Any) -> System:
    """A ball that a constraint keeps on the ground, and a slider that may hit a wall of it."""
    z, s, r = length("z", 0.05, 3.0), length("s", -1.0, 1.0, speed=1.0), parameter("r", 0.1, "m")
    ball_ = Body(
        "ball", move(0, 0, z), mass=1.0, shape=Sphere(other.get("radius", r)), touches_ground=True
    )
    hand, wall = Box(0.2, 0.2, 0.2), Box(0.1, 1.0, 1.0)
    slider = Body("slider", move(s, 3, 2), mass=1.0, shape=hand)
    walls = [Body(f"wall {k}", move(0.9 * k, 3, 2), shape=wall) for k in (-1, 1)]
    pairs = [("slider", f"wall {k}") for k in (-1, 1)]
    held = [closed(z - r, "on the ground")] if other.get("held", True) else []
    return System(
        "block",
        bodies=[ball_, slider, *walls],
        constraints=held,
        inputs=[Force("push", on=slider, along=WORLD.x, limit=2.0)],
        collisions=pairs[: other.get("pairs", 2)],
        gravity=toward("-z"),
    )

"""Cranes: one that goes overhead in a hall, and two on one runway."""

from typing import Any

from sympy import Expr, atan, cos, sin

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Cable,
    Coordinate,
    Cylinder,
    Drive,
    FlatOutputs,
    Force,
    Parameter,
    Pull,
    System,
    Viscous,
    angle,
    length,
    move,
    output,
    parameter,
    rate,
    require,
    rot_x,
    rot_y,
    toward,
)

HEIGHT = 9.0  # [m] of the rails above the floor
SPAN = 14.0  # [m] between the rails


def crane() -> System:
    """An overhead crane with two sway angles; its rope carries a package and never pushes.

    The motors give a force by current and a drag by speed, so that every force has a steady speed:
    at most 1.2 m/s of bridge and trolley, 0.5 m/s of the hoist.

    Source: Abdel-Rahman, Nayfeh, Masoud, Dynamics and control of cranes: a review, J. Vibration
    and Control 9, 2003.
    """
    m, g = parameter("m", 1000.0, "kg"), parameter("g", 9.81, "m/s^2")
    M_b, M_t = parameter("M_b", 3000.0, "kg"), parameter("M_t", 500.0, "kg")
    c_x, c_y = parameter("c_x", 2500.0, "N s/m"), parameter("c_y", 1000.0, "N s/m")
    c_l, c_s = parameter("c_l", 2000.0, "N s/m"), parameter("c_s", 2000.0, "N m s/rad")
    x, y = length("x", speed=1.2), length("y", speed=1.2)
    l = length("l", 1.5, 8.2, speed=0.5)  # noqa: E741  # the rope's length
    theta_x = angle("theta_x", -0.35, 0.35, speed=0.6)
    theta_y = angle("theta_y", -0.35, 0.35, speed=0.6)
    bridge = move(x, SPAN / 2, HEIGHT)
    rail = move(x, y, HEIGHT)
    rope = rail @ rot_y(-theta_x) @ rot_x(theta_y) @ move(0, 0, -l)
    beams = tuple(Box(0.3, SPAN, 0.5, at=(side, 0, 0.35)) for side in (-0.7, 0.7))
    package = (Box(1.2, 1.2, 1.0, at=(0, 0, -0.3)), Box(0.3, 0.3, 0.2, at=(0, 0, 0.3)))
    drum = Cylinder(0.25, 0.8, axis="y", at=(0, 0, 0.45))
    load = Body("load", rope, mass=m, shape=package)
    trolley = Body("trolley", rail, mass=M_t, shape=(Box(1.6, 1.0, 0.2, at=(0, 0, 0.7)), drum))
    girders = Body("bridge", bridge, mass=M_b, shape=beams)
    hoist = Pull("hoist", between=(rail, rope), limit=(8810.0, 10810.0))
    return System(
        "crane",
        bodies=[load, trolley, girders],
        gravity=toward("-z", g),
        inputs=[
            Force("travel", on=girders, along=WORLD.x, limit=3000.0),
            Force("traverse", on=trolley, along=WORLD.y, limit=1200.0),
            hoist,
        ],
        efforts=[
            Viscous(rate(x), c_x),
            Viscous(rate(y), c_y),
            Viscous(rate(l), c_l),
            Viscous(rate(theta_x), c_s),
            Viscous(rate(theta_y), c_s),
        ],
        requirements=[require(hoist.symbol + c_l * rate(l), "the rope only pulls")],
        cables=[Cable((rail, rope), "rope", radius=0.03)],
        flat=_flat(x, y, l, theta_x, theta_y, g),
    )


def _flat(
    x: Coordinate,
    y: Coordinate,
    rope: Coordinate,
    theta_x: Coordinate,
    theta_y: Coordinate,
    g: Expr,
) -> FlatOutputs:
    """Return the coordinates as functions of the load's path, its flat outputs.

    The rope's force and the weight are the only forces on the load, so that the rope points along
    the load's acceleration minus gravity; the small friction of swaying is neglected.

    Source: Fliess, Levine, Martin, Rouchon, Int. J. Control 61(6), 1995, section 4.1.
    """
    drop = rope * cos(theta_x) * cos(theta_y)
    rise = output("Z", 2) + g
    return FlatOutputs(
        outputs=(
            ("X", x + rope * sin(theta_x) * cos(theta_y)),
            ("Y", y + rope * sin(theta_y)),
            ("Z", HEIGHT - drop),
        ),
        determined=(
            (theta_x, -atan(output("X", 2) / rise)),
            (theta_y, -atan(cos(theta_x) * output("Y", 2) / rise)),
            (rope, (HEIGHT - output("Z")) / (cos(theta_x) * cos(theta_y))),
            (x, output("X") - rope * sin(theta_x) * cos(theta_y)),
            (y, output("Y") - rope * sin(theta_y)),
        ),
    )


def two_cranes() -> System:
    """Two trolleys on one runway, each with a load on a rope; only the hall joins them.

    Trolleys and hoists are driven: their accelerations are the inputs. The sway of both loads is
    damped by c_s. A rope cannot push, so that a plan must keep both taut.

    Source: Abdel-Rahman, Nayfeh, Masoud, Dynamics and control of cranes: a review, J. Vibration
    and Control 9, 2003.
    """
    m, g = parameter("m", 5.0, "kg"), parameter("g", 9.81, "m/s^2")
    c_s = parameter("c_s", 0.5, "N m s/rad")
    one, two = _crane("a", m, g, c_s), _crane("b", m, g, c_s)
    parts: dict[str, Any] = {part: [*one[part], *two[part]] for part in one}
    return System(
        "two_cranes",
        gravity=toward("-z", g),
        collisions=[("trolley_a", "trolley_b"), ("load_a", "load_b")],
        **parts,
    )


def _crane(name: str, m: Parameter, g: Parameter, c_s: Parameter) -> dict[str, Any]:
    """Return one crane's parts of the system, by the name of ``System``'s argument."""
    x = length(f"x_{name}", 0.5, 11.5, speed=1.5)
    l = length(f"l_{name}", 1.0, 5.5, speed=1.0)  # noqa: E741  # the rope's length
    s = angle(f"sway_{name}", -0.6, 0.6, speed=1.5)
    rail = move(x, 0, 6.0)  # [m] height of the two trolleys above the floor
    rope = rail @ rot_y(-s)  # hangs straight down at s = 0 and swings towards +x
    trolley = Body(f"trolley_{name}", rail, mass=20.0, shape=Box(0.8, 0.6, 0.2))
    load = Body(f"load_{name}", rope @ move(0, 0, -l), mass=m, shape=Box(0.6, 0.6, 0.6))
    travel = Drive(f"travel_{name}", on=x, limit=1.0)
    hoist = Drive(f"hoist_{name}", on=l, limit=1.0)
    pull = g * cos(s) - travel.symbol * sin(s) - hoist.symbol + l * rate(s) ** 2
    return {
        "bodies": [load, trolley],
        "cables": [Cable((rail, load.frame), f"rope {name}")],
        "inputs": [travel, hoist],
        "efforts": [Viscous(rate(s), c_s)],
        "requirements": [require(m * pull, f"rope {name} pulls")],
    }

"""Two gantry cranes on one runway: separate mechanisms in one workspace."""

from typing import Any

import sympy

from kinolab.dynamics import (
    Body,
    Box,
    Cable,
    Drive,
    Parameter,
    System,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    require,
    rot_y,
    toward,
)

HEIGHT = 6.0  # [m] of the runway above the floor


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
    rail = move(x, 0, HEIGHT)
    rope = rail @ rot_y(-s)  # hangs straight down at s = 0 and swings towards +x
    trolley = Body(f"trolley_{name}", rail, mass=20.0, shape=Box(0.8, 0.6, 0.2))
    load = Body(f"load_{name}", rope @ move(0, 0, -l), mass=m, shape=Box(0.6, 0.6, 0.6))
    travel = Drive(f"travel_{name}", on=x, limit=1.0)
    hoist = Drive(f"hoist_{name}", on=l, limit=1.0)
    pull = g * sympy.cos(s) - travel.symbol * sympy.sin(s) - hoist.symbol + l * rate(s) ** 2
    return {
        "bodies": [load, trolley],
        "cables": [Cable((rail, load.frame), f"rope {name}")],
        "inputs": [travel, hoist],
        "efforts": [Viscous(rate(s), c_s)],
        "requirements": [require(m * pull, f"rope {name} pulls")],
    }

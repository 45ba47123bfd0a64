"""Machines with closed loops or axles that do not slip, and what these demand in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import cos, sin

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Capsule,
    Drive,
    System,
    Torque,
    angle,
    closed,
    force_of,
    length,
    move,
    parameter,
    require,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)
from kinolab.dynamics.language.json.machine_file import machine_to_json

Array = NDArray[np.float64]

CRANK, COUPLER, ROCKER, GROUND = 1.0, 2.0, 1.8, 2.2  # [m]
BEAM, STRING = 0.8, 1.0  # [m]
PIVOT, RAIL = 1.2, 2.0  # [m] above the ground
REACH, FRONT = 0.3, 0.2  # [m] from the rear axle to the joint, from there to the front axle


def four_bar() -> System:
    """A crank, a coupler and a rocker on a frame; b is the angle between crank and coupler."""
    a, b, c = angle("a", speed=5.0), angle("b"), angle("c")
    crank = rot_z(a)
    coupler = crank @ move(CRANK) @ rot_z(b)
    rocker = move(GROUND) @ rot_z(c)
    bars = [
        Body(name, frame @ move(reach / 2), mass=mass, inertia=(0.001, J, J), shape=bar(reach))
        for name, frame, reach, mass, J in (
            ("crank", crank, CRANK, 0.5, 0.04),
            ("coupler", coupler, COUPLER, 1.0, 0.3),
            ("rocker", rocker, ROCKER, 0.8, 0.2),
        )
    ]
    along = CRANK * cos(a) + COUPLER * cos(a + b) - GROUND - ROCKER * cos(c)
    across = CRANK * sin(a) + COUPLER * sin(a + b) - ROCKER * sin(c)
    return System(
        "four_bar",
        bodies=bars,
        constraints=[closed(along, "the loop along x"), closed(across, "the loop along y")],
        inputs=[Torque("motor", on=bars[0], about=WORLD.z, limit=5.0)],
        velocities=[a],
    )


def bar(reach: float) -> Capsule:
    return Capsule(0.05, reach, axis="x")


def four_bar_state(a: float, rate: float = 0.0) -> Array:
    """The state (a, b, c, a_dot) with the rocker above: where two circles meet."""
    tip, pivot = CRANK * np.exp(1j * a), GROUND + 0j
    apart = abs(pivot - tip)
    along = (COUPLER**2 - ROCKER**2 + apart**2) / (2 * apart)
    joint = tip + (pivot - tip) / apart * (along + 1j * np.sqrt(COUPLER**2 - along**2))
    b, c = np.angle((joint - tip) / np.exp(1j * a)), np.angle(joint - pivot)
    return np.array([a, b, c, rate])


def freudenstein(a: Array, c: Array) -> Array:
    """What Freudenstein's equation misses zero by, divided by its largest term.

    Source: Freudenstein, Approximate synthesis of four-bar linkages, Trans. ASME 77, 1955.
    """
    first, second = GROUND / CRANK, GROUND / ROCKER
    third = (CRANK**2 - COUPLER**2 + ROCKER**2 + GROUND**2) / (2 * CRANK * ROCKER)
    return (first * np.cos(c) - second * np.cos(a) + third - np.cos(a - c)) / first


def hung_arm() -> System:
    """An arm whose end hangs by a string from a trolley that is driven along a rail."""
    s, a = length("s", -2, 2, speed=1.0), angle("a", -1.2, 1.2, speed=4.0)
    trolley, beam = move(s, 0, RAIL), move(0, 0, PIVOT) @ rot_y(-a)
    rod = Body("arm", beam @ move(BEAM / 2), mass=1.0, inertia=(0.01, 0.05, 0.05), shape=bar(BEAM))
    cart = Body("trolley", trolley, mass=2.0, shape=Box(0.2, 0.2, 0.1))
    ahead, above = BEAM * cos(a) - s, PIVOT + BEAM * sin(a) - RAIL
    string = closed(sympy.sqrt(ahead**2 + above**2) - STRING, "string")
    return System(
        "hung_arm",
        bodies=[rod, cart],
        gravity=toward("-z", 9.81),
        constraints=[string],
        inputs=[Drive("trolley_drive", on=s, limit=1.0)],
        requirements=[require(-force_of(string), "the string only pulls")],
        cables=[(trolley, beam @ move(BEAM))],
    )


def hung_arm_place(a: Array) -> Array:
    """Where the trolley is, nearer to the pivot than the arm's end."""
    above = PIVOT + BEAM * np.sin(a) - RAIL
    place: Array = BEAM * np.cos(a) - np.sqrt(STRING**2 - above**2)
    return place


def string_length(s: Array, a: Array) -> Array:
    """How far the arm's end is from the trolley."""
    return np.hypot(BEAM * np.cos(a) - s, PIVOT + BEAM * np.sin(a) - RAIL)


def roller_racer() -> System:
    """Two axles that do not slip, joined by a pivot, with every rate as a state."""
    x, y, th, ph = length("x"), length("y"), angle("th"), angle("ph", -1.4, 1.4)
    rear = move(x, y) @ rot_z(th)
    joint = rear @ move(parameter("l", REACH, "m")) @ rot_z(ph)
    front = joint @ move(parameter("d", FRONT, "m"))
    seat = Body("seat", rear, mass=1.0, inertia=(0.1, 0.1, 0.1), shape=Box(0.3, 0.1, 0.05))
    bar = Body("bar", front, mass=0.2, inertia=(0.01, 0.01, 0.01), shape=Box(0.1, 0.1, 0.05))
    return System(
        "roller_racer",
        bodies=[seat, bar],
        constraints=[
            zero(velocity(rear).y, "the rear axle"),
            zero(velocity(front).y, "the front axle"),
        ],
        inputs=[Torque("steer", on=bar, about=rear.z, reacts_on=seat, limit=1.0)],
        velocities="all",
    )


def rows_of_racer(th: float, ph: float) -> Array:
    """How fast both axles slip per x_dot, y_dot, th_dot, ph_dot, from a drawing."""
    rear = [-np.sin(th), np.cos(th), 0.0, 0.0]
    far = REACH * np.cos(ph) + FRONT
    front = [-np.sin(th + ph), np.cos(th + ph), far, FRONT]
    return np.array([rear, front])


def written(folder: Path, system: System, text: str) -> Path:
    """Write a machine and a scenario for it into a folder; return the scenario's path."""
    (folder / "machine.json").write_text(machine_to_json(system), encoding="utf-8")
    head = f'schema = 1\ntitle = "{system.name}"\n[system]\nfile = "machine.json"\n'
    path = folder / f"{system.name}.toml"
    path.write_text(head + text, encoding="utf-8")
    return path


def section(name: str, values: dict[str, float]) -> str:
    """Return numbers as a section of a scenario, all digits written out."""
    return f"[{name}]\n" + "".join(f"{key} = {float(v)!r}\n" for key, v in values.items())

"""A satellite with three reaction wheels, and one of whose wheels has failed."""

from __future__ import annotations

from collections.abc import Sequence

from kinolab.dynamics import (
    Body,
    Box,
    Coordinate,
    Coulomb,
    Cylinder,
    Disk,
    Frame,
    Parameter,
    System,
    Torque,
    Viscous,
    angle,
    move,
    orient,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    rotation,
)
from kinolab.dynamics.language.shapes import AxisName

GOLD, BLUE, DARK, GREY = (0.87, 0.69, 0.3), (0.16, 0.27, 0.52), (0.2, 0.22, 0.26), (0.6, 0.62, 0.65)

TURNS = {"x": rot_x, "y": rot_y, "z": rot_z}
SEATS = {"x": (-0.3, -0.2, 0.8), "y": (-0.1, 0.22, 0.8), "z": (0.25, -0.2, 0.68)}  # [m]
TUBE = (Cylinder(0.26, 0.9, axis="x", at=(0.95, 0, 0)), Cylinder(0.3, 0.12, "x", (1.4, 0, 0)))
WINGS = tuple(
    part
    for side in (1.0, -1.0)
    for part in (
        Box(0.05, 0.4, 0.05, at=(0, side * 0.7, 0)),
        Box(0.8, 0.95, 0.03, at=(0, side * 1.375, 0)),
        Box(0.8, 0.95, 0.03, at=(0, side * 2.375, 0)),
    )
)
DISH = (Cylinder(0.03, 0.2, at=(-0.2, 0, -0.7)), Cylinder(0.3, 0.04, at=(-0.2, 0, -0.8)))


def satellite() -> System:
    """A space telescope that three reaction wheels turn; nothing else acts on it.

    The total angular momentum of bus and wheels is conserved. The telescope looks along x. The
    moments of inertia J are those of the whole satellite with its wheels locked; its position does
    not affect its attitude and is not modelled. The bearings of the wheels have viscous friction c
    and dry friction tau_c, both zero by default.

    Source: Wie, Space Vehicle Dynamics and Control, 2nd ed., 2008, chapter 7; Hughes, Spacecraft
    Attitude Dynamics, 1986.
    """
    return _satellite_with("satellite", ("x", "y", "z"))


def satellite_two_wheels() -> System:
    """The space telescope after its wheel about z has stopped for good.

    Without angular momentum it still reaches every attitude: turning about x and y, back and forth,
    turns it about z. With angular momentum it cannot reach all of them.

    Source: Crouch, Spacecraft attitude control and stabilization: applications of geometric control
    theory to rigid body models, IEEE Trans. Automatic Control 29(4), 1984.
    """
    return _satellite_with("satellite_two_wheels", ("x", "y"))


def _satellite_with(name: str, wheels: Sequence[AxisName]) -> System:
    """Return a satellite with reaction wheels about some of its axes.

    A wheel's transverse moment of inertia is half its axial one. Failed wheels are part of the bus.
    """
    bus, I_w = orient(rotation("R", speed=0.1)), parameter("I_w", 0.01, "kg m^2")
    # Moments [kg m^2] of the whole satellite with its wheels locked
    moments = [
        parameter(f"J_{axis}", J, "kg m^2") - sum(I_w if w == axis else I_w / 2 for w in wheels)
        for axis, J in zip("xyz", (10.0, 12.0, 8.0), strict=True)
    ]
    hull = Body("bus", bus, inertia=tuple(moments), shape=Box(1.0, 1.0, 1.2), color=GOLD)
    outfit = [  # whose inertia is included in the bus's
        Body("telescope", bus, shape=TUBE, color=DARK),
        Body("solar panels", bus, shape=WINGS, color=BLUE),
        Body("antenna", bus, shape=DISH, color=GREY),
    ]
    # At most 4000 turns a minute; a wheel turns by about 1000 rad in a manoeuvre.
    angles = {axis: angle(f"wheel_{axis}", speed=418.9, scale=1000.0) for axis in wheels}
    turning = {axis: _wheel(bus, axis, q, I_w) for axis, q in angles.items()}
    return System(
        name,
        bodies=[hull, *outfit, *turning.values()],
        inputs=[
            Torque(
                f"tau_{axis}",
                on=wheel,
                about=getattr(bus, axis),
                limit=0.1,  # [N m]
                reacts_on=hull,
            )
            for axis, wheel in turning.items()
        ],
        efforts=[friction for q in angles.values() for friction in _bearing(q)],
    )


def _wheel(bus: Frame, axis: AxisName, q: Coordinate, I_w: Parameter) -> Body:
    moments = tuple(I_w if axis == other else I_w / 2 for other in "xyz")
    seat = bus @ move(*SEATS[axis]) @ TURNS[axis](q)
    return Body(f"{axis} wheel", seat, inertia=moments, shape=Disk(0.17, 0.07, axis=axis))


def _bearing(q: Coordinate) -> tuple[Viscous, Coulomb]:
    """Friction between a wheel and the bus; zero by default."""
    viscous, dry = parameter("c", 0.0, "N m s/rad"), parameter("tau_c", 0.0, "N m")
    # 0.1 [rad/s] of dry friction in a bearing
    return Viscous(rate(q), viscous), Coulomb(rate(q), dry, 0.1)

"""A satellite with three reaction wheels."""

from kinolab.dynamics import System
from kinolab.systems._satellite import satellite_with


def satellite() -> System:
    """A space telescope that three reaction wheels turn; nothing else acts on it.

    The total angular momentum of bus and wheels is conserved. The telescope looks along x. The
    moments of inertia J are those of the whole satellite with its wheels locked; its position does
    not affect its attitude and is not modelled. The bearings of the wheels have viscous friction c
    and dry friction tau_c, both zero by default.

    Source: Wie, Space Vehicle Dynamics and Control, 2nd ed., 2008, chapter 7; Hughes, Spacecraft
    Attitude Dynamics, 1986.
    """
    return satellite_with("satellite", ("x", "y", "z"))

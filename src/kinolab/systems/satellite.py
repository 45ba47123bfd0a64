"""A satellite with three reaction wheels."""

from kinolab.dynamics import System
from kinolab.systems._satellite import satellite_with


def satellite() -> System:
    """A space telescope that three reaction wheels turn; nothing else acts on it.

    Whatever the wheels take up the bus gives: the angular momentum of both together stays. The
    telescope looks along x. The moments of inertia J are those of the whole satellite with its
    wheels held; where it is does not matter to how it turns, so that it has no place. The bearings
    of the wheels are free of friction unless c (viscous) and tau_c (dry) say otherwise.

    Source: Wie, Space Vehicle Dynamics and Control, 2nd ed., 2008, chapter 7; Hughes, Spacecraft
    Attitude Dynamics, 1986.
    """
    return satellite_with("satellite", ("x", "y", "z"))

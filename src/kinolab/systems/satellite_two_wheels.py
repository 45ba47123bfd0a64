"""A satellite one of whose three reaction wheels has failed."""

from kinolab.dynamics import System
from kinolab.systems._satellite import satellite_with


def satellite_two_wheels() -> System:
    """The space telescope after its wheel about z has stopped for good.

    Without angular momentum it still reaches every attitude: turning about x and y, back and forth,
    turns it about z. With angular momentum it cannot reach all of them.

    Source: Crouch, Spacecraft attitude control and stabilization: applications of geometric control
    theory to rigid body models, IEEE Trans. Automatic Control 29(4), 1984.
    """
    return satellite_with("satellite_two_wheels", ("x", "y"))

"""Steering: motions through the full dynamics that begin and end exactly where they must.

A sampled control cannot hit a state. What can: a curve of a flat machine's outputs, feedback about
an equilibrium or along a motion, and a boundary-value problem. All give the same: inputs, one row
per propagation step, and the states that these inputs lead through.
"""

from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.steering.goal_connection import GoalConnection
from kinolab.steering.maneuver import Maneuver
from kinolab.steering.nearest_equilibrium import nearest_equilibrium
from kinolab.steering.steering import AbstractSteering, Steering
from kinolab.steering.tracking import TrackingLaw

__all__ = [
    "AbstractSteering",
    "GoalConnection",
    "Maneuver",
    "Steering",
    "TrackingLaw",
    "cyclic_coordinates",
    "nearest_equilibrium",
]

"""Steering: exact connections between two states under the full dynamics.

A sampled control cannot hit a state exactly. These can: curves of a flat machine's outputs,
feedback about an equilibrium or along a trajectory, and boundary-value problems. All return inputs,
one row per propagation step, and the states that they lead through.
"""

from kinolab.steering.cyclic_coordinates import cyclic_coordinates as cyclic_coordinates
from kinolab.steering.goal_connection import GoalConnection as GoalConnection
from kinolab.steering.maneuver import Maneuver as Maneuver
from kinolab.steering.nearest_equilibrium import nearest_equilibrium as nearest_equilibrium
from kinolab.steering.steering import Steering as Steering
from kinolab.steering.tracking import TrackingLaw as TrackingLaw

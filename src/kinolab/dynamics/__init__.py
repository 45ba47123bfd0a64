"""Symbolic mechanics in, compiled equations of motion out.

The names exported here are the vocabulary for machines of one's own.
"""

from kinolab.dynamics.bodies import Body
from kinolab.dynamics.constraints import Constraint, zero
from kinolab.dynamics.efforts import Force, Gravity, Torque, toward
from kinolab.dynamics.frames import (
    WORLD,
    Axis,
    BodyVelocity,
    Frame,
    move,
    rot_x,
    rot_y,
    rot_z,
    velocity,
)
from kinolab.dynamics.model import Model
from kinolab.dynamics.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.dynamics.symbols import (
    Coordinate,
    Parameter,
    Rate,
    angle,
    length,
    parameter,
    rate,
)
from kinolab.dynamics.system import System

__all__ = [
    "WORLD",
    "Axis",
    "Body",
    "BodyVelocity",
    "Box",
    "Capsule",
    "Constraint",
    "Coordinate",
    "Cylinder",
    "Disk",
    "Force",
    "Frame",
    "Gravity",
    "Model",
    "Parameter",
    "Rate",
    "Shape",
    "Sphere",
    "System",
    "Torque",
    "angle",
    "length",
    "move",
    "parameter",
    "rate",
    "rot_x",
    "rot_y",
    "rot_z",
    "toward",
    "velocity",
    "zero",
]

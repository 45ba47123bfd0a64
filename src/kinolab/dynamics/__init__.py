"""Symbolic mechanics in, compiled equations of motion out.

The names exported here are the vocabulary for machines of one's own.
"""

from kinolab.dynamics.bodies import Body
from kinolab.dynamics.cables import Cable
from kinolab.dynamics.constraints import (
    Constraint,
    Requirement,
    closed,
    force_of,
    require,
    zero,
)
from kinolab.dynamics.efforts import (
    Buoyancy,
    Coulomb,
    Gravity,
    Potential,
    Spring,
    Viscous,
    Wrench,
    toward,
)
from kinolab.dynamics.extras import State, lag, state
from kinolab.dynamics.feedback import Feedback, Reference, Regulator
from kinolab.dynamics.flatness import CURVATURE, FlatOutputs, PlaneCurves, output
from kinolab.dynamics.frames import (
    WORLD,
    Axis,
    BodyVelocity,
    Frame,
    hat,
    homogeneous,
    move,
    orient,
    rot_x,
    rot_y,
    rot_z,
    unhat,
    velocity,
)
from kinolab.dynamics.inputs import Control, Drive, Force, Pull, Rate, Torque
from kinolab.dynamics.model import Model
from kinolab.dynamics.riccati import dlqr, lqr, tvlqr
from kinolab.dynamics.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.dynamics.symbols import (
    Attitude,
    Coordinate,
    Parameter,
    acceleration,
    angle,
    length,
    parameter,
    rate,
    rotation,
    turn_rate,
)
from kinolab.dynamics.system import System
from kinolab.dynamics.trimming import Trim, Watched, trim
from kinolab.dynamics.variational import VariationalIntegrator

__all__ = [
    "CURVATURE",
    "WORLD",
    "Attitude",
    "Axis",
    "Body",
    "BodyVelocity",
    "Box",
    "Buoyancy",
    "Cable",
    "Capsule",
    "Constraint",
    "Control",
    "Coordinate",
    "Coulomb",
    "Cylinder",
    "Disk",
    "Drive",
    "Feedback",
    "FlatOutputs",
    "Force",
    "Frame",
    "Gravity",
    "Model",
    "Parameter",
    "PlaneCurves",
    "Potential",
    "Pull",
    "Rate",
    "Reference",
    "Regulator",
    "Requirement",
    "Shape",
    "Sphere",
    "Spring",
    "State",
    "System",
    "Torque",
    "Trim",
    "VariationalIntegrator",
    "Viscous",
    "Watched",
    "Wrench",
    "acceleration",
    "angle",
    "closed",
    "dlqr",
    "force_of",
    "hat",
    "homogeneous",
    "lag",
    "length",
    "lqr",
    "move",
    "orient",
    "output",
    "parameter",
    "rate",
    "require",
    "rot_x",
    "rot_y",
    "rot_z",
    "rotation",
    "state",
    "toward",
    "trim",
    "turn_rate",
    "tvlqr",
    "unhat",
    "velocity",
    "zero",
]

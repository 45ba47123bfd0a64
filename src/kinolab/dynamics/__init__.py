"""Symbolic modelling of mechanical systems, and their compiled equations of motion.

The names exported here are what user-defined machines are written with. They are imported when they
are first asked for: a machine that is in the cache needs none of the symbolic part.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab.dynamics.analysis.decoupling_fields import DecouplingFields as DecouplingFields
    from kinolab.dynamics.analysis.decoupling_fields import decoupling_fields as decoupling_fields
    from kinolab.dynamics.analysis.fields.brackets import VectorField as VectorField
    from kinolab.dynamics.analysis.fields.brackets import lie_bracket as lie_bracket
    from kinolab.dynamics.analysis.fields.growth_vectors import Filtration as Filtration
    from kinolab.dynamics.analysis.fields.growth_vectors import filtration as filtration
    from kinolab.dynamics.analysis.fields.growth_vectors import growth_vector as growth_vector
    from kinolab.dynamics.analysis.fields.involutive import InvolutiveClosure as InvolutiveClosure
    from kinolab.dynamics.analysis.fields.involutive import involutive_closure as involutive_closure
    from kinolab.dynamics.analysis.fields.linear_controllability import (
        LinearControllability as LinearControllability,
    )
    from kinolab.dynamics.analysis.fields.linear_controllability import (
        linear_controllability as linear_controllability,
    )
    from kinolab.dynamics.analysis.fields.small_time import SmallTime as SmallTime
    from kinolab.dynamics.analysis.fields.small_time import SmallTimeVerdict as SmallTimeVerdict
    from kinolab.dynamics.analysis.fields.small_time import (
        small_time_controllability as small_time_controllability,
    )
    from kinolab.dynamics.analysis.fields.system_fields import allowed_motions as allowed_motions
    from kinolab.dynamics.analysis.fields.system_fields import vector_fields as vector_fields
    from kinolab.dynamics.analysis.fields.vector_fields import VectorFields as VectorFields
    from kinolab.dynamics.analysis.flatness_of import flatness_of as flatness_of
    from kinolab.dynamics.analysis.least_dissipation import LeastDissipation as LeastDissipation
    from kinolab.dynamics.analysis.least_dissipation import least_dissipation as least_dissipation
    from kinolab.dynamics.analysis.trim import StateFunctions as StateFunctions
    from kinolab.dynamics.analysis.trim import Trim as Trim
    from kinolab.dynamics.analysis.trim import trim as trim
    from kinolab.dynamics.facts.mode_derivations import in_mode as in_mode
    from kinolab.dynamics.language.bodies import Body as Body
    from kinolab.dynamics.language.bodies import Cable as Cable
    from kinolab.dynamics.language.constraints import Constraint as Constraint
    from kinolab.dynamics.language.constraints import Requirement as Requirement
    from kinolab.dynamics.language.constraints import closed as closed
    from kinolab.dynamics.language.constraints import force_of as force_of
    from kinolab.dynamics.language.constraints import require as require
    from kinolab.dynamics.language.constraints import zero as zero
    from kinolab.dynamics.language.feedback import Feedback as Feedback
    from kinolab.dynamics.language.feedback import Reference as Reference
    from kinolab.dynamics.language.feedback import Regulator as Regulator
    from kinolab.dynamics.language.flatness import CURVATURE as CURVATURE
    from kinolab.dynamics.language.flatness import FlatOutputs as FlatOutputs
    from kinolab.dynamics.language.flatness import PlaneCurves as PlaneCurves
    from kinolab.dynamics.language.flatness import output as output
    from kinolab.dynamics.language.forces import Buoyancy as Buoyancy
    from kinolab.dynamics.language.forces import Coulomb as Coulomb
    from kinolab.dynamics.language.forces import Gravity as Gravity
    from kinolab.dynamics.language.forces import Load as Load
    from kinolab.dynamics.language.forces import Potential as Potential
    from kinolab.dynamics.language.forces import Rope as Rope
    from kinolab.dynamics.language.forces import SlidingFriction as SlidingFriction
    from kinolab.dynamics.language.forces import Spring as Spring
    from kinolab.dynamics.language.forces import Viscous as Viscous
    from kinolab.dynamics.language.forces import Wrench as Wrench
    from kinolab.dynamics.language.forces import toward as toward
    from kinolab.dynamics.language.frames import WORLD as WORLD
    from kinolab.dynamics.language.frames import Axis as Axis
    from kinolab.dynamics.language.frames import BodyVelocity as BodyVelocity
    from kinolab.dynamics.language.frames import Frame as Frame
    from kinolab.dynamics.language.frames import hat as hat
    from kinolab.dynamics.language.frames import homogeneous as homogeneous
    from kinolab.dynamics.language.frames import move as move
    from kinolab.dynamics.language.frames import orient as orient
    from kinolab.dynamics.language.frames import rot_x as rot_x
    from kinolab.dynamics.language.frames import rot_y as rot_y
    from kinolab.dynamics.language.frames import rot_z as rot_z
    from kinolab.dynamics.language.frames import squared_turn as squared_turn
    from kinolab.dynamics.language.frames import unhat as unhat
    from kinolab.dynamics.language.frames import velocity as velocity
    from kinolab.dynamics.language.inputs import Control as Control
    from kinolab.dynamics.language.inputs import Drive as Drive
    from kinolab.dynamics.language.inputs import Force as Force
    from kinolab.dynamics.language.inputs import Pull as Pull
    from kinolab.dynamics.language.inputs import Rate as Rate
    from kinolab.dynamics.language.inputs import Torque as Torque
    from kinolab.dynamics.language.modes import Mode as Mode
    from kinolab.dynamics.language.modes import Transition as Transition
    from kinolab.dynamics.language.quasi_velocities import QuasiVelocity as QuasiVelocity
    from kinolab.dynamics.language.quasi_velocities import State as State
    from kinolab.dynamics.language.quasi_velocities import lag as lag
    from kinolab.dynamics.language.quasi_velocities import state as state
    from kinolab.dynamics.language.shapes import Box as Box
    from kinolab.dynamics.language.shapes import Capsule as Capsule
    from kinolab.dynamics.language.shapes import Cylinder as Cylinder
    from kinolab.dynamics.language.shapes import Disk as Disk
    from kinolab.dynamics.language.shapes import DrawnMesh as DrawnMesh
    from kinolab.dynamics.language.shapes import Shape as Shape
    from kinolab.dynamics.language.shapes import Sphere as Sphere
    from kinolab.dynamics.model.model import Model as Model
    from kinolab.dynamics.symbols.symbols import Attitude as Attitude
    from kinolab.dynamics.symbols.symbols import Coordinate as Coordinate
    from kinolab.dynamics.symbols.symbols import Parameter as Parameter
    from kinolab.dynamics.symbols.symbols import acceleration as acceleration
    from kinolab.dynamics.symbols.symbols import angle as angle
    from kinolab.dynamics.symbols.symbols import clock as clock
    from kinolab.dynamics.symbols.symbols import direction as direction
    from kinolab.dynamics.symbols.symbols import length as length
    from kinolab.dynamics.symbols.symbols import parameter as parameter
    from kinolab.dynamics.symbols.symbols import rate as rate
    from kinolab.dynamics.symbols.symbols import rotation as rotation
    from kinolab.dynamics.symbols.symbols import turn_rate as turn_rate
    from kinolab.dynamics.system import System as System
    from kinolab.numerics.riccati import dlqr as dlqr
    from kinolab.numerics.riccati import lqr as lqr
    from kinolab.numerics.riccati import tvlqr as tvlqr

__all__, __getattr__, __dir__ = lazy_package(__name__, __file__)

"""Symbolic modelling of mechanical systems, and their compiled equations of motion.

The names exported here are what user-defined machines are written with. They are imported when they
are first asked for: a machine that is in the cache needs none of the symbolic part.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab.dynamics.analysis.decoupling_fields import (
        DecouplingFields as DecouplingFields,
        decoupling_fields as decoupling_fields,
    )
    from kinolab.dynamics.analysis.fields import (
        Filtration as Filtration,
        InvolutiveClosure as InvolutiveClosure,
        LinearControllability as LinearControllability,
        SmallTime as SmallTime,
        SmallTimeVerdict as SmallTimeVerdict,
        VectorField as VectorField,
        VectorFields as VectorFields,
        allowed_motions as allowed_motions,
        filtration as filtration,
        growth_vector as growth_vector,
        involutive_closure as involutive_closure,
        lie_bracket as lie_bracket,
        linear_controllability as linear_controllability,
        small_time_controllability as small_time_controllability,
        vector_fields as vector_fields,
    )
    from kinolab.dynamics.analysis.least_dissipation import (
        LeastDissipation as LeastDissipation,
        least_dissipation as least_dissipation,
    )
    from kinolab.dynamics.analysis.trim import (
        StateFunctions as StateFunctions,
        Trim as Trim,
        trim as trim,
    )
    from kinolab.dynamics.language.bodies import Body as Body, Cable as Cable
    from kinolab.dynamics.language.constraints import (
        Constraint as Constraint,
        Requirement as Requirement,
        closed as closed,
        force_of as force_of,
        require as require,
        zero as zero,
    )
    from kinolab.dynamics.language.feedback import (
        Feedback as Feedback,
        Reference as Reference,
        Regulator as Regulator,
    )
    from kinolab.dynamics.language.flatness import (
        CURVATURE as CURVATURE,
        FlatOutputs as FlatOutputs,
        PlaneCurves as PlaneCurves,
        output as output,
    )
    from kinolab.dynamics.language.forces import (
        Buoyancy as Buoyancy,
        Coulomb as Coulomb,
        Gravity as Gravity,
        Load as Load,
        Potential as Potential,
        Rope as Rope,
        SlidingFriction as SlidingFriction,
        Spring as Spring,
        Viscous as Viscous,
        Wrench as Wrench,
        toward as toward,
    )
    from kinolab.dynamics.language.frames import (
        WORLD as WORLD,
        Axis as Axis,
        BodyVelocity as BodyVelocity,
        Frame as Frame,
        hat as hat,
        homogeneous as homogeneous,
        move as move,
        orient as orient,
        rot_x as rot_x,
        rot_y as rot_y,
        rot_z as rot_z,
        unhat as unhat,
        velocity as velocity,
    )
    from kinolab.dynamics.language.inputs import (
        Control as Control,
        Drive as Drive,
        Force as Force,
        Pull as Pull,
        Rate as Rate,
        Torque as Torque,
    )
    from kinolab.dynamics.language.modes import Mode as Mode, Transition as Transition
    from kinolab.dynamics.language.quasi_velocities import (
        QuasiVelocity as QuasiVelocity,
        State as State,
        lag as lag,
        state as state,
    )
    from kinolab.dynamics.language.shapes import (
        Box as Box,
        Capsule as Capsule,
        Cylinder as Cylinder,
        Disk as Disk,
        DrawnMesh as DrawnMesh,
        Shape as Shape,
        Sphere as Sphere,
    )
    from kinolab.dynamics.language.symbols import (
        Attitude as Attitude,
        Coordinate as Coordinate,
        Parameter as Parameter,
        acceleration as acceleration,
        angle as angle,
        length as length,
        parameter as parameter,
        rate as rate,
        rotation as rotation,
        turn_rate as turn_rate,
    )
    from kinolab.dynamics.mode_derivations import in_mode as in_mode
    from kinolab.dynamics.model import Model as Model
    from kinolab.dynamics.system import System as System
    from kinolab.numerics.riccati import dlqr as dlqr, lqr as lqr, tvlqr as tvlqr

__all__, __getattr__, __dir__ = lazy_package(__name__, __file__)

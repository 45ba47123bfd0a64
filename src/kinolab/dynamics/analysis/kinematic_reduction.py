"""Kinematic reductions: a machine without its masses, whose velocities are the inputs."""

from __future__ import annotations

from collections.abc import Sequence

from kinolab.dynamics.derivation.derivation import derive
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.inputs import Limit, Rate
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import tangent_symbols


def kinematic_reduction(system: Mechanism, limits: Sequence[Limit]) -> Mechanism:
    """Return a machine with the same bodies and constraints, moved by velocities that are given.

    If the inputs of a machine accelerate it along every motion that its constraints leave, it can
    follow each path of its reduction, with some time scaling: it is kinematic, not only reducible
    along some vector fields.

    Args:
        system: The machine; it has coordinates in the same order as the reduction.
        limits: Of each independent velocity, in the order of the machine's state, (nv,).

    Raises:
        InputError: If the machine cannot be derived, or has no reduction: its constraints depend on
            inputs or auxiliary states.

    Source: Bullo, Lewis, Geometric Control of Mechanical Systems, 2005, section 8.3; Bullo, Lynch,
    Kinematic controllability for decoupled trajectory planning, IEEE Trans. Robotics and Automation
    17(4), 2001.
    """
    derivation, rates = derive(system), tangent_symbols(system)
    velocities = [
        *((v.name, v.velocity) for v in derivation.quasi),
        *((rates[i].name, rates[i]) for i in derivation.independent),
    ]
    named = zip(velocities, limits, strict=True)
    made = Mechanism(
        system.name,
        bodies=[
            Body(
                body.name,
                body.frame,
                shape=body.shapes,
                touches_ground=body.touches_ground,
                color=body.color,
                whirl=body.whirl,
                drawn=body.drawn,
                located=body.located,
                prescribed=body.prescribed,
            )
            for body in system.bodies
        ],
        constraints=system.constraints,
        inputs=[
            Rate(f"{name}_given", on=velocity, limit=limit) for (name, velocity), limit in named
        ],
        collisions=system.collisions,
        cables=system.cables,
        coordinates=system.coordinates,
    )
    left = {parameter.name for parameter in made.parameters}  # those of masses and forces are gone
    return made.with_parameters(**{name: x for name, x in system.values if name in left})

"""Flat outputs: curves of them determine a motion, its inputs included, without integration."""

from __future__ import annotations

from kinolab.dynamics import System
from kinolab.dynamics.lagrange.printing import one_line
from kinolab.dynamics.language.flatness import PlaneCurves


def flat_outputs_of(system: System, *, pushed_everywhere: bool) -> tuple[str, ...]:
    """Return the flat outputs that a machine says it has, or has because it is fully actuated.

    Args:
        system: The machine.
        pushed_everywhere: Whether inputs push in as many directions as it has degrees of freedom.

    Returns:
        One text each; empty where none is known, which does not mean that there is none.

    Source: Murray, Rathinam, Sluis, Differential flatness of mechanical control systems, 1995,
    section 2.
    """
    if isinstance(system.flat, PlaneCurves):
        point = f"{system.flat.x.name} and {system.flat.y.name}"
        return (f"{point}, of a point that rolls along any smooth curve in the plane",)
    if system.flat is not None:
        return tuple(f"{name} = {one_line(value)}" for name, value in system.flat.outputs)
    if system.constraints or system.states or not pushed_everywhere or not system.inputs:
        return ()
    return ("its coordinates, since inputs push along all of them",)

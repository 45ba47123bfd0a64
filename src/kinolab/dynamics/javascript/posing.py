"""What a page needs to put a machine into a pose by hand: joints' frames, and what constraints say.

A constraint on positions has a gap h(q). One on velocities, w(q) q_dot = 0, says nothing of a pose,
but what it would miss if one coordinate moved alone: the coordinate's entry of w.
"""

from __future__ import annotations

from typing import Any

from kinolab.dynamics.analysis.constraint_units import position_unit, velocity_unit
from kinolab.dynamics.codegen.exports import Function
from kinolab.dynamics.derivation.derivation import Derivation
from kinolab.dynamics.derivation.velocity_coordinates import constraint_rows
from kinolab.dynamics.facts.joint_frames import joint_frames, pose_nodes
from kinolab.dynamics.language.constraints import PositionConstraint


def posing(derivation: Derivation) -> tuple[dict[str, Any], list[Function]]:
    """Return facts and functions for poses.

    Returns:
        Names of ``joints``; name and unit of the constraints on positions, ``loops``, and of those
        on velocities, ``slips``. Then functions of those names: rows [R | p] of each joint, gaps
        h(q), and rows w(q), one entry for each rate.
    """
    binding = derivation.binding
    frames, constraints = joint_frames(binding.system), binding.system.constraints
    loops = [c for c in constraints if isinstance(c, PositionConstraint)]
    known = {*derivation.state, *binding.parameters}  # inputs have no part in a pose
    rows = {
        row.name: row.covector
        for row in constraint_rows(binding)
        if frozenset().union(*map(binding.tape.depends_on, row.covector)) <= known
    }
    slips = [c for c in constraints if not isinstance(c, PositionConstraint) and c.name in rows]
    facts = {
        "joints": list(frames.values()),
        "loops": [{"name": c.name, "unit": position_unit(c)} for c in loops],
        "slips": [{"name": c.name, "unit": velocity_unit(c)} for c in slips],
    }
    found = {
        "joint_frames": pose_nodes(binding.lower, tuple(frames)),
        "gaps": [binding.lower(c.position) for c in loops],
        "slip_rows": [entry for c in slips for entry in rows[c.name]],
    }
    arguments = {"x": derivation.state, "p": binding.parameters}
    return facts, [Function(name, arguments, nodes) for name, nodes in found.items() if nodes]

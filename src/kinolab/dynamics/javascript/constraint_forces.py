"""Bodies and lines of action of constraint forces, for drawing them as arrows.

A constraint w(q) nu = 0 exerts the generalised force w^T lambda, which has no point of application.
But if a body's twist V = J(q) nu determines w, that is w^T = J^T z, then a unit multiplier is the
wrench z on that body, with a line of action: for a rolling wheel, through the contact.

Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, section 2.5
(Poinsot's theorem: every wrench is a force along an axis and a torque about it).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kinolab.dynamics.codegen.exports import Function
from kinolab.dynamics.derivation.derivation import Derivation
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.kinematics import FrameState, Kinematics
from kinolab.dynamics.derivation.sampled_states import feasible_values
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.velocity_coordinates import (
    ConstraintRow,
    constraint_rows,
    unconstrained_coordinates,
)
from kinolab.numerics.arrays import Array

RESIDUAL_TOLERANCE = 1e-8  # relative residual of a covector
TWIST = 6
# others add reactions implicit in the coordinates, such as the ground's support


def constraint_forces(derivation: Derivation) -> tuple[list[dict[str, Any]], list[Function]]:
    """Find the bodies that constraints act on; none for a kinematic machine.

    Returns:
        Facts per constraint with a force: its name, the index of the body it acts on (None where no
        single body explains it), the offset of that body's twist in ``twists``, and whether its
        force can be taken to act at ground level; and functions: ``covectors``, one row w per
        constraint, and ``twists``, six rows of J per body.
    """
    binding = derivation.binding
    rows = _rows(derivation)
    if not rows:
        return [], []
    kinematics = Kinematics(binding, unconstrained_coordinates(binding))
    states = [kinematics(body.frame) for body in binding.system.bodies]
    twists = [_twist(binding, state) for state in states]
    held = _held(binding, rows, states, twists)
    bodies = sorted({body for body, _ in held if body is not None})
    facts = [
        {
            "name": row.name,
            "body": body,
            "twist": None if body is None else bodies.index(body),
            "onGround": on_ground,
        }
        for row, (body, on_ground) in zip(rows, held, strict=True)
    ]
    arguments = {"x": derivation.state, "p": binding.parameters}
    covectors = [entry for row in rows for entry in row.covector]
    chosen = [entry for body in bodies for entry in twists[body]]
    return facts, [
        Function("covectors", arguments, covectors),
        Function("twists", arguments, chosen),
    ]


def _rows(derivation: Derivation) -> list[ConstraintRow]:
    """Return the rows of the constraints whose forces a model lists first, in that order."""
    if not derivation.constraint_forces:
        return []
    rows = constraint_rows(derivation.binding)
    if derivation.binding.system.velocities == "all":
        return rows
    return [row for row in rows if row.name not in derivation.redundant]


def _twist(binding: SymbolTable, state: FrameState) -> list[Node]:
    """Return a body's Jacobian row by row: linear, then angular velocity, in world axes."""
    tape = binding.tape
    columns = [
        [
            *(tape.dot(row, column.linear) for row in state.rotation),
            *(tape.dot(row, column.angular) for row in state.rotation),
        ]
        for column in state.columns
    ]
    return [column[i] for i in range(TWIST) for column in columns]


def _held(
    binding: SymbolTable,
    rows: Sequence[ConstraintRow],
    states: Sequence[FrameState],
    twists: Sequence[Sequence[Node]],
) -> list[tuple[int | None, bool]]:
    """Return, per row, the body it acts on and whether the force may act at ground level."""
    size, bodies = len(binding.tangent), binding.system.bodies
    nodes = [
        *(entry for row in rows for entry in row.covector),
        *(entry for twist in twists for entry in twist),
        *(entry for state in states for entry in state.position),
    ]
    samples = []
    for values in feasible_values(binding):
        flat = np.array(binding.tape.evaluate(nodes, values))
        w, J, p = np.split(flat, np.cumsum([len(rows) * size, len(twists) * TWIST * size]))
        samples.append((w.reshape(-1, size), J.reshape(-1, TWIST, size), p.reshape(-1, 3)))
    order = sorted(range(len(states)), key=lambda b: not bodies[b].touches_ground)
    found: list[tuple[int | None, bool]] = []
    for r in range(len(rows)):
        body = next((b for b in order if all(_decides(J[b], w[r]) for w, J, _ in samples)), None)
        lowered = (
            body is not None
            and bodies[body].touches_ground
            and all(_may_lie_on_ground(J[body], w[r], p[body]) for w, J, p in samples)
        )
        found.append((body, lowered))
    return found


def _decides(J: Array, w: Array) -> bool:
    return _left_over(J, w, _wrench(J, w)) <= RESIDUAL_TOLERANCE


def _may_lie_on_ground(J: Array, w: Array, position: Array) -> bool:
    """Whether the force does the same through the point of z = 0 below or above its axis."""
    wrench = _wrench(J, w)
    force, torque = wrench[:3], wrench[3:]
    square = force @ force
    if square < RESIDUAL_TOLERANCE * (w @ w):
        return False  # a pure torque has no line of action
    arm = np.cross(force, torque) / square
    arm[2] = -position[2]
    lowered = np.concatenate([force, np.cross(arm, force)])
    return _left_over(J, w, lowered) <= RESIDUAL_TOLERANCE


def _wrench(J: Array, w: Array) -> Array:
    # 100.0 [m]; of equivalent wrenches the one with less force is taken, for
    weights = np.array([1.0] * 3 + [100.0] * 3)
    wrench: Array = weights * np.linalg.lstsq(J.T * weights, w, rcond=None)[0]
    return wrench


def _left_over(J: Array, w: Array, wrench: Array) -> float:
    return float(np.linalg.norm(J.T @ wrench - w) / np.linalg.norm(w))

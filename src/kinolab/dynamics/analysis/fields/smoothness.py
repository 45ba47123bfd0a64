"""Kinks of the equations of motion, where Lie brackets do not exist."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from kinolab.dynamics.analysis.fields.vector_fields import VectorFields

KINKED = ("fabs", "sign", "fmax")
KINK_TOLERANCE = 1e-9  # of an argument's distance to its kink


def has_kink(fields: VectorFields, point: Mapping[str, Any]) -> bool:
    """Return whether an absolute value, or similar, has its kink at a state.

    Args:
        fields: Of a machine.
        point: Value of every state entry, by name.
    """
    tape, moving = fields.tape, frozenset(fields.state)
    outputs = [node for parts in fields.components.values() for node in parts]
    kinks = [
        operation.operands
        for operation in map(tape.operations.__getitem__, tape.needed(outputs))
        if operation.name in KINKED and any(tape.depends_on(o) & moving for o in operation.operands)
    ]
    if not kinks:
        return False
    values = {name: float(value) for name, value in (dict(fields.values) | dict(point)).items()}
    gaps = [tape.sub(pair[0], pair[1]) if len(pair) > 1 else pair[0] for pair in kinks]
    return min(map(abs, tape.evaluate(gaps, values))) < KINK_TOLERANCE

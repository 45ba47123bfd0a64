"""Where equations of motion have kinks: brackets need more derivatives than there are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from kinolab.dynamics.analysis.fields.vector_fields import VectorFields

KINKED = ("fabs", "sign", "fmax")
KINK_TOLERANCE = 1e-9  # of an argument: what counts as being at a kink


def has_kink(fields: VectorFields, point: Mapping[str, Any]) -> bool:
    """Say whether an absolute value, or the like, changes sides at a state.

    Args:
        fields: Of a machine.
        point: Value of every entry of the state, by name.
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

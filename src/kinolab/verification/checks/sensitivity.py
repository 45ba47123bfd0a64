"""Can the motion be repeated?"""

from __future__ import annotations

from kinolab.simulation.reference import MAX_ERROR_AMPLIFICATION
from kinolab.verification.check import Check, CheckContext, judged


def error_growth(context: CheckContext) -> Check:
    """Perturb the start and see how much farther from the motion the other one ends."""
    growth, detail = context.error_growth
    return judged("error growth", growth, MAX_ERROR_AMPLIFICATION, detail)

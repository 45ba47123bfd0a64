"""Can a trajectory be integrated at all?"""

from __future__ import annotations

import numpy as np

from kinolab.verification.check import Check, CheckContext, judged

# of a step of a discrete problem, by which it may differ: times add up with rounding
STEP_TOLERANCE = 1e-6


def numbers(context: CheckContext) -> Check:
    """Check that all numbers are finite; the value counts those that are not."""
    tables = {name: getattr(context.stored, name) for name in ("t", "x", "u", "references")}
    broken = [name for name, table in tables.items() if not np.isfinite(table).all()]
    count = sum(int((~np.isfinite(table)).sum()) for table in tables.values())
    return judged("numbers", float(count), 0.0, f"not finite: {', '.join(broken)}")


def times(context: CheckContext) -> Check:
    """Times start at 0 and increase, by whole steps where these are what the problem is made of.

    The value counts the steps that do not.
    """
    t, problem = context.stored.t, context.problem
    steps = np.diff(t)
    bad, detail = np.flatnonzero(~(steps > 0)), "row {} does not come after the row before"
    if not bad.size and problem.scenario.integration.truth == "discrete":
        whole = np.isclose(steps, problem.step, rtol=STEP_TOLERANCE, atol=0.0)
        bad, detail = np.flatnonzero(~whole), "row {} does not come one step after the row before"
    late = abs(float(t[0])) > 0
    text = detail.format(bad[0] + 1) if bad.size else "t starts late"
    return judged("time", float(bad.size + late), 0.0, text)

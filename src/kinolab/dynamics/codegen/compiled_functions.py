"""Names and status codes of a machine's functions: what is emitted, and what calls it."""

from __future__ import annotations

SINGULAR, NOT_FINITE, CHATTERS = 1, 2, 4  # bits of the status that a function returns
NEED_CHART = ("velocity", "constraint_residual", "constraint_forces", "energy", "power")
PREFIX = "closed_"  # of functions with feedback
RATES = (  # functions of (x, u, p, out, mode)
    *("f", "velocity", "point_speed", "cable_speed", "energy", "power"),
    *("constraint_residual", "constraint_forces", "requirements"),
)
# of a machine with modes: whether one ends, and how
SWITCHES = ("leaves", "guards", "reset", "through")
# have a twin of references, and so have the steps
CLOSED_LOOP_FUNCTIONS = (*RATES, "tangent", "jacobian", "rows_under")

"""The checks of a certificate, in order.

To add a check, write a function in a file of its own that takes a ``CheckContext`` and returns a
``Check``, or None where there is nothing to check; then add it to ``CHECKS``.
"""

from collections.abc import Callable

from kinolab.verification.checks.along_motion import limits, requirements
from kinolab.verification.checks.check import Check, CheckContext
from kinolab.verification.checks.contacts import collision
from kinolab.verification.checks.equations_of_motion import equations
from kinolab.verification.checks.goal_reached import goal, goals_on_the_way
from kinolab.verification.checks.knot_defects import drift, dynamics, error_growth, start
from kinolab.verification.checks.mode_begins import transitions
from kinolab.verification.checks.stored_rows import (
    constraints,
    duration,
    feedback,
    inputs,
    numbers,
    times,
)

CheckFunction = Callable[[CheckContext], Check | None]

CHECKS: tuple[CheckFunction, ...] = (
    numbers,
    times,
    duration,
    start,
    dynamics,
    equations,
    constraints,
    transitions,
    inputs,
    feedback,
    requirements,
    error_growth,
    drift,
    limits,
    goals_on_the_way,
    goal,
    collision,
)

PRECONDITIONS = frozenset({numbers, times})  # if they fail, nothing can be integrated
# is the motion consistent with the dynamics and the inputs?
DYNAMICS = frozenset(
    {start, dynamics, constraints, transitions, inputs, feedback, requirements, error_growth}
)
# properties of any motion, however it was computed
CONDUCT = frozenset({requirements, limits, goals_on_the_way, goal, collision})

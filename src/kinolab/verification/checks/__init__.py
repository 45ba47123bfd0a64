"""All that a plan is checked for, in the order of the certificate.

To add a check, write a function in a file of its own that takes a ``CheckContext`` and returns a
``Check``, or None where there is nothing to check; then give it its place in ``CHECKS``.
"""

from collections.abc import Callable

from kinolab.verification.check import Check, CheckContext
from kinolab.verification.checks.along_motion import limits, requirements
from kinolab.verification.checks.contacts import collision
from kinolab.verification.checks.goal_reached import goal
from kinolab.verification.checks.knot_defects import drift, dynamics, error_growth, start
from kinolab.verification.checks.stored_rows import (
    constraints,
    feedback,
    inputs,
    numbers,
    times,
)

CheckFunction = Callable[[CheckContext], Check | None]

CHECKS: tuple[CheckFunction, ...] = (
    numbers,
    times,
    start,
    dynamics,
    constraints,
    inputs,
    feedback,
    requirements,
    error_growth,
    drift,
    limits,
    goal,
    collision,
)

PRECONDITIONS = frozenset({numbers, times})  # where they fail, nothing can be integrated
# does the machine move like this under these inputs?
DYNAMICS = frozenset({start, dynamics, constraints, inputs, feedback, requirements, error_growth})
# what a motion does on its way, whatever made it
CONDUCT = frozenset({requirements, limits, goal, collision})

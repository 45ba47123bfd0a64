"""Tests of one's own: motions that are true, machines that are sound, exercises that are right."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_names

if TYPE_CHECKING:
    from kinolab.testing.assertions import assert_collision_free, assert_dynamically_feasible
    from kinolab.testing.exercises import Mark, check
    from kinolab.testing.grading import Report, grade, grade_class

__all__ = [
    "Mark",
    "Report",
    "assert_collision_free",
    "assert_dynamically_feasible",
    "check",
    "grade",
    "grade_class",
]

__getattr__ = lazy_names(  # who asserts needs neither SymPy nor the exercises
    __name__,
    {
        "kinolab.testing.assertions": ("assert_collision_free", "assert_dynamically_feasible"),
        "kinolab.testing.exercises": ("Mark", "check"),
        "kinolab.testing.grading": ("Report", "grade", "grade_class"),
    },
)

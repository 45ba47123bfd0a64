"""Tests of one's own: motions that are true, machines that are sound, exercises that are right."""

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

"""Tests of one's own: motions that are true, machines that are sound, exercises that are right."""

from typing import TYPE_CHECKING

from kinolab.lazy import lazy_package

if TYPE_CHECKING:
    from kinolab.testing.assertions import assert_collision_free as assert_collision_free
    from kinolab.testing.assertions import (
        assert_dynamically_feasible as assert_dynamically_feasible,
    )
    from kinolab.testing.exercises import Mark as Mark
    from kinolab.testing.exercises import check as check
    from kinolab.testing.grade_report import Report as Report
    from kinolab.testing.grading import grade as grade
    from kinolab.testing.grading import grade_class as grade_class

# who asserts needs neither SymPy nor the exercises
__all__, __getattr__, __dir__ = lazy_package(__name__, __file__)

"""The exercises of the course, and what an answer to one of them is worth."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from kinolab.arguments import require_fit
from kinolab.errors import InputError, Mistake, counted
from kinolab.testing import chapters
from kinolab.testing.answers.judging import Exercise, WrongAnswerError

RECORD = "KINOLAB_GRADES"  # environment: the address at which a grader judges answers


@dataclass(frozen=True)
class Mark:
    """What an answer is worth.

    Attributes:
        exercise: Its name.
        points: What was reached.
        of: What there is.
        reason: What is not right; empty where all is.
        due: The same with what would be right, where that may be said.
    """

    exercise: str
    points: int
    of: int
    reason: str = ""
    due: str = ""

    def __bool__(self) -> bool:
        """Whether the answer is right."""
        return not self.reason

    def __repr__(self) -> str:
        """Say it in words."""
        if self.reason:
            return f"{self.exercise}: not yet: {self.due or self.reason}"
        return f"{self.exercise}: right, {counted(self.points, 'point')}"


def check(exercise: str, answer: Any) -> Mark:
    """Compare the answer to an exercise of the course with the right one.

    Where the environment has ``KINOLAB_DUE=1``, a wrong answer is told with what would be right.

    Args:
        exercise: Its name, such as ``"3.1"``.
        answer: What the exercise asks for: a number, a function, or a machine.

    Raises:
        InputError: If there is no such exercise.
    """
    require_fit("check exercise", str, exercise)
    known = exercises()
    if exercise not in known:
        what, remedy = f"there is no exercise {exercise!r}.", f"There are {', '.join(known)}."
        raise InputError([Mistake("check", what, remedy)])
    grader = os.environ.get(RECORD)
    if grader:
        from kinolab.testing.answers.answers_from_afar import mark_from_afar

        mark = Mark(**mark_from_afar(grader, exercise, answer))
    else:
        mark = judged(known[exercise], answer)
        # With this variable, reasons say what would be right
        mark = mark if os.environ.get("KINOLAB_DUE") else replace(mark, due="")
    # With this variable, wrong answers are errors, as in the book
    if os.environ.get("KINOLAB_SOLUTIONS") and not mark:
        raise AssertionError(repr(mark))
    return mark


def judged(exercise: Exercise, answer: Any) -> Mark:
    """Return what an answer to an exercise is worth."""
    if answer is ...:
        return Mark(exercise.name, 0, exercise.points, "there is no answer.")
    try:
        exercise.judge(answer)
    except WrongAnswerError as error:
        return Mark(exercise.name, 0, exercise.points, str(error), error.said(due=True))
    return Mark(exercise.name, exercise.points, exercise.points)


@cache
def exercises() -> dict[str, Exercise]:
    """Return all exercises by name, chapter by chapter."""
    names = sorted(module.name for module in iter_modules(chapters.__path__))
    modules = [import_module(f"{chapters.__name__}.{name}") for name in names]
    return {each.name: each for module in modules for each in module.EXERCISES}

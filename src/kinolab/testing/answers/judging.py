"""How answers are compared with what is right: numbers, functions and machines.

What is right is written beside each exercise in closed form; nothing here derives it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinolab.dynamics import Model, System
from kinolab.errors import KinolabError

TOLERANCE = 1e-6  # of an answer's size
THREE_DIGITS = 5e-3  # of its size: what rounding to three significant digits may change


class WrongAnswerError(Exception):
    """An answer that is not right; says where it differs.

    Args:
        told: What is not right: a sentence, or one that ends in what ``due`` is due for.
        due: What would be right, for those whom a teacher allows to see it.
    """

    def __init__(self, told: str, due: str = "") -> None:
        self.told, self.due = told, due
        super().__init__(f"{told}, which is not right." if due else told)

    def said(self, due: bool) -> str:
        """Return the sentence, with what would be right if that may be said and is known."""
        return f"{self.told} where {self.due} is due." if due and self.due else str(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.told, self.due)


@dataclass(frozen=True)
class Exercise:
    """One exercise of the course.

    Attributes:
        name: Chapter and number, as ``3.1``.
        points: What it is worth.
        judge: Raises WrongAnswerError for an answer that is not right.
    """

    name: str
    points: int
    judge: Callable[[Any], None]


def require_number(answer: Any, expected: float, unit: str = "", tolerance: float = 1e-3) -> None:
    """Compare a number, to a fraction of its size."""
    try:
        given = float(answer)
    except (TypeError, ValueError) as error:
        raise WrongAnswerError(f"a number is wanted, not {answer!r}.") from error
    if not abs(given - expected) <= tolerance * max(abs(expected), 1e-9):
        unit = f" {unit}" if unit else ""
        raise WrongAnswerError(f"it is {given:g}{unit}", f"{expected:.6g}{unit}")


def require_values(
    answer: Any,
    expected: Callable[..., Any],
    cases: Sequence[tuple[Any, ...]],
    tolerance: float = TOLERANCE,
) -> None:
    """Call an answer, a function, and compare what it returns, numbers or arrays of them.

    Args:
        answer: The function.
        expected: Returns what is right.
        cases: The arguments of each call.
        tolerance: Fraction of the largest entry by which each may differ.
    """
    if not callable(answer):
        raise WrongAnswerError(f"a function is wanted, not {answer!r}.")
    for number, case in enumerate(cases, start=1):
        shown = ", ".join(_short(value) for value in case)
        called = f"called with ({shown}), case {number} of {len(cases)},"
        try:
            returned = answer(*deepcopy(case))  # it may write over its arrays
            if returned is None:
                raise WrongAnswerError("there is no answer: it returns None.")
            given = np.asarray(returned, dtype=float)
        except WrongAnswerError:
            raise
        except Exception as error:  # whatever somebody's function raises
            told = f"{type(error).__name__}: {error}"
            if "ellipsis" in told:  # of the dots that the exercise has in place of an answer
                raise WrongAnswerError("there is no answer.") from error
            raise WrongAnswerError(f"{called} it fails: {told}") from error
        right = np.asarray(expected(*case), dtype=float)
        if given.shape != right.shape:
            what = f"{called} it returns shape {given.shape}, not {right.shape}."
            raise WrongAnswerError(what)
        size = max(float(np.abs(right).max(initial=0.0)), 1e-9)
        wrong = ~(np.abs(given - right) <= tolerance * size)
        if wrong.any():
            raise WrongAnswerError(*_entries(called, given, right, wrong))


def _entries(called: str, given: Any, right: Any, wrong: Any) -> tuple[str, str]:
    """Say what a call returns that is not right: one entry, or all; and what is due."""
    if wrong.all():
        return f"{called} it returns {_short(given)}", _short(right)
    places = np.argwhere(wrong)
    count, first = len(places), tuple(places[0])
    entry = ", ".join(str(index + 1) for index in first)
    entry = f"entry ({entry})" if len(first) > 1 else f"entry {entry}"
    of = f"{entry} of {wrong.size}"
    if count > 1:
        of = f"{count} of {wrong.size} entries are wrong: {entry}"
    return f"{called} {of} is {given[first]:.6g}", f"{right[first]:.6g}"


def require_model(answer: Any) -> Model:
    """Return the compiled equations of motion of an answer, a machine."""
    if not isinstance(answer, System):
        raise WrongAnswerError(f"a System is wanted, not {answer!r}.")
    try:
        return answer.model()
    except KinolabError as error:
        raise WrongAnswerError(f"its equations cannot be derived: {error}") from error


def require_motion(
    answer: Any,
    coordinates: Sequence[str],
    slopes: Callable[[Mapping[str, float], Sequence[float]], Mapping[str, float]],
    inputs: int = 0,
) -> None:
    """Compare a machine's equations of motion with closed forms, at a few states.

    Args:
        coordinates: Names that it must have.
        slopes: Returns the accelerations by name, of the state by name and the inputs.
    """
    model = require_model(answer)
    names = model.state_names
    wanted = [*coordinates, *(f"{name}_dot" for name in coordinates)]
    if missing := [name for name in wanted if name not in names]:
        raise WrongAnswerError(
            f"its states are {', '.join(names)}; {', '.join(missing)} is missing."
        )
    if model.nu != inputs:
        raise WrongAnswerError(f"it has {model.nu} inputs, and {inputs} are wanted.")
    generator = np.random.default_rng(3)
    for _ in range(4):
        x = generator.uniform(0.4, 1.4, len(names))
        u = generator.uniform(-1.0, 1.0, inputs)
        state = dict(zip(names, x.tolist(), strict=True))
        found = dict(zip(names, np.asarray(model.f(x, u)).tolist(), strict=True))
        for name, right in slopes(state, u.tolist()).items():
            if not abs(found[f"{name}_dot"] - right) <= TOLERANCE * max(abs(right), 1.0):
                at = ", ".join(f"{entry} = {state[entry]:.3g}" for entry in wanted)
                under = f" under inputs of {_short(u)}" if inputs else ""
                what = f"at {at}{under} the acceleration of {name} is {found[f'{name}_dot']:.4g}"
                raise WrongAnswerError(what, f"{right:.4g}")


def _short(value: Any) -> str:
    return np.array2string(np.asarray(value) + 0.0, precision=4, separator=", ", max_line_width=200)

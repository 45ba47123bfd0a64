"""What kinolab says when it cannot go on: where, what, and what would work."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Mistake:
    """One thing that is wrong with what the user wrote."""

    where: str  # a file and key, or the name of a body, constraint, …; may be empty
    what: str  # a sentence
    remedy: str = ""  # a sentence that says what would work

    def __str__(self) -> str:
        sentence = f"{self.what} {self.remedy}".rstrip()
        return f"{self.where}: {sentence}" if self.where else sentence


class KinolabError(Exception):
    """The root of every error that kinolab raises on purpose.

    ``exit_code`` is what the command line returns for it.
    """

    exit_code = 2


class InputError(KinolabError):
    """Something the user wrote is wrong; ``.mistakes`` lists everything that was found."""

    def __init__(self, mistakes: Iterable[Mistake]) -> None:
        self.mistakes: tuple[Mistake, ...] = tuple(mistakes)
        super().__init__("\n".join(str(mistake) for mistake in self.mistakes))


class UnknownNameError(InputError):
    """A name that nothing has; ``.kind``, ``.name`` and ``.known`` carry the facts."""

    def __init__(self, kind: str, name: str, *, known: Iterable[str], where: str = "") -> None:
        self.kind, self.name, self.known = kind, name, tuple(sorted(known))
        super().__init__([unknown_name(kind, name, known=self.known, where=where)])


def unknown_name(kind: str, name: str, *, known: Sequence[str], where: str = "") -> Mistake:
    """Describe a name that nothing has, and the nearest one that exists."""
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    question = f"Did you mean {close[0]!r}? " if close else ""
    listing = ", ".join(known) if known else "none"
    return Mistake(where, f"no {kind} is called {name!r}.", f"{question}Known: {listing}.")


class MissingPlannerError(KinolabError):
    """A planner needs a package that this platform does not have."""


class NoDynamicsError(KinolabError):
    """A kinematic machine was asked for masses, energies or forces that it does not have."""


class SingularError(KinolabError):
    """The equations of motion have no unique solution at a state; the message names the cause.

    Attributes:
        row: Which one it is of several states.
    """

    def __init__(self, message: str, row: int = 0) -> None:
        self.row = row
        super().__init__(message)


class EndpointError(KinolabError):
    """The start or the goal cannot be part of any solution (exit code 5)."""

    exit_code = 5

    def __init__(self, mistakes: Iterable[Mistake]) -> None:
        self.mistakes: tuple[Mistake, ...] = tuple(mistakes)
        super().__init__("\n".join(str(mistake) for mistake in self.mistakes))


def is_broken(text: str) -> bool:
    """Whether a text has halves of characters in it, as names of files have that are not UTF-8."""
    return any("\ud800" <= character <= "\udfff" for character in text)


def printable(text: str) -> str:
    """Replace what would steer a terminal or could not be printed, such as half a character."""
    return "".join(character if character.isprintable() else "�" for character in text)

"""Exceptions: each says where, what, and what would work; and rows of words in sentences."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from textwrap import shorten

LINE_WIDTH = 100  # characters of a line of text, as a terminal shows it
LONGEST_QUOTE = 200  # characters of what was given that a message repeats
# What a message quotes: between quotation marks, in brackets, or one word.
_QUOTE = re.compile(
    r"""(?s:(?<!\w)'(?:[^'\\]|\\.){N,}'|"(?:[^"\\]|\\.){N,}"|\([^()]{N,}\)|\S{N,})""".replace(
        "N", str(LONGEST_QUOTE - 1)
    )
)


def shortened_quotes(text: str) -> str:
    """Return a message of which each quote is at most ``LONGEST_QUOTE`` characters long."""
    return _QUOTE.sub(lambda found: f"{found[0][: LONGEST_QUOTE - 2]}…{found[0][-1]}", text)


def listed(words: Iterable[str]) -> str:
    """Return words of a file in a row, as many as a message quotes of what it was given."""
    return shorten(printable(", ".join(words)), LONGEST_QUOTE, placeholder=" …")


def counted(count: int, noun: str) -> str:
    """Return ``1 field`` or ``2 fields``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def row_of(words: Iterable[object], last: str = "and") -> str:
    """Return ``a, b and c``."""
    *first, end = [str(word) for word in words] or [""]
    return f"{', '.join(first)} {last} {end}" if first else end


def a_few(words: Iterable[object], most: int = 4, between: str = ", ") -> str:
    """Return the first words, and how many more there are: ``a, b, c, d and 2 more``."""
    names = [str(word) for word in words]
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return between.join(names[:most]) + more


@dataclass(frozen=True)
class Mistake:
    """One mistake in user input."""

    where: str  # a file and key, or the name of a body, constraint, …; may be empty
    what: str  # a sentence
    remedy: str = ""  # a sentence: what would work

    def __post_init__(self) -> None:
        """Shorten what is quoted of the input, whoever wrote the sentences."""
        for name in ("where", "what", "remedy"):
            object.__setattr__(self, name, shortened_quotes(getattr(self, name)))

    def __str__(self) -> str:
        sentence = f"{self.what} {self.remedy}".rstrip()
        return f"{self.where}: {sentence}" if self.where else sentence


class KinolabError(Exception):
    """Base class of all kinolab errors.

    ``exit_code`` is what the command line returns for it.
    """

    exit_code = 2

    def __str__(self) -> str:
        """Return the message, without long quotes of what was given."""
        return shortened_quotes(super().__str__())


class InputError(KinolabError):
    """User input is wrong; ``.mistakes`` lists every mistake found."""

    def __init__(self, mistakes: Iterable[Mistake]) -> None:
        self.mistakes: tuple[Mistake, ...] = tuple(mistakes)
        super().__init__("\n".join(str(mistake) for mistake in self.mistakes))


class UnknownNameError(InputError):
    """An unknown name; ``.kind``, ``.name`` and ``.known`` carry the facts."""

    def __init__(self, kind: str, name: str, *, known: Iterable[str], where: str = "") -> None:
        self.kind, self.name, self.known = kind, name, tuple(sorted(known))
        super().__init__([unknown_name(kind, name, known=self.known, where=where)])


def unknown_name(
    kind: str, name: str, *, known: Sequence[str], also: Iterable[str] = (), where: str = ""
) -> Mistake:
    """Describe an unknown name, and suggest the nearest of those known, or of others beside."""
    listing = ", ".join(known) if known else "none"
    remedy = f"{meant(name, [*known, *also])} Known: {listing}.".lstrip()
    return Mistake(where, f"no {kind} is called {name!r}.", remedy)


def meant(name: str, known: Iterable[str]) -> str:
    """Return a question for the known name that is nearest to an unknown one; empty if none is."""
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return f"Did you mean {close[0]!r}?" if close else ""


class MissingPlannerError(KinolabError):
    """A planner needs a package that is not available on this platform."""


class NoDynamicsError(KinolabError):
    """A kinematic machine has no masses, energies or forces."""


class SingularError(KinolabError):
    """The equations of motion have no unique solution at a state; the message names the cause.

    Attributes:
        row: Index of the state, of several.
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


# Control characters but the tab, and what changes the direction of writing, or breaks lines.
UNPRINTED = re.compile(
    r"[\x00-\x08\x0a-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)


def is_broken(text: str) -> bool:
    """Whether a text has lone surrogates, as from file names that are not UTF-8."""
    return any("\ud800" <= character <= "\udfff" for character in text)


def flaw_of(text: str, longest: int = 300) -> str:  # characters
    """Return why a text may not be a name that is shown to people, as a predicate; empty if it may.

    What is refused could pass for other lines of a report, or steer the terminal it is printed on.
    """
    if UNPRINTED.search(text):
        return "has control characters, or some that change the direction of writing"
    if len(text) > longest:
        return f"has {len(text)} characters; {longest} are the most"
    return ""


def printable(text: str) -> str:
    """Replace control characters and what cannot be printed, such as lone surrogates."""
    return "".join(character if character.isprintable() else "�" for character in text)

"""Words that users may add to, shapes, forces and inputs; and what forces and inputs consist of."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import Any, ClassVar

from kinolab.arguments import shown
from kinolab.errors import InputError, Mistake

_kinolabs: set[str] = set()  # names of kinolab's own


class Word:
    """A kind of shape, force or input, kinolab's or a user's.

    Raises:
        InputError: Where a class from outside is defined with the name of one of kinolab's.
    """

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if cls.__module__.partition(".")[0] == "kinolab":
            _kinolabs.add(cls.__name__)
        elif cls.__name__ in _kinolabs:
            what, remedy = "kinolab has a word of this name.", "Choose another name."
            raise InputError([Mistake(f"class {cls.__name__}", what, remedy)])


class LoweredWord(Word):
    """A force or an input: it says what it consists of, in words that may be lowered further.

    Attributes:
        primitive: Whether its class, not one below it, consists of nothing else.
        wanted: What the list that it is lowered to has, for errors.
    """

    primitive: ClassVar[bool] = False
    wanted: ClassVar[str]

    def lowered(self) -> Sequence[LoweredWord]:
        """Return what it consists of, as a primitive does of itself."""
        if vars(type(self)).get("primitive"):
            return (self,)
        raise NotImplementedError("write it")

    def _flaw_of(self, parts: Sequence[object]) -> str:
        """Say why it cannot consist of these primitives, in a sentence; nothing if it can."""
        raise NotImplementedError


def require_hashable(word: Word) -> None:
    """Require that a word can be looked up, as frozen dataclasses can.

    Raises:
        InputError: If it cannot.
    """
    try:
        hash(word)
    except TypeError as error:
        remedy = "Write @dataclass(frozen=True) above it, and have tuples for lists in it."
        what = f"it can be changed ({error})."
        raise InputError([Mistake(f"class {type(word).__name__}", what, remedy)]) from None


def primitives_of(word: LoweredWord) -> tuple[Any, ...]:
    """Return what a force or an input consists of, lowered until only primitives are left.

    Raises:
        InputError: If it is lowered to anything else.
    """
    try:
        return _primitives(word)
    except TypeError:
        require_hashable(word)
        raise


@lru_cache(maxsize=4096)
def _primitives(word: LoweredWord) -> tuple[Any, ...]:
    try:
        parts = tuple(_lowered(word))
    except RecursionError:
        raise _refusal(word, "it is lowered to itself, without end.") from None
    if flaw := word._flaw_of(parts):
        raise _refusal(word, flaw)
    return parts


def _lowered(word: Any) -> Iterator[Any]:
    if vars(type(word)).get("primitive"):
        yield word
        return
    try:
        given = word.lowered()
        parts = list(given) if isinstance(given, Iterable) else [given]
    except (InputError, RecursionError):
        raise
    except Exception as error:
        what = f"its lowered() failed ({type(error).__name__}: {error})."
        raise _refusal(word, what) from error
    if not isinstance(given, Iterable) or not all(isinstance(p, LoweredWord) for p in parts):
        raise _refusal(word, f"its lowered() returned {shown(given)}.")
    for part in parts:
        yield from _lowered(part)


def _refusal(word: LoweredWord, what: str) -> InputError:
    return InputError([Mistake(f"class {type(word).__name__}", what, f"Return {word.wanted}.")])

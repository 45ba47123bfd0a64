"""Bad brackets of Sussmann's test: those whose sign no choice of inputs can change.

Source: Sussmann, A general theorem on local controllability, SIAM J. Control and Optimization
25(1), 1987, section 7.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations

import numpy as np

from kinolab.dynamics.analysis.fields.bracket_filtration import Bracket, Word
from kinolab.dynamics.analysis.fields.vector_fields import DRIFT


def is_bad(word: Word) -> bool:
    """Return whether a bracket has an odd number of drifts and an even number of each input."""
    counts = Counter(word)
    drifts = counts.pop(DRIFT, 0)
    return drifts % 2 == 1 and all(count % 2 == 0 for count in counts.values())


def symmetrised(layer: Sequence[Bracket], inputs: Sequence[str]) -> list[Bracket]:
    """Return the bad brackets of a layer, each summed over all permutations of inputs.

    One of each orbit stands for all; with many inputs every bad bracket stands for itself, which is
    a stronger condition.

    Args:
        layer: Brackets of equally many fields; missing ones vanish.
        inputs: Their names, in the order of the layers.
    """
    bad = {bracket.word: bracket for bracket in layer if is_bad(bracket.word)}
    if len(inputs) > 5:  # whose permutations are tried; 120 of them
        return list(bad.values())
    found, seen = [], set[Word]()
    for word in bad:
        if word not in seen:
            orbit = list(_exchanged(word, inputs))
            seen.update(other for other, _ in orbit)
            found.append(_sum(word, orbit, bad))
    return found


def _exchanged(word: Word, inputs: Sequence[str]) -> Iterator[tuple[Word, int]]:
    """Yield a bracket under all permutations of inputs, in the layers' form, with its sign."""
    for others in permutations(inputs):
        names = dict(zip(inputs, others, strict=True))
        other = tuple(names.get(name, name) for name in word)
        *outer, a, b = other
        swapped = a in inputs and inputs.index(a) > inputs.index(b)
        yield ((*outer, b, a), -1) if swapped else (other, 1)


def _sum(word: Word, orbit: Sequence[tuple[Word, int]], bad: Mapping[Word, Bracket]) -> Bracket:
    terms = [(bad[other], sign) for other, sign in orbit if other in bad]
    jet = np.sum([sign * part.jet[:, :1] for part, sign in terms], axis=0)
    spreads = [part.spread[:, :1] for part, _ in terms if part.spread is not None]
    return Bracket(word, jet, np.sum(spreads, axis=0) if spreads else None)

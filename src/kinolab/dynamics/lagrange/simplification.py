"""Simplification for reading: fewest terms, sums of angles, short fractions."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from typing import TypeAlias

import sympy

from kinolab.dynamics.lagrange.numbers import short_number, with_short_numbers
from kinolab.dynamics.lagrange.terms import Expander, Monomial, Terms, TooLongError
from kinolab.dynamics.language.quasi_velocities import MOTIONS
from kinolab.dynamics.symbols.symbols import InputSymbol

Polynomial: TypeAlias = dict[tuple[int, int], Fraction]  # by powers of sine and cosine


def simplified(expression: sympy.Expr, deadline: float) -> sympy.Expr:
    """Return an expression in its shortest form; unchanged where that is too long or slow.

    Args:
        expression: In the symbols of a machine.
        deadline: On the clock of ``time.thread_time``, in [s].
    """
    found = []
    for apart in (False, True) if _has_sums(expression) else (False,):
        expander = Expander(written, deadline=deadline, apart=apart)
        try:
            found.append(written(expander.terms(expression)))
        except TooLongError:
            continue
    return min(found, key=sympy.count_ops) if found else with_short_numbers(expression)


def _has_sums(expression: sympy.Expr) -> bool:
    """Whether there are sums of angles to expand or to combine."""
    waves = expression.atoms(sympy.sin, sympy.cos, sympy.tan)
    return any(not wave.args[0].is_Symbol for wave in waves)


def grouped(expression: sympy.Expr) -> sympy.Expr:
    """Collect terms by common rates, accelerations, inputs or forces."""
    functions = partial(_bracketed, belongs=lambda base: bool(base.is_Function), inner=lambda e: e)
    return _bracketed(expression, _moves, inner=functions)


def _bracketed(
    expression: sympy.Expr,
    belongs: Callable[[sympy.Expr], bool],
    inner: Callable[[sympy.Expr], sympy.Expr],
) -> sympy.Expr:
    """Collect a sum by the factors that ``belongs`` selects; the others go in brackets."""
    shares: dict[sympy.Expr, list[sympy.Expr]] = defaultdict(list)
    for term in sympy.Add.make_args(expression):
        key = sympy.Mul(*(f for f in sympy.Mul.make_args(term) if belongs(f.as_base_exp()[0])))
        shares[key].append(term / key)
    made = []
    for key, terms in shares.items():
        if key == 1 or len(terms) == 1:
            made += [key * term for term in terms]
            continue
        common = _common(terms)
        made.append(sympy.Mul(common, key, inner(sympy.Add(*(term / common for term in terms)))))
    return sympy.Add(*made)


def _moves(base: sympy.Expr) -> bool:
    """Whether a factor is a rate, acceleration, input or constraint force."""
    kinds = (*MOTIONS, InputSymbol)
    return isinstance(base, kinds) or type(base) is sympy.Symbol


def _common(terms: Sequence[sympy.Expr]) -> sympy.Expr:
    """Return the common factors of all terms, and the coefficient where it is the same."""
    numbers, powers = [], []
    for term in terms:
        number, rest = term.as_coeff_Mul()
        numbers.append(number)
        powers.append(dict(factor.as_base_exp() for factor in sympy.Mul.make_args(rest)))
    shared = {
        base: min((own[base] for own in powers), key=float)
        for base in powers[0]
        if base != 1 and all(base in own and own[base].is_Integer for own in powers)
    }
    sign = -1 if all(number < 0 for number in numbers) else 1
    size = abs(numbers[0]) if len({abs(number) for number in numbers}) == 1 else 1
    return sympy.Mul(sign * size, *(base**power for base, power in shared.items()))


def written(terms: Terms) -> sympy.Expr:
    """Return terms as an expression, with the trigonometric form that makes it short."""
    for angle in _angles(terms):
        terms = _shortened(terms, angle)
    joined = _joined(terms)
    return sympy.Add(*(short_number(a) * _monomial(m) for m, a in joined.items()))


def _angles(terms: Terms) -> list[sympy.Expr]:
    bases = {base for monomial in terms for base, _ in monomial}
    angles = {base.args[0] for base in bases if isinstance(base, sympy.sin | sympy.cos)}
    return sorted(angles, key=str)


def _shortened(terms: Terms, angle: sympy.Expr) -> Terms:
    """Choose between squares of sine, cosine and tangent, for each cofactor."""
    sine, cosine = sympy.sin(angle), sympy.cos(angle)
    groups: dict[Monomial, Polynomial] = defaultdict(dict)
    for monomial, factor in terms.items():
        powers = dict(monomial)
        place = powers.pop(sine, 0), powers.pop(cosine, 0)
        groups[frozenset(powers.items())][place] = factor
    made: Terms = {}
    for rest, polynomial in groups.items():
        for (s, c), factor in min(_forms(polynomial), key=_length).items():
            own = {base: power for base, power in ((sine, s), (cosine, c)) if power}
            made[frozenset((dict(rest) | own).items())] = factor
    return made


def _forms(
    polynomial: Polynomial,
) -> Iterator[Polynomial]:
    """Yield equivalent forms of a polynomial in a sine and a cosine."""
    yield polynomial
    if any(c >= 2 for _, c in polynomial):  # c^2 = 1 - s^2
        yield _replaced(polynomial, lambda _, c: c >= 2, ((0, -2, 1), (2, -2, -1)))
    if any(c <= -2 for _, c in polynomial):  # 1 / c^2 = 1 + s^2 / c^2
        yield _replaced(polynomial, lambda s, c: c <= -2 and s < 2, ((0, 2, 1), (2, 0, 1)))


def _replaced(
    polynomial: Polynomial,
    applies: Callable[[int, int], bool],
    parts: Sequence[tuple[int, int, int]],
) -> Polynomial:
    """Replace squares while ``applies``: each part is (sine power, cosine power, factor)."""
    made: Polynomial = {}
    stack = list(polynomial.items())
    while stack:
        (s, c), factor = stack.pop()
        if applies(s, c):
            stack += [((s + ds, c + dc), factor * sign) for ds, dc, sign in parts]
        else:
            made[s, c] = made.get((s, c), Fraction(0)) + factor
    return {place: factor for place, factor in made.items() if factor}


def _length(polynomial: Polynomial) -> tuple[int, int, int]:
    powers = sum(abs(s) + abs(c) for s, c in polynomial)
    return len(polynomial), sum(factor < 0 for factor in polynomial.values()), powers


def _joined(terms: Terms) -> Terms:
    """Combine products of sines and cosines into sines and cosines of sums."""
    made = dict(terms)
    waiting = sorted(terms, key=_name, reverse=True)
    while waiting:
        monomial = waiting.pop()
        found = _partner(made, monomial) if monomial in made else None
        if found is not None:
            partner, both, sign = found
            factor = sign * made.pop(monomial)
            del made[partner]
            made[both] = made.get(both, Fraction(0)) + factor
            waiting.append(both)
    return {monomial: factor for monomial, factor in made.items() if factor}


def _name(monomial: Monomial) -> list[str]:
    """Return a deterministic sort key for products."""
    return sorted(f"{base}^{power}" for base, power in monomial)


def _partner(terms: Terms, monomial: Monomial) -> tuple[Monomial, Monomial, int] | None:
    """Return the matching product of an angle sum, the combined product and its sign, or None."""
    powers = dict(monomial)
    single = [base for base in sorted(powers, key=str) if powers[base] == 1]
    for x in (base for base in single if isinstance(base, sympy.cos)):
        for y in (base for base in single if isinstance(base, sympy.sin | sympy.cos)):
            a, b = x.args[0], y.args[0]
            flipped = sympy.sin(a), (sympy.cos if isinstance(y, sympy.sin) else sympy.sin)(b)
            if a == b or any(base in powers for base in flipped):
                continue
            rest = {base: power for base, power in powers.items() if base not in (x, y)}
            partner = frozenset((rest | dict.fromkeys(flipped, 1)).items())
            fraction = terms.get(partner, Fraction(0)) / terms[monomial]
            if abs(fraction) != 1:
                continue
            if isinstance(y, sympy.sin):  # cos a sin b + sin a cos b
                made = sympy.sin(b + a if fraction > 0 else b - a)
            else:  # cos a cos b - sin a sin b
                made = sympy.cos(a + b if fraction < 0 else a - b)
            base, sign = (-made, -1) if made.could_extract_minus_sign() else (made, 1)
            if base in rest or not isinstance(base, sympy.sin | sympy.cos):
                continue
            return partner, frozenset((rest | {base: 1}).items()), sign
    return None


def _monomial(monomial: Monomial) -> sympy.Expr:
    """Return a product, with sine over cosine as tangent."""
    powers = dict(monomial)
    for base in [entry for entry in powers if isinstance(entry, sympy.sin)]:
        angle = base.args[0]
        cosine = sympy.cos(angle)
        shared = min(powers[base], -powers.get(cosine, 0))
        if shared > 0:
            powers[base] -= shared
            powers[cosine] += shared
            powers[sympy.tan(angle)] = shared
    return sympy.Mul(*(base**power for base, power in powers.items()))

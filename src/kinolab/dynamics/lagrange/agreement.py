"""Comparison of a hand derivation with kinolab's equations of motion, term by term."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy

from kinolab.dynamics.lagrange.equations import Equations
from kinolab.dynamics.lagrange.printing import one_line
from kinolab.dynamics.language.quasi_velocities import QuasiAcceleration
from kinolab.dynamics.symbols.symbols import Acceleration, ForceSymbol, TurnAcceleration


@dataclass(frozen=True)
class Agreement:
    """The verdict on each equation of a hand derivation.

    Attributes:
        verdicts: One sentence per equation; it names the terms that differ.
        agreed: Whether each equation is correct.
        missing: Equations of motion that the derivation lacks, in words.
    """

    verdicts: tuple[str, ...]
    agreed: tuple[bool, ...]
    missing: tuple[str, ...]

    def __bool__(self) -> bool:
        return all(self.agreed) and not self.missing

    def __str__(self) -> str:
        return "\n".join([*self.verdicts, *(f"missing: {text}" for text in self.missing)])


def compare(
    ours: Equations,
    theirs: Sequence[sympy.Eq | sympy.Expr],
    constraints: Sequence[str] = (),
) -> Agreement:
    """Compare equations of motion, each up to a factor and in any order.

    Args:
        ours: kinolab's own; a hand derivation with multipliers is compared with the balance, one
            without with the reduced equations.
        theirs: Equations, or expressions that equal zero, in the machine's symbols; symbols of the
            same name are taken for these.
        constraints: Names of the constraints, in the order of their multipliers lambda_1, ….
    """
    groups = [group for group in (ours.reduced, ours.balance) if group]
    own = {symbol.name: symbol for e in ours for symbol in e.free_symbols}
    names = {name: f"lambda_{k}" for k, name in enumerate(constraints, start=1)}
    theirs = [_renamed(equation, own, names) for equation in theirs]
    best: Agreement | None = None
    for group in groups:
        agreement = _compare([_residual(equation) for equation in group], theirs)
        if best is None or sum(agreement.agreed) > sum(best.agreed) or agreement:
            best = agreement
        if best:
            break
    return best if best is not None else Agreement((), (), ("it has no equations of motion",))


def _compare(targets: Sequence[sympy.Expr], theirs: Sequence[sympy.Eq | sympy.Expr]) -> Agreement:
    verdicts, agreed, covered = [], [], set()
    for number, equation in enumerate(theirs, start=1):
        index, difference = min(
            ((k, _difference(_residual(equation), target)) for k, target in enumerate(targets)),
            key=lambda pair: len(sympy.Add.make_args(pair[1].rest)) if pair[1].rest != 0 else 0,
        )
        if difference.rest == 0:
            covered.add(index)
        agreed.append(difference.rest == 0)
        verdicts.append(f"equation {number}: {_verdict(difference, _sides(equation))}")
    missing = tuple(
        f"{one_line(target)} = 0" for k, target in enumerate(targets) if k not in covered
    )
    return Agreement(tuple(verdicts), tuple(agreed), missing if all(agreed) else ())


def _renamed(
    equation: sympy.Eq | sympy.Expr, own: Mapping[str, sympy.Symbol], multipliers: Mapping[str, str]
) -> sympy.Basic:
    """Return an equation in the machine's own symbols, found by their names."""
    named = {}
    for symbol in getattr(equation, "free_symbols", ()):
        is_force = isinstance(symbol, ForceSymbol)
        name = multipliers.get(symbol.name, symbol.name) if is_force else symbol.name
        named[symbol] = own.get(name, symbol)
    return equation.xreplace(named) if named else equation


def _residual(equation: sympy.Eq | sympy.Expr) -> sympy.Expr:
    """Return left minus right, expanded."""
    left, right = _sides(equation)
    return sympy.expand(left - right)


def _sides(equation: sympy.Eq | sympy.Expr) -> tuple[sympy.Expr, sympy.Expr]:
    """Return what an equation has on its left and on its right."""
    if isinstance(equation, sympy.Equality):
        return equation.lhs, equation.rhs
    return equation, sympy.Integer(0)


@dataclass(frozen=True)
class _Difference:
    """Two expressions that should vanish together, and what one of them has more than the other.

    Attributes:
        rest: Theirs minus ours; 0 where they agree.
        theirs: A hand derivation's, expanded.
        ours: kinolab's, expanded, with the same factor.
        factor: By which theirs was multiplied before it was expanded.
    """

    rest: sympy.Expr
    theirs: sympy.Expr
    ours: sympy.Expr
    factor: sympy.Expr


def _difference(theirs: sympy.Expr, ours: sympy.Expr) -> _Difference:
    """Compare two expressions, scaled so that an acceleration has the same factor.

    It is kinolab's that is scaled, so that terms are named as the hand derivation has them, except
    where this would divide by a sum.
    """
    factor = sympy.Integer(1)
    for symbol in sorted(ours.free_symbols, key=str):
        if not isinstance(symbol, Acceleration | QuasiAcceleration | TurnAcceleration):
            continue
        mine, other = sympy.diff(ours, symbol), sympy.diff(theirs, symbol)
        if mine == 0 or other == 0:
            continue
        scale = sympy.simplify(other / mine)
        if sympy.denom(scale).has(sympy.Add):
            factor = 1 / scale
            theirs = sympy.expand(factor * theirs)
        else:
            ours = sympy.expand(scale * ours)
        break
    rest = sympy.expand(theirs - ours)
    rest = rest if rest == 0 else sympy.expand(sympy.trigsimp(rest))
    rest = sympy.Integer(0) if _vanishes(rest) else rest
    return _Difference(rest, theirs, ours, factor)


def _vanishes(expression: sympy.Expr) -> bool:
    """Whether an expression is zero at random points, whatever identities SymPy misses."""
    symbols = sorted(expression.free_symbols, key=str)
    if not symbols:
        return bool(expression == 0)
    function = sympy.lambdify(symbols, [expression, *sympy.Add.make_args(expression)])
    generator = np.random.default_rng(0)
    for _ in range(8):  # at which a difference that SymPy cannot simplify is evaluated
        total, *terms = function(*generator.uniform(0.5, 1.5, len(symbols)))
        # 1e-9 relative size below which such a difference counts as zero
        if abs(total) > 1e-9 * max(map(abs, terms)):
            return False
    return True


def _verdict(difference: _Difference, sides: tuple[sympy.Expr, sympy.Expr]) -> str:
    """Say that an equation agrees, or which of its terms do not, with their signs."""
    if difference.rest == 0:
        return "agrees."
    found = f"{' and '.join(_terms(difference))}."
    if difference.factor != 1:
        found = f"multiplied by {one_line(difference.factor)} it {found}"
    if 0 in sides:
        return found
    return f"with all terms on the left it {found}"


def _terms(difference: _Difference) -> Iterator[str]:
    """Name every term that is extra, lacking or has another factor, as it stands or should."""
    theirs, ours = (_coefficients(side) for side in (difference.theirs, difference.ours))
    extra, lacking, altered = [], [], []
    for kind, gap in sorted(_coefficients(difference.rest).items(), key=lambda pair: str(pair[0])):
        has, should = theirs.get(kind, 0), ours.get(kind, 0)
        if has and should and has - should == gap:
            altered.append(f"{one_line(has * kind)} where it should be {one_line(should * kind)}")
        elif should == -gap or (has != gap and gap.could_extract_minus_sign()):
            lacking.append(one_line(-gap * kind))
        else:
            extra.append(one_line(gap * kind))
    if extra:
        yield f"has {', '.join(extra)} too much"
    if lacking:
        yield f"lacks {', '.join(lacking)}"
    if altered:
        yield f"has {', '.join(altered)}"


def _coefficients(expression: sympy.Expr) -> dict[sympy.Expr, sympy.Expr]:
    """Return the number before each term of a sum, by the rest of the term."""
    found: dict[sympy.Expr, sympy.Expr] = {}
    for term in sympy.Add.make_args(expression):
        number, kind = term.as_coeff_Mul()
        found[kind] = found.get(kind, sympy.Integer(0)) + number
    return found

"""Printing of formulas: as one line of plain text, ``1/4 m R² ψ̈ = steer``, and as LaTeX."""

from __future__ import annotations

import unicodedata

import sympy
from sympy.printing.latex import LatexPrinter
from sympy.printing.precedence import PRECEDENCE, precedence
from sympy.printing.str import StrPrinter

from kinolab.dynamics.lagrange.numbers import with_short_numbers
from kinolab.dynamics.language.quasi_velocities import MOTIONS, QuasiAcceleration
from kinolab.dynamics.symbols.symbols import (
    Acceleration,
    Parameter,
    RateSymbol,
    TurnAcceleration,
    TurnRate,
)

GREEK = (
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa"),
    *("lambda", "mu", "nu", "xi", "omicron", "pi", "rho", "sigma", "tau", "upsilon", "phi"),
    *("chi", "psi", "omega"),
)
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
DIGITS = "0123456789"
DOT = "\u0307"
DOTS = {1: DOT, 2: "\u0308"}
RATE = "_dot"  # ends the name of a plain symbol that is the rate of an auxiliary state


def one_line(expression: sympy.Expr, *, short: bool = True) -> str:
    """Print an expression on one line in mathematical notation, its numbers short or as given."""
    return str(_Printer().doprint(with_short_numbers(expression) if short else expression))


def as_latex(expression: sympy.Expr, *, short: bool = True) -> str:
    """Print an expression in LaTeX, in the order of the text; numbers as in ``one_line``."""
    kept = with_short_numbers(expression) if short else expression
    numbers = {n: sympy.Float(one_line(n, short=False)) for n in kept.atoms(sympy.Float)}
    return str(_LatexPrinter({"fold_func_brackets": True}).doprint(kept.xreplace(numbers)))


def letter(name: str) -> str:
    """Spell a symbol's name with Greek letters and subscripts: ``lambda_1`` is λ₁."""
    base, _, index = name.partition("_")
    stem = base.rstrip(DIGITS)
    greek = stem.lower()
    if greek in GREEK:
        case = "CAPITAL" if base[0].isupper() else "SMALL"
        spelled = "LAMDA" if greek == "lambda" else greek.upper()
        base = unicodedata.lookup(f"GREEK {case} LETTER {spelled}") + base.removeprefix(stem)
    if not index:
        return base
    return base + index.translate(SUBSCRIPTS) if index.isdigit() else f"{base}_{index}"


class _OrderedFactors:
    """Of a printer: products by juxtaposition, masses first and rates last."""

    def _factors(self, product: sympy.Expr) -> str:
        factors = sorted(sympy.Mul.make_args(product), key=_order)
        return " ".join(self._factor(factor) for factor in factors)

    def _factor(self, factor: sympy.Expr) -> str:
        raise NotImplementedError


class _Printer(_OrderedFactors, StrPrinter):  # type: ignore[misc]
    """SymPy's string printer, with products by juxtaposition and Greek letters."""

    def _print_Symbol(self, expression: sympy.Symbol) -> str:
        name = expression.name
        return _dotted(name[: -len(RATE)], 1) if name.endswith(RATE) else letter(name)

    _print_MachineSymbol = _print_Symbol  # noqa: N815

    def _print_Float(self, expression: sympy.Float) -> str:
        return f"{float(expression):.6g}"  # significant digits printed of a float

    def _print_RateSymbol(self, expression: RateSymbol) -> str:
        return _dotted(expression.coordinate.name, 1)

    def _print_Acceleration(self, expression: Acceleration) -> str:
        return _dotted(expression.coordinate.name, 2)

    def _print_TurnRate(self, expression: TurnRate) -> str:
        return f"ω_{expression.attitude.name}{'xyz'[expression.index]}"

    def _print_TurnAcceleration(self, expression: TurnAcceleration) -> str:
        turn = expression.turn
        return f"ω{DOT}_{turn.attitude.name}{'xyz'[turn.index]}"

    def _print_QuasiAcceleration(self, expression: QuasiAcceleration) -> str:
        return _dotted(expression.velocity.name, 1)

    def _print_Pow(self, expression: sympy.Pow, rational: bool = False) -> str:
        base, exponent = expression.args
        if exponent.is_Integer and exponent > 1:
            power = str(exponent).translate(SUPERSCRIPTS)
            if isinstance(base, (sympy.sin, sympy.cos, sympy.tan)):
                return f"{type(base).__name__}{power}({self._print(base.args[0])})"
            return f"{self.parenthesize(base, PRECEDENCE['Pow'] + 1)}{power}"
        return str(super()._print_Pow(expression, rational=rational))

    def _print_Mul(self, expression: sympy.Mul) -> str:
        coefficient, rest = expression.as_coeff_Mul(rational=True)
        sign = "-" if coefficient.is_negative else ""
        number = "" if abs(coefficient) == 1 else f"{self._print(abs(coefficient))} "
        numerator, denominator = _above_and_below(rest)
        text = f"{sign}{number}{self._factors(numerator)}".strip()
        if denominator == 1:
            return text
        below, several = self._factors(denominator), denominator.is_Mul
        if numerator == 1:  # 2/m and 1/(2 m), not 2 1/m and 1/2 1/m
            text = f"{sign}{abs(coefficient.p)}"
            below = below if coefficient.q == 1 else f"{coefficient.q} {below}"
            several = several or coefficient.q != 1
        return f"{text}/({below})" if several else f"{text}/{below}"

    def _factor(self, factor: sympy.Expr) -> str:
        if factor.is_number and factor.is_nonnegative and not factor.is_Rational:
            return str(self._print(factor))
        if factor == 1:
            return "1"
        return str(self.parenthesize(factor, precedence(sympy.Mul(2, factor))))


class _LatexPrinter(_OrderedFactors, LatexPrinter):  # type: ignore[misc]
    """SymPy's LaTeX printer, with factors in the order of the text: ``m l^{2}``."""

    def _print_Mul(self, expression: sympy.Mul) -> str:
        coefficient, rest = expression.as_coeff_Mul(rational=True)
        sign = "- " if coefficient.is_negative else ""
        above, below = _above_and_below(rest)
        over, under = abs(coefficient.p), coefficient.q
        if below == 1:
            number = "" if over == under else f"{self._print(sympy.Rational(over, under))} "
            return f"{sign}{number}{self._factors(above)}"
        numerator = self._factors(above) if over == 1 else f"{over} {self._factors(above)}"
        if above == 1:
            numerator = str(over)
        denominator = self._factors(below) if under == 1 else f"{under} {self._factors(below)}"
        return rf"{sign}\frac{{{numerator}}}{{{denominator}}}"

    def _factor(self, factor: sympy.Expr) -> str:
        return str(self.parenthesize(factor, PRECEDENCE["Mul"]))


def _above_and_below(product: sympy.Expr) -> tuple[sympy.Expr, sympy.Expr]:
    """Return numerator and denominator of a product, sums not combined."""
    above, below = [], []
    for factor in sympy.Mul.make_args(product):
        base, exponent = factor.as_base_exp()
        if exponent.is_number and exponent.is_negative:
            below.append(base**-exponent)
        else:
            above.append(factor)
    return sympy.Mul(*above), sympy.Mul(*below)


def _dotted(name: str, order: int) -> str:
    """Spell a time derivative: ψ̇, φ̇_l and q̇1, or left_dot, as scenarios and tables call it.

    A dot belongs to one letter. Over a word it would be that of its last one, and d(left)/dt could
    not be squared.
    """
    head, _, index = name.partition("_")
    base = head.rstrip(DIGITS)
    if len(letter(base)) != 1:
        return f"{name}_{'d' * order}ot"
    digits = head.removeprefix(base)
    return letter(base) + DOTS[order] + digits + letter(f"a_{index}")[1:] * bool(index)


def _order(factor: sympy.Expr) -> tuple[int, str]:
    """Order masses first, then other parameters, functions of coordinates, and rates last."""
    base = factor.as_base_exp()[0]
    if base.is_number:
        return -1, ""
    if isinstance(base, Parameter):
        return (0 if base.unit == "kg" else 1), str(base).lower()
    if isinstance(base, MOTIONS):
        return 5, str(base)
    if base.is_Symbol:
        return 2, str(base).lower()
    return (3 if base.is_Function else 4), str(base)


def written_length(expression: sympy.Expr) -> int:
    """Return the number of symbols, numbers and operations of an expression written out.

    Shared subexpressions are visited once; written out they may exceed memory.
    """
    lengths: dict[sympy.Basic, int] = {}
    stack = [expression]
    while stack:
        missing = [part for part in stack[-1].args if part not in lengths]
        if missing:
            stack += missing
        else:
            part = stack.pop()
            lengths[part] = 1 + sum(lengths[inner] for inner in part.args)
    return lengths[expression]

"""Cancellation in expression graphs, by normal forms of polynomials.

A vector rotated into a frame and back is unchanged, for sin^2 + cos^2 = 1. Derivations are full of
such pairs, and machine code would compute them all. So every node is expanded as a polynomial in
its descendants, with all squares of sines replaced. Nodes with the same polynomial are merged, and
one with a single term becomes a product.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node

Monomial: TypeAlias = tuple[tuple[Node, int], ...]  # powers of nodes, sorted by node
Polynomial: TypeAlias = Mapping[Monomial, float]
InTurn: TypeAlias = dict[tuple[int, int], Node]  # of cos^i sin^j of one angle, with j = 0 or 1

MAX_TERMS = 12  # of a polynomial; a node with more is an indeterminate in those above it


class Cancellation:
    """Rewrites the nodes of an expression graph, to which new nodes are added.

    Args:
        tape: The expression graph.
        anew: Whether quotients by products are expanded, too, and sums of which something cancels
            are written anew, term by term: no shorter for a machine, but tighter over intervals.
    """

    def __init__(self, tape: ExpressionGraph, *, anew: bool = False) -> None:
        self._tape, self._anew = tape, anew
        self._made: dict[Node, Node] = {}
        self._polynomials: dict[Node, Polynomial] = {}  # by rewritten node
        self._known: dict[frozenset[tuple[Monomial, float]], Node] = {}

    def rewritten(self, nodes: Sequence[Node]) -> list[Node]:
        """Return equivalent nodes that take fewer operations."""
        for node in self._tape.needed(nodes):
            if node not in self._made:
                self._made[node] = self._rewrite(node)
        return [self._made[node] for node in nodes]

    def _rewrite(self, node: Node) -> Node:
        tape, operation = self._tape, self._tape.operations[node]
        operands = [self._made[operand] for operand in operation.operands]
        names = ("add", "sub", "neg", "mul", *(["div"] if self._anew else []))
        if operation.name not in names:
            return tape.remade(node, operands)
        parts = [self._polynomial(a) for a in operands]
        polynomial = self._combined(operation.name, parts)
        if polynomial is None:
            return tape.remade(node, operands)
        key = frozenset(polynomial.items())
        if key not in self._known:
            shorter = self._anew and len(polynomial) < sum(len(part) for part in parts)
            if len(polynomial) <= 1 or (shorter and operation.name in ("add", "sub")):
                made = self._written(polynomial)
            else:
                made = tape.remade(node, operands)
            self._known[key] = made
            self._polynomials.setdefault(made, polynomial)
        return self._known[key]

    def _polynomial(self, node: Node) -> Polynomial:
        if node not in self._polynomials:
            value = self._tape.value(node)
            if value is None:
                self._polynomials[node] = {((node, 1),): 1.0}
            else:
                self._polynomials[node] = {(): value} if value else {}
            self._known.setdefault(frozenset(self._polynomials[node].items()), node)
        return self._polynomials[node]

    def _combined(self, name: str, parts: Sequence[Polynomial]) -> Polynomial | None:
        """Return the polynomial of an operation on its operands; None where too large."""
        if name == "neg":
            return {monomial: -factor for monomial, factor in parts[0].items()}
        one, other = parts
        if name == "div":
            if len(other) != 1:
                return None
            name = "mul"
            other = {_inverse(monomial): 1.0 / factor for monomial, factor in other.items()}
        if name == "mul":
            if len(one) * len(other) > MAX_TERMS:
                return None
            terms = [(_times(m, n), a * b) for m, a in one.items() for n, b in other.items()]
        else:
            sign = 1.0 if name == "add" else -1.0
            terms = [*one.items(), *((m, sign * b) for m, b in other.items())]
        return self._collected(terms)

    def _collected(self, terms: list[tuple[Monomial, float]]) -> Polynomial | None:
        """Collect terms with squares of sines replaced; None where too many remain."""
        found: dict[Monomial, float] = {}
        sizes: dict[Monomial, float] = {}
        while terms:
            monomial, factor = terms.pop()
            turned = self._without_square(monomial)
            if turned is not None:
                rest, cosine = turned
                # 8 is the largest power of one node.
                if any(power > 8 for _, power in rest) or len(terms) > 4 * MAX_TERMS:
                    return None
                terms += [(rest, factor), (_times(rest, ((cosine, 2),)), -factor)]
                continue
            found[monomial] = found.get(monomial, 0.0) + factor
            sizes[monomial] = max(sizes.get(monomial, 0.0), abs(factor))
        # 1e-13 of the terms summed, below which a coefficient is rounding
        left = {m: factor for m, factor in found.items() if abs(factor) > 1e-13 * sizes[m]}
        return left if len(left) <= MAX_TERMS else None

    def _without_square(self, monomial: Monomial) -> tuple[Monomial, Node] | None:
        """Return a monomial without a squared sine, and the cosine; None without such."""
        for k, (node, power) in enumerate(monomial):
            operation = self._tape.operations[node]
            if power >= 2 and operation.name == "sin":
                kept = ((node, power - 2),) if power > 2 else ()
                cosine = self._tape.unary("cos", operation.operands[0])
                return (*monomial[:k], *kept, *monomial[k + 1 :]), cosine
        return None

    def _written(self, polynomial: Polynomial) -> Node:
        """Return the node of a polynomial, a sum of its terms."""
        return self._tape.sum(self._term(*one) for one in sorted(polynomial.items()))

    def _term(self, monomial: Monomial, factor: float) -> Node:
        tape, above, below = self._tape, self._tape.one, self._tape.one
        for node, power in monomial:
            if power > 0:
                above = tape.mul(above, tape.power(node, power))
            else:
                below = tape.mul(below, tape.power(node, -power))
        return tape.mul(tape.constant(factor), tape.div(above, below))


def _times(one: Monomial, other: Monomial) -> Monomial:
    powers = dict(one)
    for node, power in other:
        powers[node] = powers.get(node, 0) + power
    return tuple(sorted((node, power) for node, power in powers.items() if power))


def _inverse(monomial: Monomial) -> Monomial:
    return tuple((node, -power) for node, power in monomial)


def without_turns(
    tape: ExpressionGraph, nodes: Sequence[Node], angles: Sequence[Node]
) -> list[Node]:
    """Return the same functions as polynomials in sines and cosines of angles, as far as they are.

    Squares of a sine are written as 1 - cos^2, so that equal functions have equal coefficients.
    What is no polynomial, such as a quotient by one of the angle, stays as it is. What would become
    longer stays, too.
    """
    found = list(nodes)
    for angle in angles:
        turned = _without_turn(tape, found, angle)
        if len(tape.needed(turned)) <= len(tape.needed(found)):
            found = turned
    return found


def _without_turn(tape: ExpressionGraph, nodes: Sequence[Node], angle: Node) -> list[Node]:
    waves = tape.unary("cos", angle), tape.unary("sin", angle)
    known: dict[Node, InTurn] = {waves[0]: {(1, 0): tape.one}, waves[1]: {(0, 1): tape.one}}
    minus: InTurn = {(0, 0): tape.constant(-1.0)}
    for node in tape.needed(nodes):
        if node in known:
            continue
        name, operands, *_ = tape.operations[node]
        parts = [known[operand] for operand in operands]
        if name == "add":
            known[node] = _sum(tape, *parts)
        elif name == "sub":
            known[node] = _sum(tape, parts[0], _product(tape, parts[1], minus))
        elif name in ("neg", "mul"):
            known[node] = _product(tape, *parts, *([minus] if name == "neg" else []))
        elif name == "div" and set(parts[1]) == {(0, 0)}:
            by = parts[1][0, 0]
            known[node] = {power: tape.div(part, by) for power, part in parts[0].items()}
        else:
            known[node] = {(0, 0): tape.remade(node, [_node(tape, part, waves) for part in parts])}
    return [_node(tape, known[node], waves) for node in nodes]


def _sum(tape: ExpressionGraph, a: InTurn, b: InTurn) -> InTurn:
    total = dict(a)
    for power, node in b.items():
        total[power] = tape.add(total.get(power, tape.zero), node)
    return {power: node for power, node in total.items() if node != tape.zero}


def _product(tape: ExpressionGraph, a: InTurn, b: InTurn) -> InTurn:
    total: InTurn = {}
    for (i, j), x in a.items():
        for (k, m), y in b.items():
            xy = tape.mul(x, y)
            if j + m < 2:
                total = _sum(tape, total, {(i + k, j + m): xy})
            else:
                total = _sum(tape, total, {(i + k, 0): xy, (i + k + 2, 0): tape.neg(xy)})
    return total


def _node(tape: ExpressionGraph, polynomial: InTurn, waves: tuple[Node, Node]) -> Node:
    cos, sin = waves
    return tape.sum(
        tape.mul(node, tape.mul(tape.power(cos, i), tape.power(sin, j)))
        for (i, j), node in polynomial.items()
    )

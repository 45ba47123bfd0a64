"""A hash-consed expression graph, differentiated and compiled instead of SymPy trees.

Every node is an integer; equal expressions are the same node, so common subexpressions cost
nothing and a derivative is a few dictionary look-ups per node. Constant folding and the identities
of 0, 1 and sin^2 + cos^2 are applied as nodes are created; nothing else is simplified.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar

Node: TypeAlias = int
T = TypeVar("T")

UNARY: dict[str, Callable[[float], float]] = {
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "exp": math.exp,
    "log": math.log,
    "sqrt": math.sqrt,
    "tanh": math.tanh,
    "atan": math.atan,
    "fabs": math.fabs,
    "sign": lambda value: float((value > 0) - (value < 0)),
}


ARITHMETIC: dict[str, Callable[..., Any]] = {
    **{"add": operator.add, "sub": operator.sub, "mul": operator.mul},
    **{"div": operator.truediv, "neg": operator.neg},
}


class Operation(NamedTuple):
    """The operator and operands of one node; a tuple, since graphs make and hash many."""

    name: str  # "const", "variable", "add", "sub", "mul", "div", "neg", "fmax", … or a UNARY name
    operands: tuple[Node, ...] = ()
    value: float = 0.0  # of a constant
    label: str = ""  # of a variable


class Solution(Protocol):
    """Nodes that solve equations, whose tangents solve the differentiated ones."""

    def tangents(self, of: Callable[[Node], Node]) -> Sequence[tuple[Node, Node]]:
        """Return each solved node with its tangent, given those of the equations' nodes."""
        ...


class ExpressionGraph:
    """The nodes of a set of expressions, in topological order."""

    def __init__(self) -> None:
        self.operations: list[Operation] = []
        self._known: dict[Operation, Node] = {}
        self._variables: dict[Node, frozenset[Node]] = {}
        self._sets: dict[frozenset[Node], frozenset[Node]] = {}  # of those, each kept once
        self._solved: dict[Node, Solution] = {}
        self.zero = self.constant(0.0)
        self.one = self.constant(1.0)

    def constant(self, value: float) -> Node:
        """Return the node of a number."""
        return self._node(Operation("const", value=value + 0.0))

    def variable(self, label: str) -> Node:
        """Return the node of a named variable."""
        return self._node(Operation("variable", label=label))

    def value(self, node: Node) -> float | None:
        """Return a constant node's value, None where it is not constant."""
        operation = self.operations[node]
        return operation.value if operation.name == "const" else None

    def add(self, a: Node, b: Node) -> Node:
        """Return a + b."""
        if a == self.zero:
            return b
        if b == self.zero:
            return a
        x, y = self.value(a), self.value(b)
        if x is not None and y is not None:
            return self.constant(x + y)
        negated_a, negated_b = self._negated(a), self._negated(b)
        if negated_a is not None and negated_b is not None:
            return self.neg(self.add(negated_a, negated_b))
        if negated_b is not None:
            return self.sub(a, negated_b)
        if negated_a is not None:
            return self.sub(b, negated_a)
        if self._pythagoras(a, b):
            return self.one
        return self._node(Operation("add", (min(a, b), max(a, b))))

    def sub(self, a: Node, b: Node) -> Node:
        """Return a - b."""
        if a == b:
            return self.zero
        if b == self.zero:
            return a
        if a == self.zero:
            return self.neg(b)
        x, y = self.value(a), self.value(b)
        if x is not None and y is not None:
            return self.constant(x - y)
        negated_a, negated_b = self._negated(a), self._negated(b)
        if negated_b is not None:
            return self.add(a, negated_b)
        if negated_a is not None:
            return self.neg(self.add(negated_a, b))
        return self._node(Operation("sub", (a, b)))

    def neg(self, a: Node) -> Node:
        """Return -a."""
        x = self.value(a)
        if x is not None:
            return self.constant(-x)
        negated = self._negated(a)
        if negated is not None:
            return negated
        operation = self.operations[a]
        if operation.name == "sub":
            return self.sub(operation.operands[1], operation.operands[0])
        return self._node(Operation("neg", (a,)))

    def mul(self, a: Node, b: Node) -> Node:
        """Return a * b."""
        x, y = self.value(a), self.value(b)
        if x is not None and y is not None:
            return self.constant(x * y)
        for value, other in ((x, b), (y, a)):
            if value == 0.0:
                return self.zero
            if value == 1.0:
                return other
            if value == -1.0:
                return self.neg(other)
        negated_a, negated_b = self._negated(a), self._negated(b)
        if negated_a is not None or negated_b is not None:
            product = self.mul(
                a if negated_a is None else negated_a, b if negated_b is None else negated_b
            )
            return product if negated_a is not None and negated_b is not None else self.neg(product)
        return self._node(Operation("mul", (min(a, b), max(a, b))))

    def div(self, a: Node, b: Node) -> Node:
        """Return a / b; a division by the constant 0 is an ArithmeticError."""
        x, y = self.value(a), self.value(b)
        if y == 0.0:
            raise ZeroDivisionError("an expression divides by zero")
        if y is not None:
            return self.mul(a, self.constant(1.0 / y)) if x is None else self.constant(x / y)
        if x == 0.0:
            return self.zero
        if a == b:
            return self.one
        negated_a, negated_b = self._negated(a), self._negated(b)
        if negated_a is not None:
            return self.neg(self.div(negated_a, b))
        if negated_b is not None:
            return self.neg(self.div(a, negated_b))
        return self._node(Operation("div", (a, b)))

    def unary(self, name: str, a: Node) -> Node:
        """Return a unary function of ``UNARY`` applied to a."""
        x = self.value(a)
        if x is not None:
            return self.constant(UNARY[name](x))
        negated = self._negated(a)
        if negated is not None:
            if name in ("sin", "tan", "tanh", "atan", "sign"):
                return self.neg(self.unary(name, negated))
            if name in ("cos", "fabs"):
                return self.unary(name, negated)
        return self._node(Operation(name, (a,)))

    def maximum(self, a: Node, b: Node) -> Node:
        """Return the larger of two."""
        x, y = self.value(a), self.value(b)
        if x is not None and y is not None:
            return self.constant(max(x, y))
        return a if a == b else self._node(Operation("fmax", (min(a, b), max(a, b))))

    def power(self, a: Node, exponent: float) -> Node:
        """Return a to a constant power, by products, roots and reciprocals where possible."""
        if exponent < 0:
            return self.div(self.one, self.power(a, -exponent))
        if 2 * exponent == int(2 * exponent) and exponent <= 64:
            whole = self._integer_power(a, int(exponent))
            return whole if exponent == int(exponent) else self.mul(whole, self.unary("sqrt", a))
        return self.unary("exp", self.mul(self.constant(exponent), self.unary("log", a)))

    def sum(self, nodes: Iterable[Node]) -> Node:
        """Return the sum of several nodes, 0 for none."""
        total = self.zero
        for node in nodes:
            total = self.add(total, node)
        return total

    def dot(self, a: Iterable[Node], b: Iterable[Node]) -> Node:
        """Return the scalar product of two equally long sequences."""
        return self.sum(self.mul(x, y) for x, y in zip(a, b, strict=True))

    def depends_on(self, node: Node) -> frozenset[Node]:
        """Return the variables that a node depends on."""
        stack = [node]
        while stack:
            top = stack[-1]
            if top in self._variables:
                stack.pop()
                continue
            operands = self.operations[top].operands
            missing = [operand for operand in operands if operand not in self._variables]
            if missing:
                stack.extend(missing)
                continue
            own = frozenset({top}) if self.operations[top].name == "variable" else frozenset()
            found = own.union(*(self._variables[o] for o in operands))
            self._variables[top] = self._sets.setdefault(found, found)
            stack.pop()
        return self._variables[node]

    def derivative(self, outputs: Sequence[Node], seeds: Mapping[Node, Node]) -> list[Node]:
        """Differentiate along a direction: sum over variables v of d(output)/dv * seeds[v]."""
        tangent: dict[Node, Node] = {}
        return [self._tangent(output, seeds, tangent) for output in outputs]

    def solves(self, solution: Solution, nodes: Iterable[Node]) -> None:
        """Let nodes be differentiated as the solution of equations, not as how they are found."""
        self._solved |= dict.fromkeys(nodes, solution)

    def substitute(self, outputs: Sequence[Node], values: Mapping[Node, Node]) -> list[Node]:
        """Replace variables by nodes."""
        memo: dict[Node, Node] = dict(values)
        for node in self.needed(outputs):
            if node not in memo:
                operands = [memo[operand] for operand in self.operations[node].operands]
                memo[node] = self.remade(node, operands)
        return [memo[output] for output in outputs]

    def remade(self, node: Node, operands: Sequence[Node]) -> Node:
        """Return a node's operation applied to other operands."""
        operation = self.operations[node]
        if not operation.operands:
            return node
        if operation.name == "fmax":
            return self.maximum(*operands)
        if operation.name in UNARY:
            return self.unary(operation.name, operands[0])
        made: Node = getattr(self, operation.name)(*operands)
        return made

    def needed(self, outputs: Iterable[Node], known: Container[Node] = ()) -> list[Node]:
        """Return the nodes that outputs depend on, in topological order, but for what is known."""
        seen: set[Node] = set()
        stack = list(outputs)
        while stack:
            node = stack.pop()
            if node not in seen and node not in known:
                seen.add(node)
                stack.extend(self.operations[node].operands)
        return sorted(seen)

    def evaluate(self, outputs: Sequence[Node], values: Mapping[str, float]) -> list[float]:
        """Evaluate outputs in Python; slow, for decisions made once per machine."""

        def leaf(node: Node) -> float:
            operation = self.operations[node]
            return values[operation.label] if operation.name == "variable" else operation.value

        return self.folded(outputs, leaf, UNARY | ARITHMETIC | {"fmax": max})

    def folded(
        self,
        outputs: Sequence[Node],
        leaf: Callable[[Node], T],
        functions: Mapping[str, Callable[..., T]],
    ) -> list[T]:
        """Return what outputs are in anything that has the operations.

        Args:
            leaf: Returns what the node of a constant or a variable is.
            functions: The operations by their names.
        """
        memo: dict[Node, T] = {}
        for node in self.needed(outputs):
            name, operands, *_ = self.operations[node]
            memo[node] = functions[name](*(memo[o] for o in operands)) if operands else leaf(node)
        return [memo[output] for output in outputs]

    def _node(self, operation: Operation) -> Node:
        node = self._known.get(operation)
        if node is None:
            node = self._known[operation] = len(self.operations)
            self.operations.append(operation)
        return node

    def _negated(self, a: Node) -> Node | None:
        operation = self.operations[a]
        if operation.name == "neg":
            return operation.operands[0]
        if operation.name == "const" and operation.value < 0.0:
            return self.constant(-operation.value)
        return None

    def _pythagoras(self, a: Node, b: Node) -> bool:
        """Whether a + b is sin^2 + cos^2 of one angle."""
        squares = []
        for node in (a, b):
            operation = self.operations[node]
            if operation.name != "mul" or operation.operands[0] != operation.operands[1]:
                return False
            squares.append(self.operations[operation.operands[0]])
        names = {square.name for square in squares}
        return names == {"sin", "cos"} and squares[0].operands == squares[1].operands

    def _integer_power(self, a: Node, exponent: int) -> Node:
        if exponent == 0:
            return self.one
        half = self._integer_power(a, exponent // 2)
        square = self.mul(half, half)
        return self.mul(square, a) if exponent % 2 else square

    def _tangent(self, output: Node, seeds: Mapping[Node, Node], tangent: dict[Node, Node]) -> Node:
        moving = frozenset(seeds)
        for node in self.needed([output], tangent):
            if node not in tangent:
                if not self.depends_on(node) & moving:
                    tangent[node] = self.zero
                elif node in self._solved:
                    inner = partial(self._tangent, seeds=seeds, tangent=tangent)
                    tangent.update(self._solved[node].tangents(inner))
                else:
                    tangent[node] = self._rule(node, seeds, tangent)
        return tangent[output]

    def _rule(self, node: Node, seeds: Mapping[Node, Node], tangent: Mapping[Node, Node]) -> Node:
        """Return the tangent of one node from those of its operands."""
        operation = self.operations[node]
        if operation.name == "variable":
            return seeds[node]
        a = operation.operands[0]
        da = tangent[a]
        if len(operation.operands) == 1:
            return self._unary_rule(operation.name, node, a, da)
        b = operation.operands[1]
        db = tangent[b]
        match operation.name:
            case "add":
                return self.add(da, db)
            case "sub":
                return self.sub(da, db)
            case "mul":
                return self.add(self.mul(da, b), self.mul(a, db))
            case "div":
                return self.div(self.sub(da, self.mul(node, db)), b)
            case "fmax":  # where both are equal, the mean of both slopes
                which = self.unary("sign", self.sub(a, b))
                both = self.add(self.add(da, db), self.mul(which, self.sub(da, db)))
                return self.mul(self.constant(0.5), both)
        raise ArithmeticError(f"{operation.name} has no derivative")

    def _unary_rule(self, name: str, node: Node, a: Node, da: Node) -> Node:
        square = self.mul(node, node)
        rules: dict[str, Callable[[], Node]] = {
            "neg": lambda: self.neg(da),
            "sin": lambda: self.mul(self.unary("cos", a), da),
            "cos": lambda: self.neg(self.mul(self.unary("sin", a), da)),
            "tan": lambda: self.mul(self.add(self.one, square), da),
            "exp": lambda: self.mul(node, da),
            "log": lambda: self.div(da, a),
            "sqrt": lambda: self.div(self._half(da), node),
            "tanh": lambda: self.mul(self.sub(self.one, square), da),
            "atan": lambda: self.div(da, self.add(self.one, self.mul(a, a))),
            "fabs": lambda: self.mul(self.unary("sign", a), da),  # 0 at the kink, the mean slope
            "sign": lambda: self.zero,
        }
        return rules[name]()

    def _half(self, a: Node) -> Node:
        """Return a / 2: of a derivative of squares without their factor of 2."""
        halves: dict[Node, Node] = {}
        stack = [a]
        while stack:
            name, operands, *_ = self.operations[stack[-1]]
            if name != "add":
                half = self.mul(self.constant(0.5), stack[-1])
            elif operands[0] == operands[1]:
                half = operands[0]
            elif missing := [one for one in reversed(operands) if one not in halves]:
                stack.extend(missing)
                continue
            else:
                half = self.add(*(halves[one] for one in operands))
            halves[stack.pop()] = half
        return halves[a]

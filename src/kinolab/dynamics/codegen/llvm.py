"""A small builder of LLVM IR text: registers, arrays of doubles, loops and branches.

A routine in lanes computes several results at once: each of its numbers is a vector of doubles,
and entry i of its arrays holds that of every lane, one after the other.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from typing import TypeAlias

Register: TypeAlias = str
Index: TypeAlias = int | Register


def literal(value: float) -> str:
    """Return a double as LLVM's exact hexadecimal constant."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


def in_lanes(lanes: int) -> str:
    """Return the end of the name of a function that computes so many results at once."""
    return "" if lanes == 1 else "_lanes"


def intrinsic(name: str, lanes: int) -> str:
    """Return LLVM's name of one of its functions of doubles."""
    return f"llvm.{name}.f64" if lanes == 1 else f"llvm.{name}.v{lanes}f64"


class Routine:
    """One function, written line by line.

    Args:
        name: Of the function.
        parameters: (type, name) each, such as ("ptr", "x").
        private: Whether only this module calls it.
        lanes: Of which every number consists.
        inlined: Whether it is to be part of what calls it.

    Attributes:
        number: Type of a number.
        truth: Type of what a comparison of numbers says.
    """

    def __init__(
        self,
        name: str,
        parameters: list[tuple[str, str]],
        *,
        result: str = "i32",
        private: bool = False,
        lanes: int = 1,
        inlined: bool = False,
    ) -> None:
        self.lanes = lanes
        self.number, self.truth = (
            ("double", "i1") if lanes == 1 else (f"<{lanes} x double>", f"<{lanes} x i1>")
        )
        linkage = "internal " if private else ""
        listing = ", ".join(f"{kind} %{label}" for kind, label in parameters)
        ending = " alwaysinline" if inlined else ""
        self._header = f"define {linkage}{result} @{name}({listing}){ending} {{"
        self._result = result
        self._entry: list[str] = []
        self._lines: list[str] = []
        self._counter = count()

    def text(self) -> str:
        """Return the function as text."""
        return "\n".join([self._header, "entry:", *self._entry, *self._lines, "}"])

    def line(self, instruction: str) -> Register:
        """Add an instruction with a result."""
        name = f"%v{next(self._counter)}"
        self._lines.append(f"  {name} = {instruction}")
        return name

    def do(self, instruction: str) -> None:
        """Add an instruction without a result."""
        self._lines.append(f"  {instruction}")

    def array(self, size: int) -> Register:
        """Reserve numbers on the stack for the whole function."""
        name = f"%a{next(self._counter)}"
        self._entry.append(f"  {name} = alloca [{max(size, 1)} x {self.number}], align 16")
        return name

    def cell(self, kind: str, value: str) -> Register:
        """Reserve one variable of a type on the stack, with a value."""
        name = f"%c{next(self._counter)}"
        self._entry.append(f"  {name} = alloca {kind}")
        self.do(f"store {kind} {value}, ptr {name}")
        return name

    def get(self, kind: str, cell: Register) -> Register:
        """Read a variable."""
        return self.line(f"load {kind}, ptr {cell}")

    def put(self, kind: str, cell: Register, value: str) -> None:
        """Write a variable."""
        self.do(f"store {kind} {value}, ptr {cell}")

    def at(self, array: Register, index: Index) -> Register:
        """Return the address of an entry."""
        return self.line(f"getelementptr {self.number}, ptr {array}, i64 {index}")

    def load(self, array: Register, index: Index) -> Register:
        """Read an entry."""
        return self.line(f"load {self.number}, ptr {self.at(array, index)}, align 8")

    def store(self, array: Register, index: Index, value: str) -> None:
        """Write an entry."""
        self.do(f"store {self.number} {value}, ptr {self.at(array, index)}, align 8")

    def constant(self, value: float) -> str:
        """Return a number that is known, the same in every lane."""
        if self.lanes == 1:
            return literal(value)
        return "<" + ", ".join([f"double {literal(value)}"] * self.lanes) + ">"

    def spread(self, value: Register) -> Register:
        """Return a double as a number, the same in every lane."""
        if self.lanes == 1:
            return value
        nothing = f"{self.number} poison"
        first = self.line(f"insertelement {nothing}, double {value}, i32 0")
        order = f"<{self.lanes} x i32> zeroinitializer"
        return self.line(f"shufflevector {self.number} {first}, {nothing}, {order}")

    def load_shared(self, array: Register, index: Index) -> Register:
        """Read an entry of an array of doubles that all lanes share."""
        address = self.line(f"getelementptr double, ptr {array}, i64 {index}")
        return self.spread(self.line(f"load double, ptr {address}, align 8"))

    def add(self, a: str, b: str) -> Register:
        """Return a + b; a product may be fused in."""
        return self.line(f"fadd contract {self.number} {a}, {b}")

    def sub(self, a: str, b: str) -> Register:
        """Return a - b."""
        return self.line(f"fsub contract {self.number} {a}, {b}")

    def mul(self, a: str, b: str) -> Register:
        """Return a * b."""
        return self.line(f"fmul contract {self.number} {a}, {b}")

    def div(self, a: str, b: str) -> Register:
        """Return a / b."""
        return self.line(f"fdiv {self.number} {a}, {b}")

    def neg(self, a: str) -> Register:
        """Return -a."""
        return self.line(f"fneg {self.number} {a}")

    def compare(self, order: str, a: str, b: str) -> Register:
        """Return what a comparison such as ``olt`` says."""
        return self.line(f"fcmp {order} {self.number} {a}, {b}")

    def select(self, condition: Register, a: str, b: str) -> Register:
        """Return a where a condition holds, b elsewhere."""
        return self.line(f"select {self.truth} {condition}, {self.number} {a}, {self.number} {b}")

    def intrinsic(self, name: str, *values: str) -> Register:
        """Return a function of LLVM's own, such as ``sqrt``."""
        listing = ", ".join(f"{self.number} {value}" for value in values)
        return self.line(f"call {self.number} @{intrinsic(name, self.lanes)}({listing})")

    def library(self, name: str, value: str) -> Register:
        """Return a function of the C library, such as ``tanh``: one call for each lane."""
        if self.lanes == 1:
            return self.line(f"call double @{name}(double {value})")
        result = "poison"
        for lane in range(self.lanes):
            own = self.line(f"extractelement {self.number} {value}, i32 {lane}")
            done = self.line(f"call double @{name}(double {own})")
            result = self.line(f"insertelement {self.number} {result}, double {done}, i32 {lane}")
        return result

    def call(self, function: str, *arrays: Register, noinline: bool = False) -> Register:
        """Return the status of a function of arrays and the mode, such as ``@f``.

        One that is not inlined rounds alike wherever it is called from.
        """
        listing = ", ".join(f"ptr {array}" for array in arrays)
        return self.line(f"call i32 {function}({listing}, i64 %mode){' noinline' * noinline}")

    def merge(self, status: Register, failed: Register) -> None:
        """Add a status to that of several calls, which is a variable."""
        so_far = self.get("i32", status)
        self.put("i32", status, self.line(f"or i32 {so_far}, {failed}"))

    def integer(self, operation: str, a: Index, b: Index) -> Register:
        """Return an operation on 64-bit integers, such as ``add`` or ``mul``."""
        return self.line(f"{operation} i64 {a}, {b}")

    @contextmanager
    def loop(self, start: Index, end: Index) -> Iterator[Register]:
        """Repeat what is written inside for start <= i < end; yields i."""
        mark = next(self._counter)
        cell = self.cell("i64", str(start))
        self.do(f"br label %head{mark}")
        self._lines.append(f"head{mark}:")
        i = self.get("i64", cell)
        more = self.line(f"icmp slt i64 {i}, {end}")
        self.do(f"br i1 {more}, label %body{mark}, label %done{mark}")
        self._lines.append(f"body{mark}:")
        yield i
        self.put("i64", cell, self.integer("add", i, 1))
        self.do(f"br label %head{mark}")
        self._lines.append(f"done{mark}:")

    @contextmanager
    def when(self, condition: Register) -> Iterator[None]:
        """Do what is written inside where a condition holds."""
        mark = self.fork(condition)
        yield
        self.do(f"br label %after{mark}")
        self.join(mark)

    def fork(self, condition: Register) -> int:
        """Begin what is done only where a condition holds and that returns; see ``join``."""
        mark = next(self._counter)
        self.do(f"br i1 {condition}, label %then{mark}, label %after{mark}")
        self._lines.append(f"then{mark}:")
        return mark

    def join(self, mark: int) -> None:
        """End what ``fork`` began."""
        self._lines.append(f"after{mark}:")

    def copy(self, source: Register, target: Register, size: int) -> None:
        """Copy an array."""
        with self.loop(0, size) as i:
            self.store(target, i, self.load(source, i))

    def give(self, value: str) -> None:
        """Return from the function."""
        self.do(f"ret {self._result} {value}")

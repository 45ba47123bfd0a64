"""The machine code of a mechanism: built once, kept on disk, called on arrays by address.

What each function takes, ``emission`` says. A status of 0 means that it worked.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from kinolab.dynamics.codegen.cache import COMPILED, Compiled
from kinolab.dynamics.codegen.compiled_functions import (
    CLOSED_LOOP_FUNCTIONS,
    NEED_CHART,
    PREFIX,
    SWITCHES,
)
from kinolab.dynamics.codegen.integrators import LANES, steppers
from kinolab.dynamics.codegen.llvm import in_lanes
from kinolab.dynamics.codegen.llvm_jit import link
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.dynamics.facts.machine_facts import QuasiVelocityFacts
from kinolab.numerics.arrays import Array

STATUS, POINTER, INTEGER = ctypes.c_int32, ctypes.c_void_p, ctypes.c_int64
STEP = ctypes.CFUNCTYPE(  # step(x, u, p, h, out, substeps, mode)
    STATUS, *(POINTER,) * 3, ctypes.c_double, POINTER, INTEGER, INTEGER
)
FUNCTIONS = (
    "rows_at",
    "rows_under",
    "tangent",
    "frames_tangent",
    "rows_between",
    "difference",
    "retract",
)
UNSOLVABLE = ("f", *NEED_CHART)  # have no result where they fail


class MachineCode:
    """The compiled functions of a mechanism.

    Args:
        key: By which it is kept on disk.
        build: Derives and compiles it, as ``derived_code``, where it is not there.
        closed: Whether it has feedback; functions of inputs are then functions of references.
        switches: Whether it has modes.

    Attributes:
        sizes: Length of each function's result, by the function's name.
        operations: Number of operations of the equations of motion, in the first mode.
        independent: Indices, among all velocities, of those that are states.
        quasi: The quasi-velocities that are states, before those.
        redundant: Names of constraints that follow from the others.
        methods: Of integration, by name.

    Raises:
        InputError: If the mechanism cannot be derived.
    """

    def __init__(
        self,
        key: str,
        build: Callable[[], Compiled],
        *,
        closed: bool,
        switches: bool = False,
    ) -> None:
        facts, code = COMPILED.get([key], build)
        self.sizes: dict[str, int] = facts["sizes"]
        self.operations: int = facts["operations"]
        self.independent: tuple[int, ...] = tuple(facts["independent"])
        self.quasi = tuple(QuasiVelocityFacts(*entry) for entry in facts["quasi"])
        self.redundant: tuple[str, ...] = tuple(facts["redundant"])
        steps = steppers()
        self.methods = tuple(METHODS)
        twice = (*CLOSED_LOOP_FUNCTIONS, *steps) if closed else ()
        self._closed = {name: PREFIX + name for name in twice}
        own = SWITCHES if switches else ()
        explicit = (f"step_{name}" for name, method in METHODS.items() if not method.implicit)
        self._in_lanes = [name + in_lanes(LANES) for name in ("f", *explicit) if facts["lanes"]]
        names = {*self.sizes, *FUNCTIONS, *steps, *own, *self._closed.values(), *self._in_lanes}
        self._library = link(code, names)
        # over rows of states, and over rows of states and inputs
        self._loops = [
            ctypes.CFUNCTYPE(INTEGER, *(POINTER,) * pointers, *(INTEGER,) * 3)(self.address(name))
            for name, pointers in (("rows_at", 4), ("rows_under", 5))
        ]
        self._steppers = {method: STEP(self.address(f"step_{method}")) for method in self.methods}

    def address(self, name: str) -> int:
        """Return the address of a C function, the closed loop's where there is feedback."""
        return self._library.address(self._closed.get(name, name))

    def in_lanes(self, method: str) -> tuple[int, int]:
        """Return the addresses of step and f of LANES states at once, 0 where there are none."""
        names = [name + in_lanes(LANES) for name in (f"step_{method}", "f")]
        if not self._in_lanes or names[0] not in self._in_lanes:
            return 0, 0
        step, f = map(self._library.address, names)
        return step, f

    def evaluate(
        self, name: str, tables: Sequence[Array], p: Array, out: Array, number: int = 0
    ) -> tuple[int, int]:
        """Evaluate a function of (x, p) or (x, u, p) at every row.

        Args:
            name: Of the function.
            tables: States (N, nx), and inputs (N, nu) where it has any; contiguous.
            p: Parameters, shape (np,).
            out: Results, shape (N, size); written.
            number: Of the transition, for ``through``.

        Returns:
            The first row that has no result and its status; status 0 where every row has one.
        """
        pointers = map(_pointer, (*tables, p, out))
        loop = self._loops[len(tables) - 1]
        row = loop(self.address(name), *pointers, *out.shape, number)
        if row < 0 or name not in UNSOLVABLE:
            return row, 0
        return row, bound(self.address(name), *(table[row] for table in tables), p, out[row])()

    def step(
        self, method: str, tables: Sequence[Array], p: Array, spans: Array, substeps: int
    ) -> tuple[int, int]:
        """Make an integrator step from every row, in order.

        Args:
            method: Of integration.
            tables: States (N, nx), inputs (N, nu) and the states after (N, nx), written; one of
                these may be the next row of the first.
            p: Parameters, shape (np,).
            spans: Lengths of the steps in [s], shape (N,).
            substeps: Of which each is made.

        Returns:
            The first row whose step fails and its status; status 0 where none does.
        """
        function, parameters = self._steppers[method], _pointer(p)
        (x, u, y), (dx, du, dy) = map(_pointer, tables), (table.strides[0] for table in tables)
        for k, span in enumerate(spans.tolist()):
            status = function(x + k * dx, u + k * du, parameters, span, y + k * dy, substeps, 0)
            if status:
                return k, status
        return -1, 0


def bound(address: int, *arrays: Any) -> Callable[[], int]:
    """Return a C function with its arguments bound: each call returns the status.

    Args:
        address: Of the function.
        arrays: Of NumPy or ctypes, of any shape; kept alive, read anew by every call.
    """
    pointers = [np.asarray(array).ctypes.data_as(POINTER) for array in arrays]
    return partial(
        ctypes.CFUNCTYPE(STATUS, *(POINTER,) * len(arrays), INTEGER)(address), *pointers, 0
    )


def _pointer(array: Array) -> int:
    return int(array.ctypes.data)

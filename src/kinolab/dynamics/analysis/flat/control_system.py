"""A machine as a control system x_dot = f(x, u), and its motions from random regular states."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinolab.dynamics.analysis.fields.linear_controllability import normals_at
from kinolab.dynamics.analysis.fields.system_fields import vector_fields
from kinolab.dynamics.analysis.fields.vector_fields import VectorFields
from kinolab.dynamics.analysis.flat.time_series import series_of
from kinolab.dynamics.analysis.jets.ranks import rank_of
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node
from kinolab.dynamics.language.inputs import Input, bounds_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.model.model import Model
from kinolab.numerics.arrays import Array


@dataclass(frozen=True, eq=False)
class ControlSystem:
    """The equations of motion x_dot = f(x, u) as nodes of an expression graph.

    Attributes:
        system: The machine, without feedback.
        fields: Its vector fields.
        tape: The expression graph.
        state: Nodes of x, shape (nx,).
        pushes: The inputs that count: as many as act along independent directions.
        idle: Those besides, which may be anything; half-way between their limits here.
        inputs: Nodes of those that count, u, shape (nu,).
        rates: Nodes of f, shape (nx,).
        model: A machine of the same states, compiled.
    """

    system: Mechanism
    fields: VectorFields
    tape: ExpressionGraph
    state: tuple[Node, ...]
    pushes: tuple[Input, ...]
    idle: tuple[Input, ...]
    inputs: tuple[Node, ...]
    rates: tuple[Node, ...]
    model: Model

    @classmethod
    def of(cls, system: Mechanism, model: Model | None = None) -> ControlSystem:
        """Derive a machine.

        Args:
            system: The machine, without feedback.
            model: A machine of the same states, if one is compiled.

        Raises:
            InputError: If it cannot be derived.
            ArithmeticError: If its equations are undefined at a random state.
        """
        fields = vector_fields(system)
        tape, count = fields.tape, len(fields.state) - fields.prolonged * len(system.inputs)
        pushes = system.inputs if fields.prolonged else _independent(system, fields)
        idle = tuple(entry for entry in system.inputs if entry not in pushes)
        nodes = {e.name: tape.variable(e.name) for e in pushes}
        nodes |= {e.name: tape.constant(sum(bounds_of(e)) / 2) for e in idle}
        rates = list(fields.drift[:count])
        for name, field in ({} if fields.prolonged else fields.inputs).items():
            pushed = [tape.mul(nodes[name], entry) for entry in field]
            rates = [tape.add(rate, push) for rate, push in zip(rates, pushed, strict=True)]
        return cls(
            system=system,
            fields=fields,
            tape=tape,
            state=fields.state[:count],
            pushes=pushes,
            idle=idle,
            inputs=tuple(nodes[entry.name] for entry in pushes),
            rates=tuple(rates),
            model=model or Model(system),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the state entries, shape (nx,)."""
        return self.fields.names[: len(self.state)]

    @cached_property
    def operations(self) -> int:
        """Number of operations of the equations of motion."""
        return len(self.tape.needed(self.rates))

    def without_effect(self) -> tuple[int, ...]:
        """Return the entries of the state on which no rate depends."""
        found = []
        for motion in self.motions():
            slopes = np.abs(motion.along(self.rates)[:, 0, : motion.dimension])
            slopes /= self.model.state_scales[:, None]
            # of the largest slope of a rate
            felt = slopes.max(axis=0) > 1e-12 * slopes.max(initial=1e-300)
            found.append(np.abs(motion.basis[:, felt]).max(axis=1, initial=0.0) == 0.0)
        return tuple(np.flatnonzero(np.all(found, axis=0)).tolist())

    def tangents(self, x: Array) -> Array:
        """Return directions in which a state may differ, in units of its scales, columns."""
        scales = self.model.state_scales
        normals = np.array([row * scales for row in normals_at(self.model, x)])
        if not len(normals):
            return np.diag(scales)
        _, values, rows = np.linalg.svd(normals)
        # 1e-9 of a normal: one that repeats the others
        return np.asarray(scales[:, None] * rows[int((values > 1e-9 * values[0]).sum()) :].T)

    def motions(self) -> Iterator[MotionSeries]:
        """Yield motions from a few random regular states under random inputs; deterministic."""
        generator = np.random.default_rng(0)
        for point in self.fields.points:
            x = np.array([point[name] for name in self.names])
            yield MotionSeries(self, x, generator)

    def motions_near_rest(self) -> Iterator[MotionSeries]:
        """Yield motions from a few states near rest and within limits; deterministic."""
        generator, model = np.random.default_rng(0), self.model
        lower, upper = model.state_bounds.T
        for point in self.fields.points:
            x = np.array([point[name] for name in self.names])
            if not self.fields.held and not model.space.spheres:
                # 0.2 of what counts as a large difference: no angle is beyond a quarter of a turn
                x = model.rest() + 0.2 * model.state_scales * generator.uniform(-1, 1, len(x))
            yield MotionSeries(self, np.clip(x, lower, upper), generator)


class MotionSeries:
    """A motion from a state as a series in time, with derivatives by the state and the inputs.

    Args:
        x: The first state, shape (nx,).
        generator: Draws the coefficients of the inputs.
        held: Constant inputs instead, shape (nu,), and the pace at which the state would change in
            [1/s].

    Attributes:
        order: Of the last coefficient that is known of the state.
        basis: Directions in which the first state is changed, columns, shape (nx, d).
    """

    def __init__(
        self,
        control: ControlSystem,
        x: Array,
        generator: np.random.Generator,
        *,
        held: tuple[Array, float] | None = None,
    ) -> None:
        self._control, self._generator, self._held = control, generator, held
        self.basis, self.order = control.tangents(x), 0
        self._x = np.hstack([x[:, None], self.basis])[:, None, :]  # (nx, orders, 1 + D)
        self._u: Array = np.empty((len(control.inputs), 0, 1))
        self._grow()

    @property
    def dimension(self) -> int:
        """Dimension d of the state manifold."""
        return int(self.basis.shape[1])

    @property
    def start(self) -> tuple[Array, Array]:
        """The first state, shape (nx,), and inputs, shape (nu,)."""
        return self._x[:, 0, 0], self._u[:, 0, 0]

    @property
    def work(self) -> int:
        """Multiplications that the next coefficient takes, about."""
        # A product of short series takes as long as 3000 multiplications.
        each = max((self.order + 1) ** 2 * self.width(self.order), 3_000)
        return self._control.operations * each

    def width(self, order: int) -> int:
        """Return the number of derivatives of a coefficient."""
        return self.dimension + len(self._control.inputs) * (order + 1)

    def extend(self) -> None:
        """Find one more coefficient of the state."""
        rates = series_of(self._control.tape, self._control.rates, self._variables())
        self.order += 1
        more = np.array([rate[-1:] for rate in rates]) / self.order
        self._x = np.concatenate([self._x, more], axis=1)
        self._grow()

    def values(self, nodes: Sequence[Node]) -> Array:
        """Return the coefficients of functions of the state, shape (n, order + 1)."""
        return np.array(series_of(self._control.tape, nodes, self._variables()))[:, :, 0]

    def along(self, nodes: Sequence[Node]) -> Array:
        """Return the derivatives of functions of the state along the motion.

        Returns:
            Of each coefficient of each function by the state (d) and by each coefficient of the
            inputs (nu each), all in units of their scales; shape (n, order + 1, d + nu * orders).
        """
        found = np.array(series_of(self._control.tape, nodes, self._variables()))
        return np.asarray(found[:, :, 1:] * self._units)

    @property
    def pace(self) -> float:
        """How quickly the state changes, in its scales: one over a radius of convergence, [1/s]."""
        if self._held is not None:
            return self._held[1]
        sizes = np.abs(self._x[:, 1:, 0]).T / self._control.model.state_scales
        k = np.arange(1, self.order + 1)
        # 1e-6 [1/s]: a motion that stands still
        return float(np.max(sizes.max(axis=1) ** (1 / k), initial=1e-6))

    @property
    def _units(self) -> Array:
        """Scales of the state's directions and of the inputs' coefficients."""
        ranges = np.array([np.ptp(bounds_of(u)) / 2 for u in self._control.pushes])
        powers = self.pace ** np.arange(self.order + 1.0)
        return np.concatenate([np.ones(self.dimension), np.outer(powers, ranges).ravel()])

    def _variables(self) -> Mapping[str, Array | float]:
        inputs = [entry.name for entry in self._control.pushes]
        known: dict[str, Array | float] = dict(self._control.fields.values)
        known |= dict(zip(self._control.names, self._x, strict=True))
        return known | dict(zip(inputs, self._u, strict=True))

    def _grow(self) -> None:
        """Let the inputs have one more coefficient, and all series its derivatives."""
        count, orders = len(self._u), self.order + 1
        wider = self._x.shape[2] + count
        self._x = np.pad(self._x, ((0, 0), (0, 0), (0, count)))
        grown = np.zeros((count, orders, wider))
        grown[:, : orders - 1, : self._u.shape[2]] = self._u if orders > 1 else 0.0
        grown[:, -1, 0] = self._drawn(orders) if self._held is None else self._constant(orders)
        grown[range(count), -1, range(wider - count, wider)] = 1.0
        self._u = grown

    def _drawn(self, orders: int) -> Array:
        """Return random coefficients, well within limits: a thrust must not be negative."""
        lower, upper = np.array([bounds_of(u) for u in self._control.pushes]).T
        draws = self._generator.normal(size=len(lower))
        share = 0.5 + 0.25 * np.tanh(draws) if orders == 1 else 0.1 * draws
        return np.asarray((lower if orders == 1 else 0.0) + share * (upper - lower))

    def _constant(self, orders: int) -> Array:
        assert self._held is not None
        return self._held[0] if orders == 1 else np.zeros_like(self._held[0])


def _independent(system: Mechanism, fields: VectorFields) -> tuple[Input, ...]:
    """Return the inputs whose fields are independent of those before them at a regular state."""
    chosen, rows = list[Input](), list[list[float]]()
    values = dict(fields.values) | dict(fields.points[0])
    for entry in system.inputs:
        try:
            row = fields.tape.evaluate(fields.inputs[entry.name], values)
        except ValueError as error:  # such as the logarithm of a negative number
            raise ArithmeticError(str(error)) from error
        if rank_of(np.array([*rows, row])).value > len(rows):
            chosen.append(entry)
            rows.append(row)
    return tuple(chosen)

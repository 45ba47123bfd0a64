"""Consistent initial values: constraint violations, and projection onto the constraints.

Source: Hairer, Wanner, Solving ODEs II, 2nd ed., section VII.1 (consistent initial values).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy

from kinolab.dynamics.codegen.state_space import whole_turns
from kinolab.dynamics.model.model import Model
from kinolab.numerics.arrays import Array

if TYPE_CHECKING:
    from kinolab.dynamics.language.constraints import Constraint

CONSTRAINT_TOLERANCE = 1e-9  # [m/s] or [rad/s], of loops [m] or [rad]; allows for rounding only
# of the scales: perturbation of the initial guesses
PERTURBATION_SCALES = (0.0, *(8 * (0.3, 1.0, 2.0)))


@dataclass(frozen=True)
class ConstraintViolation:
    """A constraint that a state violates.

    Attributes:
        name: Name of the constraint.
        size: Violation in ``unit``.
        unit: m or rad of a position constraint, m/s or rad/s of a velocity constraint.
    """

    name: str
    size: float
    unit: str


def constraint_violations(model: Model, x: Array) -> tuple[ConstraintViolation, ...]:
    """Return the constraints violated at a state, shape (nx,).

    Checks position constraints, and velocity constraints where all rates are states; elsewhere
    the dependent rates follow from the others.
    """
    return tuple(
        breach for breach in _residuals(model.plant, x) if breach.size > CONSTRAINT_TOLERANCE
    )


def nearest_consistent_state(model: Model, x: Array, limits: Array) -> Array | None:
    """Return the nearest consistent state, shape (nx,); None if none is found.

    The nearest configuration first, then the nearest velocities there, both in units of the
    states' scales.

    Args:
        x: State, shape (nx,).
        limits: Lower and upper limits of the state, kept by the configuration, shape (nx, 2).
    """
    plant, found = model.plant, np.array(x, dtype=float)
    if (loops := _LoopClosure(plant, _constraints_at(plant, x))).count:
        q = loops.nearest(found[: plant.nq], limits[: plant.nq])
        if q is None:
            return None
        found[: plant.nq] = q
    if plant.machine.all_rates:
        found = _without_slip(plant, found)
    return None if constraint_violations(plant, found) else found


def _residuals(plant: Model, x: Array) -> Iterator[ConstraintViolation]:
    if not (plant.machine.all_rates or plant.machine.closes_loops):
        return
    from kinolab.dynamics.analysis.constraint_units import (  # late: they are derived
        position_unit,
        velocity_unit,
    )

    if plant.machine.all_rates:
        slips = np.abs(plant.constraint_residual(x))  # none of those of other modes
        for constraint, slip in zip(plant.system.all_constraints, slips.tolist(), strict=False):
            yield ConstraintViolation(constraint.name, slip, velocity_unit(constraint))
    loops = _LoopClosure(plant, _constraints_at(plant, x), redundant=True)
    gaps = np.abs(loops.gaps(x[: plant.nq])).tolist()
    for constraint, gap in zip(loops.constraints, gaps, strict=True):
        yield ConstraintViolation(constraint.name, gap, position_unit(constraint))


def _constraints_at(plant: Model, x: Array) -> tuple[Constraint, ...]:
    """Return what holds at a state, shape (nx,): always, and in its mode."""
    system = plant.system
    own = system.modes[int(x[-1])].constraints if system.modes else ()
    return (*system.constraints, *own)


def _without_slip(plant: Model, x: Array) -> Array:
    """Project a state's velocities onto the constraints."""
    still, moving = x.copy(), slice(plant.nq, plant.nq + plant.nt)
    still[moving] = 0.0
    sizes = plant.state_scales[moving]
    units = still + np.eye(len(x))[moving] * sizes[:, None]
    rows = plant.constraint_residual(units)[:, : len(plant.machine.constraints)].T
    shares = x[moving] / sizes
    still[moving] = (shares - np.linalg.pinv(rows, rcond=1e-12) @ (rows @ shares)) * sizes
    return still


class _LoopClosure:
    """Position constraints h(q) = 0, unit quaternion norms included.

    Attributes:
        constraints: Without redundant ones, unless requested.
        count: Number of equations.
    """

    def __init__(
        self, plant: Model, constraints: Sequence[Constraint], *, redundant: bool = False
    ) -> None:
        from kinolab.dynamics.derivation.sampled_states import gradient
        from kinolab.dynamics.derivation.symbol_table import SymbolTable
        from kinolab.dynamics.language.constraints import PositionConstraint

        self.constraints = [
            c
            for c in constraints
            if isinstance(c, PositionConstraint) and (redundant or c.name not in plant.redundant)
        ]
        self.count = len(self.constraints)
        self._plant, self._scales = plant, plant.state_scales[: plant.nq]
        self._parameters = plant.system.parameter_values
        self._binding = SymbolTable.of(plant.system)
        self._gaps = [self._binding.lower(c.position) for c in self.constraints]
        self._slopes = [node for gap in self._gaps for node in gradient(self._binding, gap)]

    def gaps(self, q: Array) -> Array:
        """Return h(q), shape (count,)."""
        return self._evaluated(self._gaps, q)

    def nearest(self, q: Array, limits: Array) -> Array | None:
        """Return the configuration nearest to q with h = 0, shape (nq,)."""
        generator = np.random.default_rng(0)
        found = []
        for spread in PERTURBATION_SCALES:
            begin = q + spread * self._scales * generator.normal(size=len(q))
            near = self._near(q, np.clip(begin, *limits.T), limits)
            if near is not None:
                found.append(near)
        return min(found, key=lambda near: np.linalg.norm((near - q) / self._scales), default=None)

    def _near(self, q: Array, begin: Array, limits: Array) -> Array | None:
        """Return a locally nearest configuration, by SQP from an initial guess.

        Source: Kraft, A software package for sequential quadratic programming, DFVLR 1988.
        """
        sizes = self._scales
        try:
            result = scipy.optimize.minimize(
                lambda s: 0.5 * float(np.sum((s - q / sizes) ** 2)),
                begin / sizes,
                jac=lambda s: s - q / sizes,
                method="SLSQP",
                bounds=limits / sizes[:, None],
                constraints={
                    "type": "eq",
                    "fun": lambda s: self._missing(s * sizes),
                    "jac": lambda s: self._rows(s * sizes) * sizes,
                },
                options={"ftol": 1e-14, "maxiter": 200},
            )
            near = self._closed(result.x * sizes)
            free = self._plant.circular[: len(q)] & ~np.isfinite(limits).any(axis=1)
            near -= np.where(free, whole_turns(near - q), 0.0)  # of unlimited angles
            held = np.abs(self._missing(near)).max() <= CONSTRAINT_TOLERANCE
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None  # the expressions are undefined there
        inside = (
            (near >= limits[:, 0] - CONSTRAINT_TOLERANCE)
            & (near <= limits[:, 1] + CONSTRAINT_TOLERANCE)
        ).all()
        return near if held and inside else None

    def _closed(self, q: Array) -> Array:
        """Refine a configuration by least-norm Newton steps."""
        for _ in range(10):  # of Newton's method, after the optimisation
            rows = self._rows(q) * self._scales
            q = q - self._scales * (np.linalg.pinv(rows, rcond=1e-12) @ self._missing(q))
        return q

    def _missing(self, q: Array) -> Array:
        lengths = [q[part.own] @ q[part.own] - 1.0 for part in self._plant.space.spheres]
        return np.concatenate([self.gaps(q), lengths])

    def _rows(self, q: Array) -> Array:
        """Return the Jacobian of the residual by q."""
        slopes = self._evaluated(self._slopes, q).reshape(self.count, -1)
        spheres = self._plant.space.spheres
        lengths = np.zeros((len(spheres), len(q)))
        for row, part in zip(lengths, spheres, strict=True):
            row[part.own] = 2 * q[part.own]
        return np.vstack([slopes, lengths])

    def _evaluated(self, nodes: list[int], q: Array) -> Array:
        values = self._parameters | dict(zip(self._plant.coordinate_names, q.tolist(), strict=True))
        return np.array(self._binding.tape.evaluate(nodes, values))

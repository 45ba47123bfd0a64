"""Controllability and stabilisability of the linearisation about an equilibrium."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kinolab.arguments import checked
from kinolab.dynamics.analysis.fields.vector_fields import combination_text
from kinolab.dynamics.analysis.jets.ranks import RANK_TOLERANCE, reduced_rows
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.velocity_coordinates import constraint_rows
from kinolab.dynamics.model.model import Model
from kinolab.errors import InputError, Mistake, UnknownNameError
from kinolab.numerics.arrays import Array


def reachable_subspace(A: Array, B: Array, tolerance: float = RANK_TOLERANCE) -> Array:
    """Return an orthonormal basis of the span of B, A B, A^2 B, …

    Blocks are orthogonalised one by one, so that no power of A is formed (Kalman's matrix loses
    all precision for ten states).

    Args:
        A: Shape (n, n).
        B: Shape (n, m).
        tolerance: Fraction of the norm of A, or of B, below which a direction counts as zero.

    Returns:
        Shape (n, rank).

    Source: Rosenbrock, State-space and Multivariable Theory, 1970 (the staircase); Paige,
    Properties of numerical algorithms related to computing controllability, IEEE Trans. Automatic
    Control 26(1), 1981.
    """
    A, B = np.asarray(A, dtype=float), np.asarray(B, dtype=float)
    size = np.abs(B).max(axis=0, initial=0.0)
    basis = np.empty((len(A), 0))
    felt = size > np.finfo(float).eps * size.max(initial=0.0)  # others are rounding
    block = B[:, felt] / size[felt]
    largest = 1.0
    while block.size:
        block = block - basis @ (basis.T @ block)
        block = block - basis @ (basis.T @ block)  # reorthogonalise against rounding
        left, values, _ = np.linalg.svd(block, full_matrices=False)
        fresh = left[:, values > tolerance * largest]
        basis = np.hstack([basis, fresh])
        block, largest = A @ fresh, max(float(np.linalg.norm(A, 2)), 1e-300)
    return basis


EQUILIBRIUM_TOLERANCE = 1e-6  # of a state's scale per second


@checked
@dataclass(frozen=True)
class LinearControllability:
    """Controllability of the linearisation about an equilibrium.

    Attributes:
        rank: Dimension of the controllable subspace, by Kalman's condition.
        dimension: Of the state space.
        directions: Uncontrollable combinations of states, as text in state names.
        modes: Eigenvalues of the uncontrollable modes in [1/s].
    """

    rank: int
    dimension: int
    directions: tuple[str, ...]
    modes: tuple[complex, ...]

    @property
    def controllable(self) -> bool:
        """Whether the linearisation is controllable."""
        return self.rank == self.dimension

    @property
    def stabilisable(self) -> bool:
        """Whether all uncontrollable modes decay (Hautus)."""
        # 1e-6 [1/s]; modes with real part below its negative count as decaying
        return all(mode.real < -1e-6 for mode in self.modes)


@checked
def linear_controllability(
    model: Model,
    x: ArrayLike,
    u: ArrayLike = (),
    *,
    without: Collection[str] = (),
    tolerance: float = RANK_TOLERANCE,
) -> LinearControllability:
    """Analyse the linearisation about an equilibrium, by a model's exact Jacobians.

    States and inputs are scaled by ``state_scales`` and by the inputs' ranges first.

    Args:
        x: The equilibrium, shape (nx,).
        u: Inputs that hold it, shape (nu,); zero when left out.
        without: Names of states to leave out: cyclic ones, on which no other depends and which
            may change steadily, such as a wheel's angle in a steady motion.
        tolerance: Fraction of the norm of A below which a direction counts as uncontrollable.

    Raises:
        InputError: If x is no equilibrium, or a state depends on one left out.

    Source: Kalman, Ho, Narendra, Contributions to Differential Equations 1, 1963; Hautus, Indag.
    Math. 31, 1969.
    """
    state, kept = np.asarray(x, dtype=float), _kept(model, without)
    names, scales = [model.state_names[i] for i in kept], model.state_scales[kept]
    _check_rest(model, names, model.f(state, u)[kept] / scales)
    A, B = model.jacobian(state, u)
    _check_apart(model, names, np.delete(A, kept, axis=1)[kept] / scales[:, None])
    A = A[np.ix_(kept, kept)] * scales / scales[:, None]
    B = B[kept] * np.ptp(model.control_bounds, axis=1) / 2 / scales[:, None]
    reached = reachable_subspace(A, B, tolerance)
    normals = np.array([row[kept] * scales for row in normals_at(model, state)])
    normals = normals.reshape(-1, len(kept))
    left, values, _ = np.linalg.svd(np.hstack([reached, normals.T]), full_matrices=True)
    rest = left[:, int((values > RANK_TOLERANCE).sum()) :]  # orthonormal, the complement of both
    rows = rest.T / scales
    largest = np.abs(rows).max(axis=1, keepdims=True, initial=0.0)
    rows = reduced_rows(rows / np.where(largest > 0, largest, 1.0))
    return LinearControllability(
        rank=reached.shape[1],
        dimension=len(kept) - len(normals),
        directions=tuple(combination_text(row, names) for row in rows),
        modes=tuple(complex(mode) for mode in np.linalg.eigvals(rest.T @ A @ rest)),
    )


def normals_at(model: Model, x: Array) -> Iterator[Array]:
    """Yield the gradients, each of shape (nx,), of equations that states satisfy: unit quaternions,
    position constraints, and velocity constraints where all rates are states."""
    for part in model.space.rotations:
        normal = np.zeros(model.nx)
        normal[part.own] = x[part.own]
        yield normal
    system = model.system
    binding = SymbolTable.of(system)
    rows = [r for r in constraint_rows(binding) if r.name not in model.redundant]
    closed = {constraint.name for constraint in system.closures}
    values = dict(zip(model.state_names, map(float, x), strict=True)) | system.parameter_values
    for row in rows:
        try:
            covector: Array = np.array(binding.tape.evaluate(row.covector, values), dtype=float)
        except KeyError:
            continue  # it depends on an input
        if row.name in closed:
            normal = np.zeros(model.nx)
            normal[: model.nq] = covector @ np.linalg.pinv(flow_matrix(binding, values))
            yield normal
        if system.velocities == "all":
            yield np.concatenate([np.zeros(model.nq), covector, np.zeros(len(system.states))])


def flow_matrix(binding: SymbolTable, values: dict[str, float]) -> Array:
    """Return G with q_dot = G nu at a configuration, shape (nq, nt)."""
    tape = binding.tape
    columns = [tape.derivative(binding.flow_rows, {v: tape.one}) for v in binding.tangent]
    flat = tape.evaluate([node for column in columns for node in column], values)
    return np.reshape(flat, (len(columns), -1)).T


def _kept(model: Model, without: Collection[str]) -> list[int]:
    for name in without:
        if name not in model.state_names:
            raise UnknownNameError("state", name, known=model.state_names)
    return [i for i, name in enumerate(model.state_names) if name not in without]


def _check_apart(model: Model, names: Sequence[str], slopes: Array) -> None:
    """Reject leaving out states that others depend on."""
    if slopes.size and np.abs(slopes).max() > EQUILIBRIUM_TOLERANCE:
        worst = names[int(np.abs(slopes).max(axis=1).argmax())]
        what = f"{worst} depends on a state that is left out."
        raise InputError([Mistake(f"system {model.system.name!r}", what, "Leave fewer out.")])


def _check_rest(model: Model, names: Sequence[str], rates: Array) -> None:
    worst = int(np.abs(rates).argmax())
    if not abs(rates[worst]) <= EQUILIBRIUM_TOLERANCE:
        what = f"it does not stay there: {names[worst]} changes."
        remedy = "Give an equilibrium with the inputs that hold it, or leave states out (without)."
        raise InputError([Mistake(f"system {model.system.name!r}", what, remedy)])

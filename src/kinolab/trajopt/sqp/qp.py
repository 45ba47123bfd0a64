"""The convex subproblem as a sparse quadratic program over all knots.

Variables, all scaled: steps in states, inputs and step length, slacks of goal and inequalities, and
the fraction of all defects left open. With that fraction (Powell's) the program is feasible for any
limits and trust region.

Source: Powell, A fast algorithm for nonlinearly constrained optimization calculations, 1978;
solver: Schwan, Jiang, Kuhn, Jones, PIQP: a proximal interior-point quadratic programming solver,
CDC 2023.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.trajopt.nlp.decision import Scaling
from kinolab.trajopt.nlp.linearization import Linearization
from kinolab.trajopt.nlp.options import SQP
from kinolab.trajopt.nlp.path_constraints import LinearInequalities
from kinolab.trajopt.sqp.subproblem import Step, Subproblem, TrustRegion


# 15 iterations of PIQP, of which few programs need more than 25
def program_seconds(steps: int, variables: int, rows: int, iterations: int = 15) -> float:
    """Return the work of a quadratic program in [s].

    Args:
        steps: Of the motion.
        variables: States and inputs of each.
    """
    return 1.2e-3 + iterations * (3.5e-8 * steps * variables**2 + 8e-7 * rows)


def solve(given: Subproblem, accuracy: float = 1e-9) -> Step | None:
    """Return the optimal step within the trust region; None if the solver fails.

    Args:
        accuracy: Scaled tolerance of the solution.
    """
    import piqp  # imported here: nothing else needs it

    linearization, scaling, weights = given.linearization, given.scaling, given.weights
    knots, rows = linearization.knots, given.rows
    nx, nu, steps = knots.x.shape[1], knots.u.shape[1], len(knots.u)
    columns = _Columns(nx, nu, steps, rows, len(linearization.goal_residual), len(knots.lengths))
    open_defects = linearization.open_defects(scaling)
    missing = linearization.violation(scaling)
    A, b = _equalities(linearization, scaling, columns)
    G, low = _inequalities(rows, scaling, columns)
    P, c = _cost(given, columns, open_defects)
    lower, upper = _limits(given.region, columns, open_defects)
    solver = piqp.SparseSolver()
    settings = solver.settings
    settings.eps_abs, settings.eps_rel = accuracy, accuracy
    settings.max_iter = 60
    settings.reg_lower_limit = SQP.regularisation
    spent = weights.spent * float(knots.x[-1, weights.entry])
    worst = weights.penalty * missing + weights.time * knots.duration + spent
    settings.eps_duality_gap_abs = max(SQP.optimality_tolerance * worst, accuracy)
    solver.setup(P, c, A, b, G, low, np.full(len(low), np.inf), lower, upper)
    status = solver.solve()
    charge(program_seconds(steps, nx + nu, len(rows.knot), int(solver.result.info.iter)))
    if status not in (piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED):
        return None
    z = np.asarray(solver.result.x)
    if not np.isfinite(z).all():
        return None
    z = np.clip(z, lower, upper)
    predicted = weights.penalty * missing - float(c @ z + 0.5 * z @ (P @ z))
    return given.step(z[columns.x], z[columns.u], z[columns.h], predicted)


class _Columns:
    """Column indices of the variables: grouped by knot, global ones last."""

    def __init__(
        self, nx: int, nu: int, steps: int, rows: LinearInequalities, goals: int, phases: int
    ) -> None:
        last = np.full(nx, steps)
        stage = np.concatenate(
            [
                np.repeat(np.arange(steps), nx),
                last,
                np.repeat(np.arange(steps), nu),
                rows.knot,
                np.full(2 * goals, steps),
                np.full(phases + 1, steps + 1),
            ]
        )
        self.size = len(stage)
        place = np.empty(self.size, dtype=np.int64)
        place[np.argsort(stage, kind="stable")] = np.arange(self.size)
        parts = np.cumsum([(steps + 1) * nx, steps * nu, len(rows.knot), goals, goals])
        x, u, slack, over, under, rest = np.split(place, parts)
        self.x, self.u = x.reshape(steps + 1, nx), u.reshape(steps, nu)
        self.slack, self.over, self.under = slack, over, under
        self.h, self.left = rest[:-1], rest[-1]


def _matrix(entries: list[tuple[Any, Any, Any]], shape: tuple[int, int]) -> Any:
    """Return a sparse matrix from (row, column, value) triples, broadcast against each other."""
    parts = [np.broadcast_arrays(*entry) for entry in entries]
    row, column, value = (np.concatenate([part[k].ravel() for part in parts]) for k in range(3))
    return scipy.sparse.csc_matrix((value, (row, column)), shape=shape)


def _equalities(linearization: Linearization, scaling: Scaling, at: _Columns) -> tuple[Any, Array]:
    """Return the equality constraints A z = b: dynamics, start and goal."""
    steps, nx = linearization.defects.shape
    nu, phase = len(scaling.u), linearization.knots.phase[:, None]
    defects = linearization.defects / scaling.x
    tangents = linearization.sensitivities / scaling.x[:, None]
    row = np.arange(steps * nx).reshape(steps, nx)
    first = steps * nx + np.arange(nx)
    goal = (steps + 1) * nx + np.arange(len(linearization.goal_residual))
    entries = [
        (row, at.x[1:], 1.0),
        (row[:, :, None], at.x[:-1, None, :], -tangents[:, :, :nx] * scaling.x),
        (row[:, :, None], at.u[:, None, :], -tangents[:, :, nx : nx + nu] * scaling.u),
        (row, at.h[phase], -tangents[:, :, -1] * linearization.knots.lengths[phase]),
        (row, at.left, defects),
        (first, at.x[0], 1.0),
        (goal[:, None], at.x[-1], linearization.goal_jacobian * scaling.x),
        (goal, at.over, 1.0),
        (goal, at.under, -1.0),
    ]
    size = (steps + 1) * nx + len(linearization.goal_residual)
    right = np.concatenate([defects.ravel(), np.zeros(nx), -linearization.goal_residual])
    return _matrix(entries, (size, at.size)), right


def _inequalities(rows: LinearInequalities, scaling: Scaling, at: _Columns) -> tuple[Any, Array]:
    """Return the constraints value + derivative * step + slack >= 0 as G z >= low."""
    row = np.arange(len(rows.knot))
    here = np.minimum(rows.knot, len(at.u) - 1)  # the last knot has no inputs of its own
    after = np.minimum(rows.knot + 1, len(at.x) - 1)
    entries = [
        (row[:, None], at.x[rows.knot], rows.dx * scaling.x),
        (row[:, None], at.x[after], rows.dx_next * scaling.x),
        (row[:, None], at.u[here], rows.du * scaling.u),
        (row, at.slack, 1.0),
    ]
    return _matrix(entries, (len(row), at.size)), -rows.value


def _cost(given: Subproblem, at: _Columns, open_defects: float) -> tuple[Any, Array]:
    knots, scaling, weights = given.linearization.knots, given.scaling, given.weights
    steps, nu = knots.u.shape
    square, linear = np.full(at.size, SQP.step_damping), np.zeros(at.size)
    fraction = np.divide(knots.u, scaling.u)
    linear[at.h] = weights.time * knots.counts * knots.lengths
    linear[at.u] = 2 * weights.effort * fraction / max(steps * nu, 1)
    square[at.u] += 2 * (weights.effort + weights.stay) / max(steps * nu, 1)
    square[at.x] += 2 * weights.stay / knots.x.size
    for part in (at.slack, at.over, at.under):
        linear[part] = weights.penalty
    linear[at.left] = weights.penalty * open_defects
    linear[at.x[-1, weights.entry]] += weights.spent * scaling.x[weights.entry]
    diagonal = scipy.sparse.diags(square, format="csc")
    if given.curvature is None:
        return diagonal, linear
    own = np.hstack([at.x[:-1], at.u])
    blocks = (own[:, :, None], own[:, None, :], given.curvature)
    return diagonal + _matrix([blocks], (at.size, at.size)), linear


def _limits(limits: TrustRegion, at: _Columns, open_defects: float) -> tuple[Array, Array]:
    """Return lower and upper bounds of all variables, shape (n,) each."""
    lower, upper = np.empty(at.size), np.empty(at.size)
    for place, (least, most) in ((at.x, limits.x), (at.u, limits.u), (at.h, limits.h)):
        lower[place], upper[place] = least, most
    for part in (at.slack, at.over, at.under):
        lower[part], upper[part] = 0.0, np.inf
    lower[at.left], upper[at.left] = 0.0, float(open_defects > SQP.no_defect)
    lower[at.x[0]], upper[at.x[0]] = -np.inf, np.inf  # fixed by an equation
    return lower, upper

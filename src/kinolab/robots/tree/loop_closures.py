"""Equations that close loops of links, without those that always hold.

Two links of a planar mechanism never part across its plane, so that only two of the three equations
of a point that they share say anything. Directions in which nothing moves are found where random
configurations are closed, and left out. What several closures demand together, kinolab's derivation
compares once more.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np
import sympy

from kinolab.dynamics import System
from kinolab.dynamics.derivation.sampled_states import feasible_values
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.constraints import PositionConstraint, closed
from kinolab.dynamics.language.frames import Frame, Motion, Rotation, Translation, turn_matrix
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.robots.tree.constant_frames import ROUNDING

STILL = 1e-9  # [m/rad] and the like, of a direction in which nothing moves
OPEN = 1e-6  # [m] or [rad] by which frames may be apart that cannot move: what files round
AXES = "xyz"


def closing_constraints(
    name: str, first: Frame, second: Frame, *, turns: bool, where: str
) -> Iterator[PositionConstraint]:
    """Yield the constraints under which two frames coincide, as few as it takes.

    Args:
        name: Of what closes the loop.
        turns: Whether their axes coincide, too, not only their origins.
        where: What mistakes are reported for.

    Raises:
        InputError: If no configuration is found in which they do.
    """
    first, second = Frame(first.after(second)), Frame(second.after(first))
    equations = [*_apart(first, second)]
    if turns:
        equations += _turned(first, second)
    slopes = _slopes(name, equations, [first, second], where)
    for k, kind in enumerate(("along", "about")[: len(equations) // 3]):
        triple = slice(3 * k, 3 * k + 3)
        for axis, direction in _moving(np.hstack([*slopes[:, triple]])).items():
            weighted = zip(direction, equations[triple], strict=True)
            equation = sympy.Add(
                *((1 if w == 1.0 else float(w)) * entry for w, entry in weighted if w)
            )
            yield closed(equation, f"{name} {kind} {axis}")


def _apart(first: Frame, second: Frame) -> list[sympy.Expr]:
    """Return how far the origins are apart, in [m]."""
    origin = sympy.zeros(3, 1)
    return list(_carried(second.motions, origin) - _carried(first.motions, origin))


def _turned(first: Frame, second: Frame) -> list[sympy.Expr]:
    """Return how frames are turned to each other: 2 n tan(angle / 2) of the rotation about n.

    These Rodrigues parameters are 0 for equal axes only, not for opposite ones.
    """
    turns = [
        [motion for motion in frame.motions if not isinstance(motion, Translation)]
        for frame in (first, second)
    ]
    a, b = ([_carried(chain, sympy.eye(3).col(k)) for k in range(3)] for chain in turns)
    R = sympy.Matrix(3, 3, lambda j, k: a[j].dot(b[k]))
    half = (1 + R.trace()) / 2
    return [(R[k, j] - R[j, k]) / half for j, k in ((1, 2), (2, 0), (0, 1))]


def _carried(motions: Sequence[Motion], point: sympy.Matrix) -> sympy.Matrix:
    """Return the place of a point (3, 1) of the last frame in the first one.

    From the last motion on, and with constant rotations as numbers, so that terms stay few.
    """
    for still, group in groupby(reversed(motions), _is_constant):
        chain = [*group][::-1]
        if still:
            point = _product([m for m in chain if isinstance(m, Rotation)]) * point
            continue
        for motion in reversed(chain):
            if isinstance(motion, Translation):
                point = point + sympy.Matrix(motion.by)
            else:
                point = turn_matrix(motion) * point
    return point


def _is_constant(motion: Motion) -> bool:
    return isinstance(motion, Rotation) and not motion.angle.free_symbols


def _product(turns: Sequence[Rotation]) -> sympy.Matrix:
    """Return the product of constant rotations, whose whole numbers are exact."""
    whole = np.eye(3)
    for motion in turns:
        whole = whole @ np.array(turn_matrix(motion).tolist(), dtype=np.float64)
    nearest = np.rint(whole)
    return sympy.Matrix(
        3,
        3,
        [
            sympy.Integer(int(n)) if abs(entry - n) < ROUNDING else sympy.Float(entry)
            for entry, n in zip(whole.ravel(), nearest.ravel(), strict=True)
        ],
    )


def _slopes(
    name: str, equations: Sequence[sympy.Expr], frames: Sequence[Frame], where: str
) -> Array:
    """Return the equations' derivatives by velocities, where they hold.

    Shape (configurations, equations, velocities).
    """
    constraints = [closed(entry, str(k)) for k, entry in enumerate(equations)]
    bodies = [Body(str(k), frame) for k, frame in enumerate(frames)]
    system = System("loop", bodies=bodies, constraints=constraints)
    if not system.coordinates:
        return _of_what_is_rigid(name, equations, where)
    binding = SymbolTable.of(system)
    tape, nodes = binding.tape, []
    for entry in equations:
        (rate,) = tape.derivative([binding.lower(entry)], binding.flow())
        nodes += [tape.derivative([rate], {v: tape.one})[0] for v in binding.tangent]
    found = [tape.evaluate(nodes, values) for values in feasible_values(binding)]
    if not found:
        what = f"no configuration was found in which {name} closes its loop."
        raise InputError([Mistake(where, what, "Its links may be too short, or limited.")])
    return np.reshape(found, (len(found), len(equations), -1))


def _of_what_is_rigid(name: str, equations: Sequence[sympy.Expr], where: str) -> Array:
    """Return no slopes of what cannot move, if it is closed."""
    gap = max(abs(float(entry)) for entry in equations)
    if gap > OPEN:
        what = f"{name} holds parts together that cannot move and are {gap:.3g} apart."
        raise InputError([Mistake(where, what, "Is a joint locked where its loop is open?")])
    return np.zeros((1, len(equations), 1))


def _moving(slopes: Array) -> dict[str, Array]:
    """Return orthogonal directions (3,) that span all in which something moves, by nearest axis.

    Args:
        slopes: Shape (3, n).
    """
    vectors, sizes, _ = np.linalg.svd(slopes)
    rank = int((sizes > STILL * max(1.0, float(sizes[0]))).sum())
    if rank == 3:
        return dict(zip(AXES, np.eye(3), strict=True))
    if rank < 2:
        return {AXES[int(np.abs(v).argmax())]: _along_axes(v) for v in vectors.T[:rank]}
    normal = _along_axes(vectors[:, 2])
    i, j = (k for k in range(3) if k != np.abs(normal).argmax())
    first = np.eye(3)[i] - normal[i] * normal
    first /= np.linalg.norm(first)
    return {AXES[i]: first, AXES[j]: _along_axes(np.cross(normal, first))}


def _along_axes(direction: Array) -> Array:
    """Return a direction without rounding, towards the positive end of its main axis."""
    clean: Array = np.where(np.abs(direction) < ROUNDING, 0.0, direction)
    clean /= np.linalg.norm(clean)
    return clean * float(np.sign(clean[np.abs(clean).argmax()]))
